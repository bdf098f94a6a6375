"""A map of how far a frame gives way under a force, over reach and height."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ...ground.arrays import Array
from ...robot.robot import Robot
from ...scene.style import INK, QUIET, STYLE
from ...stiffness import StiffnessMap
from ..paint.layout import axes_at
from ..paint.picture import make_scene, paint_scene
from .colours import head
from .grid import triangles_of

_COLOURS: Final = mpl.colormaps["YlOrRd"]
_LEFT: Final = 0.76  # [in] of the axes
_BELOW: Final = 1.3  # [in] of the axes
_WIDTH: Final = 5.9  # [in] of the axes
_BAR: Final = 0.14  # [in] height of the scale of colours
_HEIGHTS: Final = (2.5, 6.5)  # [in] of the axes
_STEEPEST: Final = 0.98  # quantile of the deflections at which colours end
_MARGIN: Final = 0.06  # of the range, around it
_BEHIND: Final = 0.2  # of the reach, behind the base
_MILLIMETRES: Final = 1e3
_LAYER: Final = 2.2  # above the robot


def stiffness_figure(robot: Robot, chart: StiffnessMap, title: str | None) -> Figure:
    """The map of a robot, with the robot at its reference where its side view has these axes.

    Args:
        robot: the robot.
        chart: the map.
        title: title of the figure; None: the robot's name.
    """
    x = chart.position[..., 0]
    y = chart.position[..., 1]
    height = chart.position[..., 2]
    reach = np.hypot(x, y)
    limits = _limits(robot, reach, height)
    across, up = np.ptp(limits, axis=1)
    tall = float(np.clip(_WIDTH * up / across, *_HEIGHTS))
    force = ", ".join(f"{part:g}" for part in chart.force)
    about = f"displacement under a force of [{force}] N on it"
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(_LEFT + _WIDTH + 0.3, _BELOW + tall + 0.75))
        head(figure, title or f"{robot.name}: where it gives way", about)
        axes = axes_at(figure, (_LEFT, _BELOW, _WIDTH, tall))
        _paint_robot(axes, robot, limits)
        norm = _paint(axes, reach, height, _MILLIMETRES * chart.deflection)
        axes.set(xlim=limits[0], ylim=limits[1])
        axes.set(xlabel="reach from the axis of the base [m]", ylabel="height [m]")
        _scale(figure, norm)
    return figure


def _scale(figure: Figure, norm: BoundaryNorm) -> None:
    """The scale of colours below the map."""
    axes = axes_at(figure, (_LEFT, 0.5, _WIDTH, _BAR))
    colours = ScalarMappable(norm, _COLOURS)
    bar = figure.colorbar(colours, cax=axes, orientation="horizontal")
    bar.set_label("displacement [mm]", color=QUIET, fontsize=8)


def _limits(robot: Robot, reach: Array, height: Array) -> Array:
    """(2, 2) ranges of reach and height, with the machine."""
    state = robot.close(robot.reference)
    far = float(np.nanmax(reach))
    low = min(float(np.nanmin(height)), 0.0)
    high = float(np.nanmax(height))
    for name in robot.frames:
        x, y, z = robot.forward_kinematics(state, name).position
        far = max(far, float(np.hypot(x, y)))
        low = min(low, float(z))
        high = max(high, float(z))
    margin = _MARGIN * max(far, high - low)
    across = [-_BEHIND * far, far + margin]
    upward = [low - margin, high + margin]
    return np.array([across, upward])


def _paint_robot(axes: Axes, robot: Robot, limits: Array) -> None:
    scene = make_scene(robot, None)
    if scene.projection.names == ("x [m]", "z [m]"):
        bare = replace(scene, lines=())
        paint_scene(axes, bare, "none", limits)


def _paint(axes: Axes, reach: Array, height: Array, moved: Array) -> BoundaryNorm:
    """Paint the displacements [mm]; returns their steps of colour."""
    answered = np.isfinite(moved)
    top = float(np.quantile(moved[answered], _STEEPEST))
    levels = MaxNLocator(9).tick_values(0.0, max(top, 1e-12))
    norm = BoundaryNorm(levels, _COLOURS.N, extend="max")
    triangles = triangles_of(reach, height, answered)
    values = np.nan_to_num(moved.ravel())
    axes.tricontourf(
        triangles,
        values,
        levels=levels,
        extend="max",
        cmap=_COLOURS,
        norm=norm,
        alpha=0.8,
        zorder=_LAYER,
    )
    axes.tricontour(
        triangles,
        values,
        levels=levels,
        colors=INK,
        linewidths=0.4,
        zorder=_LAYER,
    )
    return norm
