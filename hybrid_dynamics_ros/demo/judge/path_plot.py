"""The path of the end effector in space, with the robot at its start and end."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from matplotlib.ticker import MultipleLocator

from hybrid_dynamics_core import ClosedState, Robot
from hybrid_dynamics_core.scene.style import BLUE, GREEN, INK, ORANGE, PURPLE, RED, SHADOW

from ...messages.joint_samples import FloatArray
from .results import Results


class _Line(NamedTuple):
    """Frames whose origins are joined by a line."""

    frames: tuple[str, ...]
    colour: str
    width: float


# Driven links have the colour of their drive's effort.
_LINES: Final = (
    _Line(("base", "l2"), BLUE, 3.4),
    _Line(("l2", "l3", "l42"), INK, 2.6),
    _Line(("l3", "l22"), INK, 2.6),
    _Line(("l11", "l12"), RED, 3.0),
    _Line(("l21", "l22"), GREEN, 3.0),
    _Line(("l42", "end_effector"), ORANGE, 3.4),
)
_FOOT: Final = "l11"  # foot of the column, connected to the ground by a line
_CONFIGURATIONS: Final = ((0.0, 0.35), (1.0, 1.0))  # (share of the path, opacity)
_LABEL_OFFSET: Final = 0.07  # [m] above an end of the path
_ROOM: Final = 0.05  # [m] around the points


def draw_path(axes: Any, results: Results, robot: Robot) -> None:
    """Draw the path and its shadow on the floor, and the robot at the start (pale) and at the end.

    Args:
        axes: 3-D axes of Matplotlib.
        results: the received messages.
        robot: the robot, for its configuration.
    """
    path = results.pose.position
    points = [path]
    for share, opacity in _CONFIGURATIONS:
        state = _state_at(results, robot, share)
        points.append(_draw_robot(axes, robot, state, opacity))
    x, y, z = path.T
    axes.plot(x, y, 0.0 * z, color=SHADOW, linewidth=1.2)
    axes.plot(x, y, z, color=PURPLE, linewidth=2.6)
    for row in (0, -1):
        _draw_end(axes, results, row)
    _frame(axes, np.concatenate(points))


def _state_at(results: Results, robot: Robot, share: float) -> ClosedState:
    """The state at a share of the recorded input."""
    inputs = results.inputs
    columns = [inputs.names.index(name) for name in robot.active]
    row = round(share * (len(inputs.stamp_ns) - 1))
    return robot.close(inputs.position[row, columns])


def _draw_end(axes: Any, results: Results, row: int) -> None:
    """A dot on the path, and its time."""
    x, y, z = results.pose.position[row]
    time = (results.pose.stamp_ns - results.start_ns)[row] * 1e-9
    axes.scatter([x], [y], [z], color=PURPLE, s=20, depthshade=False)
    label = f"{time:.0f} s"
    axes.text(x, y, z + _LABEL_OFFSET, label, color=PURPLE, fontsize=9, ha="center")


def _draw_robot(axes: Any, robot: Robot, state: ClosedState, opacity: float) -> FloatArray:
    """Draw the robot as lines; returns their corners (k, 3) [m]."""
    drawn = []
    for line in _LINES:
        corners = _origins(robot, state, line.frames)
        style = {"color": line.colour, "alpha": opacity}
        axes.plot(*corners.T, linewidth=line.width, solid_capstyle="round", **style)
        axes.plot(*corners[1:-1].T, "o", markersize=4.0, **style)
        drawn.append(corners)
    (foot,) = _origins(robot, state, (_FOOT,))
    below = foot * (1.0, 1.0, 0.0)
    from_base = np.stack([np.zeros(3), below, foot])
    axes.plot(*from_base.T, color=SHADOW, linewidth=1.4, alpha=opacity)
    return np.concatenate(drawn)


def _origins(robot: Robot, state: ClosedState, frames: Sequence[str]) -> FloatArray:
    """Origins of frames in the base frame, (k, 3) [m]."""
    return np.stack([robot.forward_kinematics(state, frame).position for frame in frames])


def _frame(axes: Any, points: FloatArray) -> None:
    """Set equal scales around points (k, 3) [m], with the floor at z = 0."""
    low = points.min(axis=0) - _ROOM
    high = points.max(axis=0) + _ROOM
    low[2] = 0.0
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low, zoom=0.98)
    axes.view_init(elev=25.0, azim=20.0)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_major_locator(MultipleLocator(0.4))
    axes.set_xlabel("x [m]", labelpad=-2)
    axes.set_ylabel("y [m]", labelpad=-2)
    axes.set_zlabel("z [m]", labelpad=-2)
    axes.tick_params(labelsize=8, pad=-1)
