"""A snapshot as text: a table, or one line."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Final, NamedTuple

from ..topics import EFFORTS, INPUT, POSE, STATES
from .snapshot import Snapshot

# Parts of the forging robot by joint.
_PARTS: Final = {
    "q1": "column",
    "q12": "cylinder 1",
    "q22": "cylinder 2",
    "q4": "gripper",
    "q2": "upper arm",
    "q3": "forearm",
    "q11": "barrel 1",
    "q21": "barrel 2",
    "q31": "long bar 1",
    "q32": "bell crank",
    "q41": "long bar 2",
    "q42": "carrier",
}
_BAR_WIDTH: Final = 32  # letters


class Row(NamedTuple):
    """A line of the table; headings are shown in bold."""

    text: str = ""
    heading: bool = False


_BLANK: Final = Row()
_ACTIVE_HEAD: Final = Row(
    f"  {'active joint':<18}{'position':>11}{'rate':>18}{'required effort':>24}", heading=True
)
_PASSIVE_HEAD: Final = Row(f"  {'passive joint':<18}{'position':>11}{'rate':>18}", heading=True)
_TOOL_HEAD: Final = Row("  end effector in the base frame", heading=True)


class Progress(NamedTuple):
    """Progress of the run.

    Attributes:
        time: played part of the recorded time [s].
        duration: duration of the recording [s].
        counts: number of messages by topic.
    """

    time: float
    duration: float
    counts: Mapping[str, int]

    @property
    def share(self) -> float:
        """Played share, from 0 to 1."""
        return min(1.0, max(0.0, self.time / self.duration))


def table(
    snapshot: Snapshot, progress: Progress, prismatic: Collection[str], bar: str
) -> list[Row]:
    """The state of all joints and of the end effector.

    Args:
        snapshot: state to show.
        progress: progress of the run.
        prismatic: coordinates that are lengths; the others are angles.
        bar: two characters, for the done and the remaining part.
    """
    active = [name for name in snapshot.position if name in snapshot.effort]
    passive = [name for name in snapshot.position if name not in snapshot.effort]
    rows = [_progress_row(progress, bar), _BLANK, _ACTIVE_HEAD]
    for name in active:
        text = _motion(name, snapshot, prismatic) + _effort(name, snapshot, prismatic)
        rows.append(Row(text))
    rows += [_BLANK, _PASSIVE_HEAD]
    rows += [Row(_motion(name, snapshot, prismatic)) for name in passive]
    rows += [_BLANK, _TOOL_HEAD, _tool_row(snapshot), _BLANK, _count_row(progress.counts)]
    return rows


def line(snapshot: Snapshot, progress: Progress, prismatic: Collection[str]) -> str:
    """A line of the active joints, and below it one of their efforts and the tool.

    Neither is wider than a terminal.

    Args:
        snapshot: state to show.
        progress: progress of the run.
        prismatic: coordinates that are lengths; the others are angles.
    """
    joints = []
    efforts = []
    for name, value in snapshot.position.items():
        if name in snapshot.effort:
            joints.append(f"{name} {_position(name, value, prismatic).strip()}")
            efforts.append(_effort(name, snapshot, prismatic).strip())
    x, y, z = snapshot.tool
    tool = f"tool {x:.3f} {y:.3f} {z:.3f} m"
    return f"t {progress.time:5.2f} s | {', '.join(joints)}\n  {', '.join(efforts)} | {tool}"


def _progress_row(progress: Progress, bar: str) -> Row:
    done = round(_BAR_WIDTH * progress.share)
    drawn = bar[0] * done + bar[1] * (_BAR_WIDTH - done)
    time = f"t = {progress.time:5.2f} of {progress.duration:.2f} s"
    return Row(f"  {time}   {drawn}  {100 * progress.share:3.0f} %")


def _tool_row(snapshot: Snapshot) -> Row:
    x, y, z = snapshot.tool
    qx, qy, qz, qw = snapshot.quaternion
    quaternion = f"{qx:6.3f} {qy:6.3f} {qz:6.3f} {qw:6.3f}"
    return Row(f"  x {x:7.4f}  y {y:7.4f}  z {z:7.4f} m   quaternion {quaternion}")


def _count_row(counts: Mapping[str, int]) -> Row:
    return Row(
        f"  messages: {counts[INPUT]} played, {counts[STATES]} joint states, {counts[EFFORTS]}"
        f" efforts, {counts[POSE]} poses"
    )


def _motion(name: str, snapshot: Snapshot, prismatic: Collection[str]) -> str:
    """Name, part, position and rate of a joint."""
    rate = snapshot.velocity.get(name, math.nan)
    if name in prismatic:
        scaled = f"{rate * 1e3:13.3f} mm/s "
    else:
        scaled = f"{math.degrees(rate):13.3f} deg/s"
    position = _position(name, snapshot.position[name], prismatic)
    return f"  {name:<5}{_PARTS.get(name, ''):<11}{position}{scaled}"


def _position(name: str, value: float, prismatic: Collection[str]) -> str:
    if name in prismatic:
        return f"{value * 1e3:11.3f} mm "
    return f"{math.degrees(value):11.3f} deg"


def _effort(name: str, snapshot: Snapshot, prismatic: Collection[str]) -> str:
    # Adding zero avoids -0.000.
    value = round(snapshot.effort[name], 3) + 0.0
    unit = "N" if name in prismatic else "N m"
    return f"{value:17.3f} {unit}"
