"""A simulation over time: coordinates, rates, efforts, energy."""

from __future__ import annotations

from collections.abc import Callable, Iterator
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
from .legend_text import legend_text
from .rounding import Sizes, rounding_of, sizes_of, suppress_rounding

_PANEL: Final = 2.1  # [in] height of a panel if there are at most _ROOMY
_LOW: Final = 1.65  # [in] height of a panel if there are more
_ROOMY: Final = 4
_COLUMNS: Final = 6  # of a legend
_STYLES: Final = ("-", "--", ":")  # used in turn if there are more curves than colours
_TYPES: Final = ("revolute", "prismatic")
_APART: Final = 12.0  # ratio of sizes at which a curve needs axes of its own
_LONGEST: Final = 100  # letters of the subtitle


@dataclass(frozen=True, eq=False)
class _Quantity:
    """A quantity of all active joints.

    Attributes:
        title: name of the quantity.
        symbol: its symbol.
        values: (N, n).
        size: natural size by type of joint.
        unit: units by type of joint.
    """

    title: str
    symbol: str
    values: Array
    size: Callable[[str], float]
    unit: Callable[[str], str]


@dataclass(frozen=True, eq=False)
class _Panel:
    """Axes with the curves of some active joints.

    Attributes:
        title: title of the axes; empty if they continue the quantity of the axes above.
        label: symbol and unit.
        values: (N, n) of all active joints.
        joints: indices of the joints to draw.
        size: natural size of the values.
    """

    title: str
    label: str
    values: Array
    joints: tuple[int, ...]
    size: float


def simulation_figure(robot: Robot, motion: Simulation, title: str | None) -> Figure:
    """Panels over time, one or more for each unit, with lines at the events.

    Args:
        robot: robot of the motion.
        motion: to be drawn.
        title: title of the figure; None: the robot's name.

    Returns:
        The figure.

    Raises:
        InputError: for another robot's motion.
    """
    if motion.names != robot.active:
        raise InputError(
            f"the motion is of {', '.join(motion.names)}; the active joints of {robot.name} are"
            f" {', '.join(robot.active)}"
        )
    sizes = sizes_of(robot, float(np.ptp(motion.t)))
    panels = list(_panels(robot, motion, sizes))
    count = len(panels) + 1
    with mpl.rc_context(PLOTS):
        height = count * (_PANEL if count <= _ROOMY else _LOW)
        title = title or f"{robot.name}: simulated motion"
        figure = page(title, line=_line(motion), height=height)
        axes = figure.subplots(count, 1, sharex=True)
        for ax, panel in zip(axes, panels, strict=False):
            _draw_panel(ax, motion, panel)
        _draw_energy(axes[-1], motion, sizes.energy)
        for ax in axes:
            for event in motion.events:
                ax.axvline(event.time, color=QUIET, linewidth=0.8)
        figure.align_ylabels(axes)
    return figure


def _line(motion: Simulation) -> str:
    """The subtitle: why the motion ended."""
    if len(motion.message) < _LONGEST:
        return motion.message
    return f"{motion.message[:97]}..."


def _panels(robot: Robot, motion: Simulation, sizes: Sizes) -> Iterator[_Panel]:
    """Panels with the joints of one unit together, unless their sizes differ too much."""
    for quantity in _quantities(motion, sizes):
        title = quantity.title
        for kind in _TYPES:
            joints = [k for k, name in enumerate(motion.names) if robot.joint_types[name] == kind]
            if quantity.values is motion.tau:
                joints = [k for k in joints if _has_effort(robot, motion, k)]
            size = quantity.size(kind)
            label = f"{quantity.symbol} [{quantity.unit(kind)}]"
            for group in _readable(quantity.values, joints, size):
                yield _Panel(title, label, quantity.values, group, size)
                title = ""


def _has_effort(robot: Robot, motion: Simulation, k: int) -> bool:
    """Whether a coordinate is driven, or has an effort above zero."""
    return motion.names[k] not in robot.idle or bool(motion.tau[:, k].any())


def _quantities(motion: Simulation, sizes: Sizes) -> list[_Quantity]:
    return [
        _Quantity("active coordinates", "u", motion.u, sizes.position, coordinate_unit),
        _Quantity("their rates", "u'", motion.du, sizes.rate, _rate_unit),
        _Quantity("efforts of the actuators", "tau", motion.tau, sizes.effort, effort_unit),
    ]


def _rate_unit(joint_type: str) -> str:
    return coordinate_unit(joint_type, "/s")


def _readable(values: Array, joints: list[int], natural: float) -> list[tuple[int, ...]]:
    """Groups of joints of similar size, in which no curve looks like zero beside others.

    Curves of rounding only count as zero, and may be in any group.
    """
    size = np.abs(values).max(axis=0)
    by_size = sorted(joints, key=lambda k: -size[k])
    groups: list[list[int]] = []
    for k in by_size:
        if groups and _fits(values, groups, size, k, natural):
            groups[-1].append(k)
        else:
            groups.append([k])
    return [tuple(sorted(group)) for group in sorted(groups, key=min)]


def _fits(
    values: Array,
    groups: list[list[int]],
    size: Array,
    joint: int,
    natural: float,
) -> bool:
    """Whether a joint is large enough for the last group, or is only rounding."""
    if size[groups[-1][0]] <= _APART * size[joint]:
        return True
    return bool(size[joint] <= rounding_of(natural, values[:, groups[0][0]]))


def _draw_panel(axes: Axes, motion: Simulation, panel: _Panel) -> None:
    for k in panel.joints:
        colour = CURVES[k % len(CURVES)]
        style = _STYLES[k // len(CURVES) % len(_STYLES)]
        name = motion.names[k]
        axes.plot(
            motion.t,
            panel.values[:, k],
            label=legend_text(name),
            color=colour,
            linestyle=style,
        )
    axes.set_ylabel(panel.label)
    suppress_rounding(axes, panel.size)
    entitled(axes, panel.title, min(len(panel.joints), _COLUMNS))


def _draw_energy(axes: Axes, motion: Simulation, size: float) -> None:
    energy = motion.energy
    axes.plot(motion.t, energy.kinetic, label="kinetic")
    axes.plot(motion.t, energy.potential - energy.potential[0], label="potential, from the start")
    if np.any(energy.springs):
        axes.plot(motion.t, energy.springs, label="springs")
    axes.plot(motion.t, motion.work, "--", label="work of efforts and friction")
    axes.set(xlabel="t [s]", ylabel="energy [J]")
    suppress_rounding(axes, size)
    entitled(axes, "energy", 4)
