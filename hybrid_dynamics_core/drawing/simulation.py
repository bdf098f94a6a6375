"""A simulation over time: coordinates, rates, efforts, energy."""

from __future__ import annotations

from typing import Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..errors import InputError
from ..robot import Robot
from ..simulation import Simulation
from .page import PLOTS, entitled, page
from .style import QUIET

_HEIGHT: Final = 8.4  # [in]
_COLUMNS: Final = 6  # of a legend
_STYLES: Final = ("-", "--", ":")  # where there are more curves than colours
_UNITS: Final = {"revolute": ("rad", "N m"), "prismatic": ("m", "N")}


def simulation_figure(robot: Robot, motion: Simulation, title: str | None) -> Figure:
    """Four axes over one time; a line where something was met. Raises InputError for another robot's motion."""
    if motion.names != robot.active:
        given, own = ", ".join(motion.names), ", ".join(robot.active)
        raise InputError(f"the motion is of {given}; the active joints of {robot.name} are {own}")
    with mpl.rc_context(PLOTS):
        figure = page(title or f"{robot.name}: simulated motion", line=_told(motion), height=_HEIGHT)
        axes = figure.subplots(4, 1, sharex=True)
        length, effort = _units(robot)
        panels = (
            ("active coordinates", f"u [{', '.join(length)}]", motion.u),
            ("their rates", f"u' [{', '.join(f'{unit}/s' for unit in length)}]", motion.du),
            ("efforts of the actuators", f"tau [{', '.join(effort)}]", motion.tau),
        )
        for ax, (words, label, values) in zip(axes, panels, strict=False):
            for k, (name, column) in enumerate(zip(motion.names, values.T, strict=True)):
                ax.plot(motion.t, column, _STYLES[k // _COLUMNS % len(_STYLES)], label=name)
            ax.set_ylabel(label)
            entitled(ax, words, min(len(motion.names), _COLUMNS))
        _energy(axes[3], motion)
        for ax in axes:
            for event in motion.events:
                ax.axvline(event.time, color=QUIET, linewidth=0.8)
        figure.align_ylabels(axes)
    return figure


def _told(motion: Simulation) -> str:
    return motion.message if len(motion.message) < 100 else f"{motion.message[:97]}..."


def _units(robot: Robot) -> tuple[list[str], list[str]]:
    """Units of the active coordinates and of their efforts, each once."""
    found = dict.fromkeys(_UNITS[robot.joint_types[name]] for name in robot.active)
    return [coordinate for coordinate, _ in found], [effort for _, effort in found]


def _energy(axes: Axes, motion: Simulation) -> None:
    energy = motion.energy
    axes.plot(motion.t, energy.kinetic, label="kinetic")
    axes.plot(motion.t, energy.potential - energy.potential[0], label="potential, from the start")
    if np.any(energy.springs):
        axes.plot(motion.t, energy.springs, label="springs")
    axes.plot(motion.t, motion.work, "--", label="work of efforts and friction")
    axes.set(xlabel="t [s]", ylabel="energy [J]")
    entitled(axes, "energy", 4)
