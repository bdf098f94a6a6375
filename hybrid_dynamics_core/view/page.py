"""Tables and bars of the panel, as HTML."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Final

import numpy as np

from ..closed_state.assembly_modes import AssemblyMode
from ..closed_state.state import ClosedState
from ..ground.units import effort_unit
from ..robot.robot import Robot
from ..scene.style import GREEN, GRID, INK, ORANGE, QUIET, RED
from .scale import limit_of
from .session import Efforts, Session

NEAR: Final = 0.1  # distance to a singularity below which the bar warns
TOO_NEAR: Final = 0.03
_STYLE: Final = f"""<style>
.hd {{ font: 12.5px/1.55 system-ui, sans-serif; padding: 0.1em 0.9em 0.4em; color: {INK}; }}
.hd td {{ padding: 0 0.9em 0 0; }} .hd .q {{ color: {QUIET}; }} .hd .n {{ text-align: right; }}
.hd .n, .hd .v {{ font-variant-numeric: tabular-nums; }}
.hd .n, .hd .u {{ white-space: nowrap; }}
.hd.q {{ color: {QUIET}; }}
.hd .bar {{ display: inline-block; position: relative; height: 0.65em; background: {GRID}; border-radius: 0.2em; }}
.hd .bar i {{ position: absolute; top: 0; height: 100%; border-radius: 0.2em; }}
.hd-no {{ background: #fdf0e7; border-left: 4px solid {RED}; margin: 0.3em 0.6em; padding: 0.5em 0.8em; }}
</style>"""

NARROW: Final = (
    "36em"  # width of the window up to which viser lays its panel over the scene, from below
)
# In a narrow window the panel is below the scene, which is at least as wide as high. The line that
# the page writes into (`script`) is not seen, reasons stay in sight, and names that are too long
# for their field end in dots.
SHEET: Final = f"""<style>
@media (max-width: {NARROW}) {{
  div:has(> .mantine-Paper-root .hd-sheet) {{ flex-direction: column; }}
  div:has(> .mantine-Paper-root .hd-sheet) > div:has(canvas) {{ height: auto !important; min-height: 0; }}
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


def state_html(session: Session) -> str:
    """End effector, residual, distance to a singularity."""
    robot, state = session.robot, session.state
    place = zip(
        "xyz",
        np.round(robot.forward_kinematics(state).position, 4).tolist(),
        ("", "", " m"),
        strict=True,
    )
    told = [f"<span class=q>{axis}</span> {v + 0.0:.4f}{unit}" for axis, v, unit in place]
    margin = float(state.singularity)
    colour = RED if margin < TOO_NEAR else ORANGE if margin < NEAR else GREEN
    where = f" <span class=q>{breakable(str(state.singular_loop))}</span>" if state.loops else ""
    rows = [
        (robot.end_effector, "&ensp; ".join(f"<span class=u>{value}</span>" for value in told)),
        ("residual", f"{float(np.asarray(state.residual)):.1e}"),
        ("singularity", f"{bar(0.0, margin, colour)} {margin:.3f}{where}"),
    ]
    return table(
        [f"<td class=q>{escape(str(name))}</td><td class=v>{value}</td>" for name, value in rows]
    )


def modes_html(state: ClosedState) -> str:
    """The assembly mode of each loop."""
    loops = [(breakable(loop), escape(mode)) for loop, mode in state.branch.items()]
    return table([f"<td class=q>{loop}</td><td class=v>{mode}</td>" for loop, mode in loops])


def efforts_html(robot: Robot, efforts: Efforts) -> str:
    """A bar from the middle for each drive, with its number and unit, and what full bars are."""
    if efforts.problem:
        return f"{_STYLE}<div class=hd>{escape(efforts.problem)}</div>"
    recorded = (
        {}
        if efforts.recorded is None
        else dict(zip(robot.active, efforts.recorded.tolist(), strict=True))
    )
    rows = (
        ["<td></td><td></td><td class='n q'>model</td><td></td><td class='n q u'>in the file</td>"]
        if recorded
        else []
    )
    for name, value, share in zip(
        efforts.joints, efforts.values.tolist(), efforts.shares, strict=True
    ):
        unit = effort_unit(robot.joint_types[name])
        cells = [f"<td>{escape(name)}</td><td>{bar(0.5, 0.5 * share, RED)}</td>"]
        cells.append(f"<td class=n>{number(value)}</td><td class='q u'>{unit}</td>")
        cells += [f"<td class=n>{number(recorded[name])}</td>"] if name in recorded else []
        rows.append("".join(cells))
    return table(rows) + f"<div class='hd q'>{escape(full_bars(robot, efforts))}</div>"


def full_bars(robot: Robot, efforts: Efforts) -> str:
    """What full bars are, in words."""
    kinds: dict[tuple[str, bool], float] = {}
    for name, value, full in zip(
        efforts.joints, efforts.values.tolist(), efforts.full.tolist(), strict=True
    ):
        if np.isfinite(full):
            kinds[robot.joint_types[name], np.isfinite(limit_of(robot, name, value))] = full
    seen = [
        f"{number(full)} {effort_unit(kind)}"
        for (kind, limited), full in kinds.items()
        if not limited
    ]
    told = (
        ["what the cylinder gives at its supply pressure"]
        if any(limited for _, limited in kinds)
        else []
    )
    told += [f"{' and '.join(seen)}, above the largest so far"] if seen else []
    return f"Full bar: {'; else '.join(told)}." if told else ""


def breakable(names: str) -> str:
    """Names joined by +, which may go on in the next line."""
    return escape(names).replace("+", "+<wbr>")


def table(rows: Sequence[str]) -> str:
    """Rows, each the cells of one."""
    return (
        f"{_STYLE}<div class=hd><table>{''.join(f'<tr>{row}</tr>' for row in rows)}</table></div>"
    )


def bar(start: float, length: float, colour: str, width: float = 7.0) -> str:
    """A bar that is filled from one share of its width on, to the right or, for a negative length, to the left."""
    low, high = sorted(float(np.clip(end, 0.0, 1.0)) for end in (start, start + length))
    filled = (
        f"<i style='left:{100 * low:.1f}%;width:{100 * (high - low):.1f}%;background:{colour}'></i>"
    )
    middle = (
        f"<i style='left:{100 * start:.1f}%;width:1px;background:{QUIET}'></i>" if start else ""
    )
    return f"<span class=bar style='width:{width}em'>{filled}{middle}</span>"


def note_html(note: str) -> str:
    """What has to be known of something shown."""
    return f"{_STYLE}<div class='hd q'>{escape(note)}</div>"


def problem_html(problem: str) -> str:
    """Why the picture did not follow."""
    told = f"<b>The last pose stays.</b><br>{escape(problem)}"
    return f"{_STYLE}<div class='hd hd-no' role=alert>{told}</div>" if problem else ""


def mode_labels(modes: Sequence[AssemblyMode], own: Mapping[str, str]) -> list[str]:
    """A name for each assembly mode: in what it differs from the robot's own."""
    several = (
        len({loop for mode in modes for loop, name in mode.branch.items() if name != own.get(loop)})
        > 1
    )
    labels = []
    for mode in modes:
        others = [(loop, name) for loop, name in mode.branch.items() if name != own.get(loop)]
        labels.append(", ".join(f"{loop} {name}" if several else name for loop, name in others))
    return [f"{k + 1}: {label or 'the robot’s own'}" for k, label in enumerate(labels)]


def number(value: float) -> str:
    """Four digits, without a power of ten."""
    if not np.isfinite(value):
        return "-"
    return f"{value:,.0f}" if abs(value) >= 1000.0 else f"{value:.4g}" if abs(value) > 1e-9 else "0"
