"""The report of a design, as Markdown."""

from __future__ import annotations

from collections.abc import Sequence

from ...ground.units import coordinate_unit, effort_unit
from ...ground.wording import counted
from ...sizing import Sizing
from .outcome import Outcome

_ROUNDING = 1e-9  # of numbers in SI units
_ENDS_ON = {"A": "arm", "B": "k2", "C": "arm", "D": "k2"}  # link that carries the arm on


def report_text(outcome: Outcome, robot_class: str, picture: str = "picture.svg") -> str:
    """The report: structure, loops, duty cycle, drives.

    Args:
        outcome: what the robot does in its duty cycle.
        robot_class: I, II or III.
        picture: file of its picture; empty for none.
    """
    robot = outcome.robot
    lines = [f"# {robot.name}", ""]
    if picture:
        lines += [f"![{robot.name}]({picture})", ""]
    counts = (
        counted(len(robot.active), "degree", "degrees") + " of freedom",
        counted(len(robot.coordinates), "coordinate"),
        counted(len(robot.loops), "loop"),
    )
    lines += [
        f"Class {robot_class} of Chu et al. (2020): {', '.join(counts)}.",
        "",
        *_loop_table(outcome),
        *_drive_table(outcome),
    ]
    for drive, sizing in outcome.sizings.items():
        lines += _sizing_lines(drive, sizing)
    return "\n".join(lines).rstrip() + "\n"


def _loop_table(outcome: Outcome) -> list[str]:
    """Types A to D with their links, and how near to a singularity each loop comes."""
    robot = outcome.robot
    rows: list[Sequence[str]] = []
    for name, distance in outcome.distances.items():
        loop = robot.description.loops.get(name)
        words = ["-", "-", "-", "-"]
        if loop is not None:
            roles = {"arm": loop.arm, "k2": loop.k2}
            added = f"{loop.k1}, {loop.k2}"
            words = [loop.type, f"{loop.base}, {loop.arm}", added, roles[_ENDS_ON[loop.type]]]
        rows.append([name, *words, f"{distance:.3f}"])
    head = ["loop", "type", "base, arm", "added links", "goes on from", "to a singularity"]
    if not rows:
        return []
    about = "Distances to a singularity are the least of the cycle, from 0 (singular) to 1."
    return ["## Loops", "", *markdown_table(head, rows), "", about, ""]


def _drive_table(outcome: Outcome) -> list[str]:
    """What each drive has to do."""
    rows: list[Sequence[str]] = []
    for drive, demand in outcome.demands.items():
        place = coordinate_unit(demand.kind)
        force = effort_unit(demand.kind)
        low, high = demand.position.min(), demand.position.max()
        rows.append(
            [
                drive,
                f"{_number(low)} to {_number(high)} {place}",
                f"{_number(demand.speed)} {place}/s",
                f"{_number(demand.peak)} {force}",
                f"{_number(demand.rms)} {force}",
                f"{_number(demand.power)} W",
            ]
        )
    head = ["drive", "coordinate", "speed", "peak", "rms", "power"]
    title = f"## Drives in {outcome.rows} rows of the duty cycle"
    return [title, "", *markdown_table(head, rows), ""]


def _number(value: float) -> str:
    """A number with five digits; what is only rounding is zero."""
    if abs(value) < _ROUNDING:
        return "0"
    return f"{value:.5g}"


def _sizing_lines(drive: str, sizing: Sizing) -> list[str]:
    """What was chosen for a drive, and why the others fail."""
    rows: list[Sequence[str]] = []
    for candidate in sizing.candidates:
        lacking = "; ".join(check.text for check in candidate.lacking)
        rows.append([candidate.name, lacking or "fits"])
    chosen = "none of the catalogue fits"
    if sizing.chosen is not None:
        chosen = f"{sizing.chosen.name} is the smallest that fits"
    return [f"### {drive}: {chosen}", "", *markdown_table(["name", "lacks"], rows), ""]


def markdown_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """The lines of a table."""
    rule = ["---"] * len(head)
    return [f"| {' | '.join(row)} |" for row in (head, rule, *rows)]
