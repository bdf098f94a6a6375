"""A lifting chart as makers of machines print it: masses over reach and height."""

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
from matplotlib.tri import LinearTriInterpolator, Triangulation

from ...capability import LiftingChart
from ...ground.arrays import Array
from ...robot.robot import Robot
from ...scene.style import INK, QUIET, STYLE
from ..paint.layout import axes_at
from ..paint.picture import make_scene, paint_scene, with_visuals
from .colours import head
from .grid import triangles_of

_COLOURS: Final = mpl.colormaps["YlGnBu"]
_STEPS: Final = (0.05, 0.1, 0.25, 0.5, 1.0, 2.0, 5.0)  # [m] of the numbers
_MOST: Final = 16  # numbers along a side
_WIDTH: Final = 6.0  # [in] of the figure, at least
_BOX: Final = (0.72, 1.28)  # [in] left and lower corner of the axes
_SIDE: Final = 7.4  # [in] of the longer side of the axes
_TON: Final = 1000.0  # [kg]
_STEEPEST: Final = 0.98  # quantile of the masses at which colours end
_LIGHT: Final = 0.62  # share of the colours, above which a number is white
_WORDS: Final = "lifted mass at rest"


def lifting_figure(robot: Robot, chart: LiftingChart, title: str | None) -> Figure:
    """The chart of a robot, with the robot at its reference beside it."""
    unit, factor = _unit_of(chart)
    limits = _limits(robot, chart)
    width, height = np.ptp(limits, axis=1)
    scale = _SIDE / max(width, height)
    box = (*_BOX, scale * width, scale * height)
    size = (max(_WIDTH, box[2] + 1.0), box[3] + _BOX[1] + 0.72)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=size)
        head(figure, title or f"Lifting chart: {robot.name}", _subtitle(chart, unit))
        axes = axes_at(figure, box)
        _paint_robot(axes, robot, limits)
        norm = _paint_masses(axes, chart, factor)
        _write_numbers(axes, chart, factor, norm)
        axes.set(xlim=limits[0], ylim=limits[1])
        axes.set(xlabel="reach from the axis of the base [m]", ylabel="height [m]")
        _bar(figure, norm, unit, box)
    return figure


def _unit_of(chart: LiftingChart) -> tuple[str, float]:
    """Unit of the masses, and its number in a kilogram."""
    if np.nanmax(chart.mass) >= _TON:
        return "t", 1.0 / _TON
    return "kg", 1.0


def _subtitle(chart: LiftingChart, unit: str) -> str:
    frame = "the end effector"
    if chart.frame is not None:
        frame = f"'{chart.frame}'"
    share = "what"
    if chart.share != 1.0:
        share = f"{100.0 * chart.share:g} % of what"
    return f"{share} the drives hold at rest at {frame} [{unit}]"


def _limits(robot: Robot, chart: LiftingChart) -> Array:
    """(2, 2) ranges of reach and height, with the machine."""
    state = robot.close(robot.reference)
    frames = [robot.forward_kinematics(state, name).position for name in robot.frames]
    places = np.array(frames)
    x, y, z = places.T
    radius = np.hypot(x, y).max(initial=0.0)
    reach = float(max(np.nanmax(chart.radius), radius))
    low = float(min(np.nanmin(chart.height), z.min(), 0.0))
    high = float(max(np.nanmax(chart.height), z.max()))
    margin = 0.05 * max(reach, high - low)
    across = [-0.28 * reach, reach + margin]
    upward = [low - margin, high + margin]
    return np.array([across, upward])


def _paint_robot(axes: Axes, robot: Robot, limits: Array) -> None:
    """The robot at its reference, where its side view has these axes."""
    scene = make_scene(robot, None)
    if scene.projection.names != ("x [m]", "z [m]"):
        return
    scene = replace(with_visuals(scene, robot, None), lines=())
    paint_scene(axes, scene, "none", limits)


def _paint_masses(axes: Axes, chart: LiftingChart, factor: float) -> BoundaryNorm:
    """Paint the masses; returns their steps of colour."""
    triangles = _triangles(chart)
    mass = factor * np.nan_to_num(chart.mass.ravel())
    lifted = chart.mass[np.isfinite(chart.mass)]
    top = float(np.quantile(factor * lifted, _STEEPEST))
    locator = MaxNLocator(8, steps=[1, 2, 2.5, 5, 10])
    levels = locator.tick_values(0.0, max(top, 1e-9))
    norm = BoundaryNorm(levels, _COLOURS.N, extend="max")
    axes.tricontourf(
        triangles,
        mass,
        levels=levels,
        extend="max",
        cmap=_COLOURS,
        norm=norm,
        alpha=0.82,
        zorder=2.2,
    )
    axes.tricontour(triangles, mass, levels=levels[1:], colors=INK, linewidths=0.4, zorder=2.3)
    radius, height = chart.radius, chart.height
    for edge in (np.s_[0], np.s_[-1], np.s_[:, 0], np.s_[:, -1]):
        axes.plot(radius[edge], height[edge], color=INK, linewidth=1.1, zorder=2.4)
    return norm


def _triangles(chart: LiftingChart) -> Triangulation:
    """Triangles between neighbours of the grid that the robot reaches."""
    good = np.isfinite(chart.radius)
    return triangles_of(chart.radius, chart.height, good)


def _write_numbers(axes: Axes, chart: LiftingChart, factor: float, norm: BoundaryNorm) -> None:
    """Write masses at places of a regular grid."""
    low = float(np.nanmin(chart.height))
    high = float(np.nanmax(chart.height))
    reach = float(np.nanmax(chart.radius))
    extent = max(reach, high - low)
    step = next((size for size in _STEPS if extent / size <= _MOST), extent / _MOST)
    masses = np.nan_to_num(chart.mass.ravel())
    mass = LinearTriInterpolator(_triangles(chart), factor * masses)
    rows = np.arange(np.ceil(low / step), np.floor(high / step) + 1.0)
    columns = np.arange(0.0, np.floor(reach / step) + 1.0)
    for z in step * rows:
        for x in step * columns:
            value = mass(x, z)
            ends = mass(x + np.array([-0.2, 0.2]) * step, z + np.zeros(2))
            if np.ma.is_masked(value) or np.ma.is_masked(ends):
                continue  # outside, or the number would be across the edge
            share = norm(float(value)) / _COLOURS.N
            colour = "white" if share > _LIGHT else INK
            text = f"{float(value):.1f}" if factor != 1.0 else f"{float(value):.3g}"
            axes.text(x, z, text, ha="center", va="center", fontsize=7.5, color=colour, zorder=3.0)


def _bar(
    figure: Figure, norm: BoundaryNorm, unit: str, box: tuple[float, float, float, float]
) -> None:
    """The scale of colours below the chart."""
    axes = axes_at(figure, (box[0], 0.46, box[2], 0.14))
    bar = figure.colorbar(ScalarMappable(norm, _COLOURS), cax=axes, orientation="horizontal")
    bar.set_label(f"{_WORDS} [{unit}]", color=QUIET, fontsize=8)
    bar.outline.set_visible(False)
