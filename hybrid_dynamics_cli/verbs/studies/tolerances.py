"""Errors of the tool from tolerances of lengths and play of pins."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import click

from hybrid_dynamics_core import InputError
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.tolerances import (
    LinearErrors,
    SampledErrors,
    ToleranceAnalysis,
    table_of,
)
from hybrid_dynamics_core.tolerances.analysis import CONFIDENCE, POSES
from hybrid_dynamics_core.tolerances.entries import LAWS

from ...bags.common import PATH
from ...limits import beyond
from ...output import by_name, number, show, table
from ...parameters import (
    frame_option,
    json_option,
    loaded,
    once_each,
    options,
    pair,
    robot_argument,
    u_option,
    vector,
)
from ...quantities import coordinate_units

HELP: Final = """\
Errors of the end effector of ROBOT from tolerances of its lengths and play of its pins.

Loops stay closed. The likely error is a root sum square at --confidence, the worst one a sum.
Shares say which tolerance to tighten first. Without -u, errors are those over the workspace.

Paths are those of the file: L2, joints.q2.origin.xyz[0], loops.lift.pin.rod, joints.q1.offset. The
path of a pin's play is joints.NAME.play or loops.NAME.play: half of the difference of the diameters
of hole and pin. Values are half widths, as 0.1*mm, 0.1*mm uniform, or 0.05*mm towards 0 0 -1 for a
pin that is pressed to one side.
"""
EPILOG: Final = """\b
Examples:
  hybrid-dynamics tolerances palletizer \\
      --tolerance 'L2=0.1*mm, L3=0.1*mm, joints.q2.play=0.03*mm'
  hybrid-dynamics tolerances my_robot.yaml --monte-carlo 500 \\
      --tolerance 'crank=0.05*mm uniform' --json
