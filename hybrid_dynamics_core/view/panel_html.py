"""Tables and bars of the panel, as HTML."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Final

import numpy as np

from ..closed_state.assembly_modes import AssemblyMode
from ..closed_state.state import ClosedState
from ..ground.units import effort_unit
from ..robot.robot import Robot
from ..scene.style import GREEN, GRID, INK, ORANGE, QUIET, RED
from .effort_scale import limit_of
from .session import DriveEfforts, ViewSession

NEAR: Final = 0.1  # distance to a singularity below which the bar warns
TOO_NEAR: Final = 0.03
_ZERO: Final = 1e-9  # smaller numbers are shown as 0
_STYLE: Final = f"""<style>
.hd {{ font: 12.5px/1.55 system-ui, sans-serif; padding: 0.1em 0.9em 0.4em; color: {INK}; }}
.hd td {{ padding: 0 0.9em 0 0; }} .hd .q {{ color: {QUIET}; }} .hd .n {{ text-align: right; }}
.hd .n, .hd .v {{ font-variant-numeric: tabular-nums; }}
.hd .n, .hd .u {{ white-space: nowrap; }}
.hd.q {{ color: {QUIET}; }}
.hd .bar {{
  display: inline-block; position: relative; height: 0.65em; background: {GRID};
  border-radius: 0.2em; }}
.hd .bar i {{ position: absolute; top: 0; height: 100%; border-radius: 0.2em; }}
.hd-no {{
  background: #fdf0e7; border-left: 4px solid {RED}; margin: 0.3em 0.6em;
  padding: 0.5em 0.8em; }}
</style>"""
# Width of the window up to which viser puts its panel below the scene.
NARROW: Final = "36em"
# In a narrow window the panel is below the scene, which is at least as wide as high. The text field
# of `script` is hidden, error texts stay visible, and long names end in dots.
SHEET: Final = f"""<style>
@media (max-width: {NARROW}) {{
  div:has(> .mantine-Paper-root .hd-sheet) {{ flex-direction: column; }}
  div:has(> .mantine-Paper-root .hd-sheet) > div:has(canvas) {{
    height: auto !important; min-height: 0; }}
  div:has(> .mantine-Paper-root .hd-sheet) > .mantine-Paper-root {{
    position: relative !important; flex: none; width: 100% !important;
    max-height: max(50%, 100% - 100vw) !important;
  }}
  .mantine-ScrollArea-content > div:has(.hd-sheet) {{ width: 100% !important; }}
}}
div:has(> .hd-sheet) + div {{ display: none; }}
.mantine-ScrollArea-content div[style*=hidden]:has(.hd-sheet) {{ overflow: clip !important; }}
div:has(> .hd-no) {{ position: sticky; top: 0; z-index: 20; }}
div:has(> .mantine-Slider-root) > .mantine-NumberInput-root {{ width: 3.7rem !important; }}
.mantine-Select-input {{ padding-right: 1.7em !important; text-overflow: ellipsis; }}
</style><div class=hd-sheet></div>"""


_RECORDED_HEAD: Final = (
    "<td></td><td></td><td class='n q'>model</td><td></td><td class='n q u'>in the file</td>"
)


# -- state


def state_html(session: ViewSession) -> str:
    """A table of end effector position, residual and distance to a singularity."""
    state = session.state
    entries = {
        escape(session.robot.end_effector): _position(session),
        "residual": f"{float(np.asarray(state.residual)):.1e}",
        "singularity": _singularity(state),
    }
    return _named_rows(entries)


def _position(session: ViewSession) -> str:
    position = session.robot.forward_kinematics(session.state).position
    texts = []
    rounded = np.round(position, 4).tolist()
    for axis, value in zip("xyz", rounded, strict=True):
        unit = " m" if axis == "z" else ""
        text = f"<span class=q>{axis}</span> {value + 0.0:.4f}{unit}"
        texts.append(f"<span class=u>{text}</span>")
    return "&ensp; ".join(texts)


def _singularity(state: ClosedState) -> str:
    """The distance to a singularity as bar and number, and the nearest loop."""
    margin = float(state.singularity)
    loop = ""
    if state.loops:
        loop = f" <span class=q>{breakable(str(state.singular_loop))}</span>"
    return f"{bar(0.0, margin, _margin_colour(margin))} {margin:.3f}{loop}"


def _margin_colour(margin: float) -> str:
    if margin < TOO_NEAR:
        return RED
    if margin < NEAR:
        return ORANGE
    return GREEN


def modes_html(state: ClosedState) -> str:
    """A table of the assembly mode of each loop."""
    return _named_rows({breakable(loop): escape(mode) for loop, mode in state.branch.items()})


def mode_labels(modes: Sequence[AssemblyMode], reference: Mapping[str, str]) -> list[str]:
    """A label for each assembly mode: the loops that differ from the robot's own mode.

    Args:
        modes: the modes.
        reference: the branch of the robot's own mode.

    Returns:
        Labels with numbers from 1.
    """
    differences = [_differences(mode, reference) for mode in modes]
    loops = set().union(*differences)
    labels = []
    for k, difference in enumerate(differences):
        names = list(difference.values())
        if len(loops) > 1:
            names = [f"{loop} {name}" for loop, name in difference.items()]
        label = ", ".join(names) or "the robot’s own"
        labels.append(f"{k + 1}: {label}")
    return labels


def _differences(mode: AssemblyMode, reference: Mapping[str, str]) -> dict[str, str]:
    """Loops that differ from the robot's own mode, with their mode names."""
    return {loop: name for loop, name in mode.branch.items() if name != reference.get(loop)}


