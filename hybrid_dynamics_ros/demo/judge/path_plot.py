"""The path of the end effector in space, with the robot at a few instants."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.ticker import MultipleLocator
from numpy.typing import NDArray

from hybrid_dynamics_core import ClosedState, Robot
from hybrid_dynamics_core.scene.style import BLUE, GREEN, INK, ORANGE, PURPLE, RED, SHADOW

from .results import Results

FloatArray = NDArray[np.float64]

# Frames whose origins, joined, make the robot. What a motor or a cylinder drives has the colour of
# its effort.
_PARTS: Final = (
    (("base", "l2"), BLUE, 3.4),
    (("l2", "l3", "l42"), INK, 2.6),
    (("l3", "l22"), INK, 2.6),
    (("l11", "l12"), RED, 3.0),
    (("l21", "l22"), GREEN, 3.0),
    (("l42", "end_effector"), ORANGE, 3.4),
)
_FOOT: Final = "l11"  # stands on the turning column: a line to the ground shows it
_POSTURES: Final = ((0.0, 0.35), (1.0, 1.0))  # share of the path, opacity


def draw_path(axes: Any, results: Results, robot: Robot) -> None:
    """Draw the path, its shadow on the floor, and the robot at the start (pale) and at the end.

    Args:
        axes: 3-D axes of Matplotlib.
        results: what was received.
        robot: the robot, for its configuration.
    """
    inputs, path = results.inputs, results.pose.position
    columns = [inputs.names.index(name) for name in robot.active]
    corners = [path]
    for share, opacity in _POSTURES:
        row = round(share * (len(inputs.stamp_ns) - 1))
        corners.append(
            _draw_robot(axes, robot, robot.close(inputs.position[row, columns]), opacity)
        )
    axes.plot(path[:, 0], path[:, 1], 0.0 * path[:, 2], color=SHADOW, linewidth=1.2)
    axes.plot(*path.T, color=PURPLE, linewidth=2.6)
    seconds = (results.pose.stamp_ns - results.start_ns) * 1e-9
    for row in (0, -1):
        x, y, z = path[row]
        axes.scatter([x], [y], [z], color=PURPLE, s=20, depthshade=False)
        axes.text(x, y, z + 0.07, f"{seconds[row]:.0f} s", color=PURPLE, fontsize=9, ha="center")
    _frame(axes, np.concatenate(corners))


def _draw_robot(axes: Any, robot: Robot, state: ClosedState, opacity: float) -> FloatArray:
    """The robot as lines; the corners of the lines (k, 3) [m]."""
    drawn = []
    for frames, colour, width in _PARTS:
        corners = _origins(robot, state, frames)
        axes.plot(*corners.T, color=colour, linewidth=width, alpha=opacity, solid_capstyle="round")
        axes.plot(*corners[1:-1].T, "o", color=colour, markersize=4.0, alpha=opacity)
        drawn.append(corners)
    foot = _origins(robot, state, (_FOOT,))
    ground = np.concatenate([foot * 0.0, foot * (1.0, 1.0, 0.0), foot])
    axes.plot(*ground.T, color=SHADOW, linewidth=1.4, alpha=opacity)
    return np.concatenate(drawn)


def _origins(robot: Robot, state: ClosedState, frames: tuple[str, ...]) -> FloatArray:
    """Origins of frames in the base frame, (k, 3) [m]."""
    return np.stack([robot.forward_kinematics(state, frame).position for frame in frames])


def _frame(axes: Any, points: FloatArray) -> None:
    """Equal scales around the points, the floor at z = 0."""
    low, high = points.min(axis=0) - 0.05, points.max(axis=0) + 0.05
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
