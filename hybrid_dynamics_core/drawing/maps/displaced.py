"""A robot that gives way: under a load, or swinging in a natural mode."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from ...closed_state.state import ClosedState
from ...ground.arrays import Array
from ...robot.robot import Robot
from ...scene.displaced import Displacements
from ...scene.scene import Scene, build_scene
from ...scene.skeleton import place_skeleton
from ...scene.style import QUIET, STYLE
from ..paint.layout import axes_at
from ..paint.picture import limits_of, paint_scene
from .colours import head

_SHIFT: Final = 0.06  # of the picture's size, by which the farthest place is shown to move
_STEPS: Final = (1.0, 2.0, 5.0)  # of the scale, in each power of ten
_WIDTH: Final = 7.2  # [in]
_HEIGHTS: Final = (2.2, 6.0)  # [in] least and greatest, of the axes
_MARGINS: Final = (0.76, 0.16, 0.5, 0.72)  # [in] left, right, below and above the axes
_PATCH: Final[dict[str, Any]] = {
    "fill": False,
    "edgecolor": QUIET,
    "linewidth": 0.7,
    "linestyle": (0, (4, 2)),
}


def displaced_figure(
    robot: Robot,
    state: ClosedState,
    displacements: Mapping[str, Array],
    title: str,
    scale: float | None,
) -> Figure:
    """The robot with its links displaced, and dashed where it is without.

    Args:
        robot: to be drawn.
        state: one closed state.
        displacements: displacement (6,) of each link's origin and its turn, base axes [m, rad].
        title: title of the figure.
        scale: by which displacements are multiplied; None: a round number that shows them well.
    """
    with mpl.rc_context(STYLE):
        description = robot.description
        skeleton = place_skeleton(robot, state)
        moves = Displacements(skeleton, displacements)
        projection = moves.projection()
        standing = build_scene(
            description, place_skeleton(robot, robot.close(robot.reference)), projection
        )
        still = build_scene(description, skeleton, projection, None, standing)
        factor = scale or _scale(moves, limits_of(still))
        moved = moves.of_scene(still, factor)
        limits = _both(limits_of(still), limits_of(moved))
        across, up = np.ptp(limits, axis=0)
        left, right, below, above = _MARGINS
        width = _WIDTH - left - right
        height = float(np.clip(width * up / across, *_HEIGHTS))
        figure = Figure(figsize=(_WIDTH, height + below + above))
        head(figure, title, f"displacements {factor:g} times as large, dashed: without load")
        axes = axes_at(figure, (left, below, width, height))
        paint_scene(axes, moved, "none", limits)
        _outline(axes, still)
    return figure


def _scale(moved: Displacements, limits: Array) -> float:
    """The largest round number that keeps displacements small in the picture."""
    sizes = np.linalg.norm(moved.of_points(), axis=1)
    largest = float(sizes.max(initial=0.0))
    if not largest:
        return 1.0
    size = float(np.ptp(limits, axis=0).max())
    wanted = _SHIFT * size / largest
    power = 10.0 ** np.floor(np.log10(wanted))
    steps = [step * power for step in _STEPS if step * power <= wanted]
    return float(max(steps))


def _both(one: Array, other: Array) -> Array:
    """(2, 2) limits of two pictures together."""
    low = np.minimum(one[0], other[0])
    high = np.maximum(one[1], other[1])
    return np.array([low, high])


def _outline(axes: Axes, scene: Scene) -> None:
    """Dashed outlines of all parts, over what is painted."""
    for part in scene.parts:
        corners = part.outline(scene.projection)
        axes.add_patch(Polygon(corners, zorder=30.0, **_PATCH))