"""


@click.command(help=HELP, epilog=EPILOG, short_help="Errors from tolerances and play.")
@robot_argument
@click.option(
    "--tolerance",
    "texts",
    metavar="PATH=VALUE,...",
    multiple=True,
    help="Tolerances and plays, with commas; any number of times.",
)
@click.option(
    "--table", "tables", type=PATH, multiple=True, metavar="FILE", help="The same, a line each."
)
@click.option(
    "--law",
    type=click.Choice(LAWS),
    default=LAWS[0],
    show_default=True,
    help="Distribution of numbers without one: a tolerance is 3 deviations.",
)
@u_option
@click.option(
    "--poses",
    type=click.IntRange(1),
    metavar="N",
    help=f"Poses of the workspace that are tried, without -u.  [default: {POSES}]",
)
@click.option(
    "--range",
    "ranges",
    multiple=True,
    metavar="NAME=LOW:HIGH",
    help="Narrower range of an active joint, without -u; repeatable.",
)
@frame_option("A frame or link in place of the end effector.")
@click.option(
    "--confidence",
    type=click.FloatRange(0.5, 1.0, max_open=True),
    default=CONFIDENCE,
    show_default=True,
    help="Probability of an error below the likely one.",
)
@click.option(
    "--monte-carlo",
    "count",
    type=click.IntRange(2),
    metavar="N",
    help="Close the loops of so many random robots too, at the pose with the worst error.",
)
@click.option("--seed", type=click.IntRange(0), default=0, help="Seed of the random robots.")
@json_option
def command(
    robot: str,
    texts: tuple[str, ...],
    tables: tuple[Path, ...],
    law: str,
    u: str | None,
    poses: int | None,
    ranges: tuple[str, ...],
    frame: str | None,
    confidence: float,
    count: int | None,
    seed: int,
    as_json: bool,
) -> None:
    """Print the errors."""
    machine = loaded(robot)
    entries = _entries(texts, tables)
    if u is not None and (ranges or poses is not None):
        raise click.UsageError("--poses and --range are of the workspace: leave out -u")
    with options(tolerances="tolerance"):
        analysis = ToleranceAnalysis(machine, entries, frame, law)
    with options("range"):
        narrower = once_each("--range", (pair(text, machine) for text in ranges))
        places = analysis.poses(poses or POSES, narrower) if u is None else None
    if places is None:
        units = coordinate_units(machine)
        places = vector("-u", u, machine.active, machine.reference, units)
        beyond(machine, machine.active, places)
    with options(tolerances="tolerance"):
        linear = analysis.linear(places, confidence)
    sampled = None
    if count is not None:
        sampled = analysis.monte_carlo(linear.u[linear.farthest], count, seed, confidence)
    show(facts(analysis, linear, sampled), as_json, text_of(analysis, linear, sampled))


def _entries(texts: tuple[str, ...], tables: tuple[Path, ...]) -> dict[str, str]:
    """The table of all options."""
    parts = list(texts)
    for path in tables:
        try:
            parts.append(path.read_text(encoding="utf-8"))
        except UnicodeDecodeError as error:
            raise InputError(f"{path}: is no text in UTF-8") from error
        except OSError as error:
            raise InputError(f"{path}: cannot be read: {error.strerror or error}") from error
    with options(tolerances="tolerance"):
        entries = table_of("\n".join(parts))
    if not entries:
        raise click.UsageError("give --tolerance PATH=VALUE, or --table FILE")
    return entries


def facts(
    analysis: ToleranceAnalysis, linear: LinearErrors, sampled: SampledErrors | None
) -> dict[str, Any]:
    """The result as plain data; m and rad."""
    halved, shares = linear.halved, linear.shares
    variables: dict[str, Any] = {}
    for one in analysis.variables:
        variables[one.name] = {
            "half": one.entry.half,
            "unit": one.unit,
            "share": shares[one.name],
            "likely_if_halved": halved[one.name],
        }
    active = analysis.robot.active
    data: dict[str, Any] = {
        "frame": analysis.frame,
        "poses": len(linear.u),
        "confidence": linear.confidence,
        "position": _sizes(active, linear.u, linear.likely, linear.worst),
        "rotation": _sizes(active, linear.u, linear.likely_rotation, linear.worst_rotation),
        "variables": variables,
        "tighten_first": max(shares, key=lambda name: shares[name]),
    }
    if sampled is not None:
        data["monte_carlo"] = {
            "robots": len(sampled.errors),
            "u": by_name(active, sampled.u[0].tolist()),
            "likely": sampled.likely[0],
            "interval": sampled.likely_interval[0],
            "largest": sampled.largest[0],
            "open": sampled.open_share[0],
        }
    return data


def _sizes(active: tuple[str, ...], u: Array, likely: Array, worst: Array) -> dict[str, Any]:
    """The largest errors over all poses, and where they are."""
    first = int(likely.argmax())
    last = int(worst.argmax())
    return {
        "likely": likely[first],
        "likely_at": by_name(active, u[first].tolist()),
        "likely_mean": likely.mean(),
        "worst": worst[last],
        "worst_at": by_name(active, u[last].tolist()),
    }


def text_of(
    analysis: ToleranceAnalysis, linear: LinearErrors, sampled: SampledErrors | None
) -> str:
    """The result as text."""
    halved, shares = linear.halved, linear.shares
    rows: list[list[object]] = []
    for one in sorted(analysis.variables, key=lambda one: -shares[one.name]):
        share = f"{100.0 * shares[one.name]:.1f} %"
        rows.append([one.name, f"{one.entry.half:.3g}", share, f"{1e3 * halved[one.name]:.3g} mm"])
    where = f"over {len(linear.u)} poses"
    if len(linear.u) == 1:
        where = "at this pose"
    sizes = _pair_text(linear, linear.likely, linear.worst, "mm")
    angles = _pair_text(linear, linear.likely_rotation, linear.worst_rotation, "mrad")
    lines = [f"position of {analysis.frame}, {where}: {sizes}", f"orientation: {angles}"]
    lines.append(f"worst at {_place(analysis, linear.u[linear.farthest])}")
    lines.append("")
    lines.append(
        table(["from", "half width [m, rad]", "share of variance", "likely if halved"], rows)
    )
    if sampled is not None:
        lines.append("")
        lines.append(_sampled_text(sampled))
    return "\n".join(lines)


def _pair_text(linear: LinearErrors, likely: Array, worst: Array, unit: str) -> str:
    """The largest likely and worst errors."""
    percent = f"{100.0 * linear.confidence:g} %"
    largest = f"worst {1e3 * worst.max():.3g} {unit}"
    return f"likely ({percent}) {1e3 * likely.max():.3g} {unit}, {largest}"


def _sampled_text(sampled: SampledErrors) -> str:
    """The errors of random robots."""
    low, high = (1e3 * sampled.likely_interval[0]).tolist()
    likely = f"likely {1e3 * sampled.likely[0]:.3g} mm ({low:.3g} to {high:.3g})"
    largest = f"largest {1e3 * sampled.largest[0]:.3g} mm"
    share = f"{100.0 * sampled.open_share[0]:.3g} % do not close"
    return f"{len(sampled.errors)} random robots there: {likely}, {largest}, {share}"


def _place(analysis: ToleranceAnalysis, u: Array) -> str:
    values = zip(analysis.robot.active, u.tolist(), strict=True)
    return ", ".join(f"{name} = {number(value)}" for name, value in values)
