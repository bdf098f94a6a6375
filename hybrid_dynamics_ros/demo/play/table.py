"""A snapshot in words: a table, or one line."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Final, NamedTuple

from ..topics import EFFORTS, INPUT, POSE, STATES
from .snapshot import Snapshot

# The forging robot's links and cylinders, as its description file names them.
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


class Row(NamedTuple):
    """A line of the table; headings are shown in bold."""

    text: str = ""
    heading: bool = False


class Progress(NamedTuple):
    """How far the run is: recorded time played and its end [s], and messages by topic."""

    time: float
    duration: float
    counts: Mapping[str, int]

    @property
    def share(self) -> float:
        """Played part, 0 to 1."""
        return min(1.0, max(0.0, self.time / self.duration))


def table(
    snapshot: Snapshot, progress: Progress, prismatic: Collection[str], bar: str
) -> list[Row]:
    """The whole state.

    Args:
        snapshot: what to show.
        progress: how far the run is.
        prismatic: coordinates that are lengths; the others are angles.
        bar: two characters, done and to do.
    """
    active = [name for name in snapshot.position if name in snapshot.effort]
    passive = [name for name in snapshot.position if name not in snapshot.effort]
    x, y, z = snapshot.tool
    qx, qy, qz, qw = snapshot.quaternion
    counts = progress.counts
    return [
        _progress_row(progress, bar),
        Row(),
        Row(
            f"  {'active joint':<18}{'position':>11}{'rate':>18}{'required effort':>24}",
            heading=True,
        ),
        *(
            Row(_motion(name, snapshot, prismatic) + _effort(name, snapshot, prismatic))
            for name in active
        ),
        Row(),
        Row(f"  {'passive joint':<18}{'position':>11}{'rate':>18}", heading=True),
        *(Row(_motion(name, snapshot, prismatic)) for name in passive),
        Row(),
        Row("  end effector in the base frame", heading=True),
        Row(
            f"  x {x:7.4f}  y {y:7.4f}  z {z:7.4f} m   quaternion {qx:6.3f} {qy:6.3f} {qz:6.3f}"
            f" {qw:6.3f}"
        ),
        Row(),
        Row(
            f"  messages: {counts[INPUT]} played, {counts[STATES]} joint states, {counts[EFFORTS]}"
            f" efforts, {counts[POSE]} poses"
        ),
    ]


def line(snapshot: Snapshot, progress: Progress, prismatic: Collection[str]) -> str:
    """The active joints in a line, below it their efforts and the tool.

    Neither is wider than a terminal.
    """
    active = [name for name in snapshot.position if name in snapshot.effort]
    joints = ", ".join(
        f"{name} {_position(name, snapshot.position[name], prismatic).strip()}" for name in active
    )
    efforts = ", ".join(_effort(name, snapshot, prismatic).strip() for name in active)
    x, y, z = snapshot.tool
    return f"t {progress.time:5.2f} s | {joints}\n  {efforts} | tool {x:.3f} {y:.3f} {z:.3f} m"


def _progress_row(progress: Progress, bar: str) -> Row:
    width = 32
    done = round(width * progress.share)
    drawn = bar[0] * done + bar[1] * (width - done)
    return Row(
        f"  t = {progress.time:5.2f} of {progress.duration:.2f} s   {drawn} "
        f" {100 * progress.share:3.0f} %"
    )


def _motion(name: str, snapshot: Snapshot, prismatic: Collection[str]) -> str:
    rate = snapshot.velocity.get(name, math.nan)
    unit = "mm/s " if name in prismatic else "deg/s"
    scaled = rate * 1e3 if name in prismatic else math.degrees(rate)
    position = _position(name, snapshot.position[name], prismatic)
    return f"  {name:<5}{_PARTS.get(name, ''):<11}{position}{scaled:13.3f} {unit}"


def _position(name: str, value: float, prismatic: Collection[str]) -> str:
    return f"{value * 1e3:11.3f} mm " if name in prismatic else f"{math.degrees(value):11.3f} deg"


def _effort(name: str, snapshot: Snapshot, prismatic: Collection[str]) -> str:
    # Adding zero: rounded to -0.000, it would be shown with its sign.
    value = round(snapshot.effort[name], 3) + 0.0
    return f"{value:17.3f} {'N' if name in prismatic else 'N m'}"
