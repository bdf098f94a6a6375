"""Drawings of mechanisms: links, joints and loops of any robot, with the active joints named.

>>> from hybrid_dynamics_core import load
>>> from hybrid_dynamics_core.drawing import draw
>>> figure = draw(load("forging_chu2020"), path="forging.svg")

Matplotlib is needed only here: the extra `plot`.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..errors import InputError, MissingPackageError
from ..kinematics.workspace import Workspace
from ..robot.robot import Robot
from .options import Colour, Names, known_colour, known_names

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..simulation import Simulation

__all__ = ["draw", "draw_margins", "draw_modes", "draw_on", "draw_simulation", "draw_workspace"]


def draw(
    robot: Robot,
    state: ClosedState | None = None,
    path: str | os.PathLike[str] | None = None,
    *,
    names: Names = "active",
    title: str | None = None,
) -> Figure:
    """Draw a robot: a side view where all of it moves in one plane, an oblique view where not.

    state: one closed state; the reference configuration if None. path: where to write the figure,
    as .svg, .png or .pdf. names: which names are shown: none, those of the active joints, of all
    joints, or of links too. Raises InputError for a batch of states and for other suffixes,
    MissingPackageError without Matplotlib.
    """
    _need_matplotlib()
    from .figure import robot_figure, save  # noqa: PLC0415  needs Matplotlib

    figure = robot_figure(robot, state, known_names(names), title)
    if path is not None:
        save(figure, Path(path))
    return figure


def draw_on(
    axes: Axes, robot: Robot, state: ClosedState | None = None, *, names: Names = "active"
) -> None:
    """Draw a robot on two-dimensional axes whose size is final, without title and key; the limits are set here."""
    _need_matplotlib()
    from .paint.picture import limits_of, make_scene, paint_scene  # noqa: PLC0415

    scene = make_scene(robot, state)
    paint_scene(axes, scene, known_names(names), limits_of(scene))


def draw_modes(  # noqa: PLR0913 - options of one picture
    robot: Robot,
    u: ArrayLike | None = None,
    path: str | os.PathLike[str] | None = None,
    *,
    most: int = 16,
    names: Names = "none",
    title: str | None = None,
    mark_own: bool = True,
) -> Figure:
    """Draw the assembly modes of a robot at the active coordinates u (n,), side by side in one scale.

    u: the reference configuration if None. most: how many modes are drawn, in the order of
    `robot.assembly_modes`, the robot's own in any case. mark_own: whether the robot's own is told
    from the others. Raises InputError where no mode closes, and as `draw` does.
    """
    _need_matplotlib()
    from .figure import save  # noqa: PLC0415
    from .maps.modes import modes_figure  # noqa: PLC0415

    u = robot.reference if u is None else u
    modes = robot.assembly_modes(u)
    if not modes:
        raise InputError(
            f"{robot.name} has no assembly mode at these active coordinates: its loops do not close"
        )
    own = robot.close(u, check=False).branch if mark_own else {}
    figure = modes_figure(robot, modes, own, known_names(names), title, most)
    if path is not None:
        save(figure, Path(path))
    return figure


def draw_workspace(
    robot: Robot,
    workspace: Workspace | None = None,
    path: str | os.PathLike[str] | None = None,
    *,
    colour: Colour = "singularity",
    title: str | None = None,
) -> Figure:
    """Draw where the end effector can be, with the robot in its reference configuration on top.

    Planes are chosen for the robot: its own where it is planar, that of the arm where a column
    turns it, else three views. Colours are the least distance to a singularity, or the largest to a
    limit, of what lies behind a point. workspace: `robot.workspace()` if None. Raises as `draw`
    does.
    """
    _need_matplotlib()
    from .figure import save  # noqa: PLC0415
    from .maps.workspace import workspace_figure  # noqa: PLC0415

    figure = workspace_figure(
        robot, robot.workspace() if workspace is None else workspace, known_colour(colour), title
    )
    if path is not None:
        save(figure, Path(path))
    return figure


def draw_margins(
    robot: Robot,
    over: tuple[str, str],
    u: ArrayLike | None = None,
    path: str | os.PathLike[str] | None = None,
    *,
    colour: Colour = "singularity",
    title: str | None = None,
) -> Figure:
    """Draw how near to a singularity (or a limit) the robot is, over two active coordinates, and where strokes end.

    over: names of the two; the others stay at u (n,), the reference if None. Raises InputError for
    names that are not active coordinates, and as `draw` does.
    """
    _need_matplotlib()
    from .figure import save  # noqa: PLC0415
    from .maps.margin_map import over_figure  # noqa: PLC0415

    figure = over_figure(robot, over, u, known_colour(colour), title)
    if path is not None:
        save(figure, Path(path))
    return figure


def draw_simulation(
    robot: Robot,
    motion: Simulation,
    path: str | os.PathLike[str] | None = None,
    *,
    title: str | None = None,
) -> Figure:
    """Draw a simulated motion of a robot over time: coordinates, rates, efforts, energy, and when something was met.

    Raises InputError for a motion of other active joints, and as `draw` does.
    """
    _need_matplotlib()
    from .figure import save  # noqa: PLC0415
    from .plots.simulation import simulation_figure  # noqa: PLC0415

    figure = simulation_figure(robot, motion, title)
    if path is not None:
        save(figure, Path(path))
    return figure


def _need_matplotlib() -> None:
    try:
        import matplotlib  # noqa: F401, PLC0415
    except ImportError as error:
        raise MissingPackageError("matplotlib", "plot", "drawings") from error
