"""A simulation over time: coordinates, rates, efforts, energy."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...errors import InputError
from ...ground.arrays import Array
from ...ground.units import coordinate_unit, effort_unit
from ...robot.robot import Robot
from ...scene.style import QUIET
from ...simulation import Simulation
from ..page import CURVES, PLOTS, entitled, page
from .rounding import Sizes, least, sizes_of, suppress_rounding

_PANEL: Final = 2.1  # [in] height of axes with their names, where there are four
_LOW: Final = 1.65  # [in] where there are more
_FEW: Final = 4
_COLUMNS: Final = 6  # of a legend
_STYLES: Final = ("-", "--", ":")  # where there are more curves than colours
_KINDS: Final = ("revolute", "prismatic")
_APART: Final = 12.0  # times larger: what hides another curve on the same axes


@dataclass(frozen=True, eq=False)
class _Panel:
    """Axes with the curves of some active joints, by their places in the order of the robot; `size` by nature."""

    title: str
    label: str
    values: Array
    joints: tuple[int, ...]
    size: float


def simulation_figure(robot: Robot, motion: Simulation, title: str | None) -> Figure:
    """Axes over one time, for each kind of unit its own; a line where something was met.

    Raises InputError for another robot's motion.
    """
    if motion.names != robot.active:
        given, own = ", ".join(motion.names), ", ".join(robot.active)
        raise InputError(f"the motion is of {given}; the active joints of {robot.name} are {own}")
    sizes = sizes_of(robot, float(np.ptp(motion.t)))
    panels = list(_panels(robot, motion, sizes))
    count = len(panels) + 1
    with mpl.rc_context(PLOTS):
        height = count * (_PANEL if count <= _FEW else _LOW)
        figure = page(title or f"{robot.name}: simulated motion", line=_told(motion), height=height)
        axes = figure.subplots(count, 1, sharex=True)
        for ax, panel in zip(axes, panels, strict=False):
            for k in panel.joints:
                look = {
                    "color": CURVES[k % len(CURVES)],
                    "linestyle": _STYLES[k // len(CURVES) % len(_STYLES)],
                }
                ax.plot(motion.t, panel.values[:, k], label=motion.names[k], **look)
            ax.set_ylabel(panel.label)
            suppress_rounding(ax, panel.size)
            entitled(ax, panel.title, min(len(panel.joints), _COLUMNS))
        _energy(axes[-1], motion, sizes.energy)
        for ax in axes:
            for event in motion.events:
                ax.axvline(event.time, color=QUIET, linewidth=0.8)
        figure.align_ylabels(axes)
    return figure


def _told(motion: Simulation) -> str:
    return motion.message if len(motion.message) < 100 else f"{motion.message[:97]}..."


def _panels(robot: Robot, motion: Simulation, sizes: Sizes) -> Iterator[_Panel]:
    """Coordinates, rates and efforts: joints of one unit together, unless some are lost beside others."""
    for words, symbol, values, natural, unit in (
        ("active coordinates", "u", motion.u, sizes.position, coordinate_unit),
        ("their rates", "u'", motion.du, sizes.rate, _rate_unit),
        ("efforts of the actuators", "tau", motion.tau, sizes.effort, effort_unit),
    ):
        first = words
        for kind in _KINDS:
            own = [k for k, name in enumerate(motion.names) if robot.joint_types[name] == kind]
            for joints in _readable(values, own, natural(kind)):
                label = f"{symbol} [{unit(kind)}]"
                yield _Panel(first, label, values, joints, natural(kind))
                first = ""


def _rate_unit(kind: str) -> str:
    return coordinate_unit(kind, "/s")


def _readable(values: Array, joints: list[int], natural: float) -> list[tuple[int, ...]]:
    """Joints in groups: none is so small beside the largest of its group that its curve looks like one of zeros.

    Those of a size of rounding are zero, which any axes show.
    """
    size = np.abs(values).max(axis=0)
    groups: list[list[int]] = []
    for k in sorted(joints, key=lambda k: -size[k]):
        largest = size[groups[-1][0]] if groups else 0.0
        if groups and (
            largest <= _APART * size[k] or size[k] <= least(natural, values[:, groups[0][0]])
        ):
            groups[-1].append(k)
        else:
            groups.append([k])
    return [tuple(sorted(group)) for group in sorted(groups, key=min)]


def _energy(axes: Axes, motion: Simulation, size: float) -> None:
    energy = motion.energy
    axes.plot(motion.t, energy.kinetic, label="kinetic")
    axes.plot(motion.t, energy.potential - energy.potential[0], label="potential, from the start")
    if np.any(energy.springs):
        axes.plot(motion.t, energy.springs, label="springs")
    axes.plot(motion.t, motion.work, "--", label="work of efforts and friction")
    axes.set(xlabel="t [s]", ylabel="energy [J]")
    suppress_rounding(axes, size)
    entitled(axes, "energy", 4)