# -- efforts


def efforts_html(robot: Robot, efforts: DriveEfforts) -> str:
    """A table with a bar, number and unit for each drive, and the efforts of full bars."""
    if efforts.problem:
        return f"{_STYLE}<div class=hd>{escape(efforts.problem)}</div>"
    recorded: dict[str, float] = {}
    if efforts.recorded is not None:
        recorded = dict(zip(robot.active, efforts.recorded.tolist(), strict=True))
    rows = [_RECORDED_HEAD] if recorded else []
    values, shares = efforts.values.tolist(), efforts.shares
    for name, value, share in zip(efforts.joints, values, shares, strict=True):
        unit = effort_unit(robot.joint_types[name])
        cells = f"<td>{escape(name)}</td><td>{bar(0.5, 0.5 * share, RED)}</td>"
        cells += f"<td class=n>{number(value)}</td><td class='q u'>{unit}</td>"
        if name in recorded:
            cells += f"<td class=n>{number(recorded[name])}</td>"
        rows.append(cells)
    return table(rows) + f"<div class='hd q'>{escape(full_bars(robot, efforts))}</div>"


def full_bars(robot: Robot, efforts: DriveEfforts) -> str:
    """Text on the efforts of full bars."""
    has_limited = False
    shared: dict[str, float] = {}  # by type of joint
    values, bars = efforts.values.tolist(), efforts.full.tolist()
    for name, value, full in zip(efforts.joints, values, bars, strict=True):
        if not np.isfinite(full):
            continue
        if np.isfinite(limit_of(robot, name, value)):
            has_limited = True
        else:
            shared[robot.joint_types[name]] = full
    texts = []
    if has_limited:
        texts.append("what the cylinder gives at its supply pressure")
    if shared:
        sizes = [f"{number(full)} {effort_unit(kind)}" for kind, full in shared.items()]
        texts.append(f"{' and '.join(sizes)}, above the largest so far")
    return f"Full bar: {'; else '.join(texts)}." if texts else ""


# -- texts


def note_html(note: str) -> str:
    """A remark on the shown data."""
    return f"{_STYLE}<div class='hd q'>{escape(note)}</div>"


def problem_html(problem: str) -> str:
    """The reason why a request was refused."""
    if not problem:
        return ""
    text = f"<b>The last pose stays.</b><br>{escape(problem)}"
    return f"{_STYLE}<div class='hd hd-no' role=alert>{text}</div>"


# -- elements


def breakable(names: str) -> str:
    """Names joined by +, with possible line breaks."""
    return escape(names).replace("+", "+<wbr>")


def table(rows: Iterable[str]) -> str:
    """An HTML table of rows of cells."""
    body = "".join(f"<tr>{row}</tr>" for row in rows)
    return f"{_STYLE}<div class=hd><table>{body}</table></div>"


def _named_rows(entries: Mapping[str, str]) -> str:
    """A table of names and values, both as HTML."""
    rows = [f"<td class=q>{name}</td><td class=v>{value}</td>" for name, value in entries.items()]
    return table(rows)


def bar(
    start: float,
    length: float,
    colour: str,
    width: float = 7.0,
) -> str:
    """A partly filled bar.

    Args:
        start: start of the filled part, as a share of the width.
        length: length of the filled part, as a share of the width; negative to the left.
        colour: colour of the filled part.
        width: width of the bar [em].

    Returns:
        HTML.
    """
    ends = np.clip([start, start + length], 0.0, 1.0)
    low, high = sorted(ends.tolist())
    place = f"left:{100 * low:.1f}%;width:{100 * (high - low):.1f}%"
    content = f"<i style='{place};background:{colour}'></i>"
    if start:
        content += f"<i style='left:{100 * start:.1f}%;width:1px;background:{QUIET}'></i>"
    return f"<span class=bar style='width:{width}em'>{content}</span>"


def number(value: float) -> str:
    """A number with four digits, without an exponent."""
    if not np.isfinite(value):
        return "-"
    if abs(value) >= 1000.0:
        return f"{value:,.0f}"
    if abs(value) > _ZERO:
        return f"{value:.4g}"
    return "0"
