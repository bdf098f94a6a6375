"""A map of how far a frame gives way under a force, over reach and height."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation

from ...ground.arrays import Array
from ...robot.robot import Robot
from ...scene.style import INK, QUIET, STYLE
from ...stiffness import StiffnessMap
from ..paint.layout import axes_at
from ..paint.picture import make_scene, paint_scene
from .colours import head

_COLOURS: Final = mpl.colormaps["YlOrRd"]
_BOX: Final = (0.76, 1.3, 5.9)  # [in] left and lower corner of the axes, and their width
_HEIGHTS: Final = (2.5, 6.5)  # [in] of the axes
_STEEPEST: Final = 0.98  # quantile of the deflections at which colours end
_MARGIN: Final = 0.06  # of the range, around it


def stiffness_figure(robot: Robot, chart: StiffnessMap, title: str | None) -> Figure:
    """The map of a robot, with the robot at its reference where its side view has these axes.

    Args:
        robot: the robot.
        chart: the map.
        title: title of the figure; None: the robot's name.
    """
    reach = np.hypot(chart.position[..., 0], chart.position[..., 1])
    height = chart.position[..., 2]
    limits = _limits(robot, reach, height)
    across, up = np.ptp(limits, axis=1)
    left, low, width = _BOX
    tall = float(np.clip(width * up / across, *_HEIGHTS))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(left + width + 0.3, low + tall + 0.75))
        force = ", ".join(f"{part:g}" for part in chart.force)
        about = f"displacement under a force of [{force}] N on it"
        head(figure, title or f"{robot.name}: where it gives way", about)
        axes = axes_at(figure, (left, low, width, tall))
        _paint_robot(axes, robot, limits)
        norm = _paint(axes, reach, height, 1e3 * chart.deflection)
        axes.set(xlim=limits[0], ylim=limits[1])
        axes.set(xlabel="reach from the axis of the base [m]", ylabel="height [m]")
        bar = axes_at(figure, (left, 0.5, width, 0.14))
        scale = figure.colorbar(ScalarMappable(norm, _COLOURS), cax=bar, orientation="horizontal")
        scale.set_label("displacement [mm]", color=QUIET, fontsize=8)
    return figure


def _limits(robot: Robot, reach: Array, height: Array) -> Array:
    """(2, 2) ranges of reach and height, with the machine."""
    state = robot.close(robot.reference)
    places = np.array([robot.forward_kinematics(state, name).position for name in robot.frames])
    far = max(np.nanmax(reach), np.hypot(places[:, 0], places[:, 1]).max())
    low = min(np.nanmin(height), places[:, 2].min(), 0.0)
    high = max(np.nanmax(height), places[:, 2].max())
    margin = _MARGIN * max(far, high - low)
    return np.array([[-0.2 * far, far + margin], [low - margin, high + margin]])


def _paint_robot(axes: Axes, robot: Robot, limits: Array) -> None:
    scene = replace(make_scene(robot, None), lines=())
    if scene.projection.names == ("x [m]", "z [m]"):
        paint_scene(axes, scene, "none", limits)


def _paint(axes: Axes, reach: Array, height: Array, moved: Array) -> BoundaryNorm:
    """Paint the displacements [mm]; returns their steps of colour."""
    values = moved[np.isfinite(moved)]
    top = float(np.quantile(values, _STEEPEST))
    levels = MaxNLocator(9).tick_values(0.0, max(top, 1e-12))
    norm = BoundaryNorm(levels, _COLOURS.N, extend="max")
    triangles = _triangles(reach, height, moved)
    mapped = np.nan_to_num(moved.ravel())
    shared: dict[str, Any] = {"levels": levels, "zorder": 2.2}
    axes.tricontourf(triangles, mapped, cmap=_COLOURS, norm=norm, extend="max", alpha=0.8, **shared)
    axes.tricontour(triangles, mapped, colors=INK, linewidths=0.4, **shared)
    return norm


def _triangles(reach: Array, height: Array, moved: Array) -> Triangulation:
    """Triangles between neighbours of the grid that have an answer."""
    rows, columns = reach.shape
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b = index[:-1, :-1].ravel(), index[1:, :-1].ravel()
    c, d = index[1:, 1:].ravel(), index[:-1, 1:].ravel()
    first = np.stack([a, b, c], axis=1)
    second = np.stack([a, c, d], axis=1)
    triangles = np.concatenate([first, second])
    good = np.isfinite(moved.ravel())[triangles].all(axis=1)
    x, y = np.nan_to_num(reach.ravel()), np.nan_to_num(height.ravel())
    return Triangulation(x, y, triangles[good])
