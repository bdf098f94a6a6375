"""Drawings of mechanisms: links, joints and loops of any robot, with the active joints named.

>>> from hybrid_dynamics_core import load
>>> from hybrid_dynamics_core.drawing import draw
>>> figure = draw(load("forging_chu2020"), path="forging.svg")

Matplotlib is needed only here: the extra `plot`.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from ..capability import LiftingChart, lifting_chart
from ..certified.boxes.cells import CertifiedCells
from ..closed_state.state import ClosedState
from ..errors import InputError
from ..kinematics.workspace import Workspace
from ..robot.taken import AnyRobot, robot_of
from .elastic import draw_displaced, draw_stiffness
from .options import Colour, Names, checked_colour, checked_names
from .output import need_matplotlib, write

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..simulation import Simulation

__all__ = [
    "draw",
    "draw_cells",
    "draw_displaced",
    "draw_lifting_chart",
    "draw_margins",
    "draw_modes",
    "draw_on",
    "draw_simulation",
    "draw_stiffness",
    "draw_workspace",
]


def draw(
    robot: AnyRobot,
    state: ClosedState | None = None,
    path: str | os.PathLike[str] | None = None,
    *,
    names: Names = "active",
    title: str | None = None,
    skeleton: bool = False,
) -> Figure:
    """Draw a robot: a side view if it moves in one plane, otherwise an oblique view.

    Args:
        robot: to be drawn, or its description.
        state: one closed state; None: the reference configuration.
        path: file of the figure, .svg, .png or .pdf.
        names: names to show: none, of active joints, of all joints, or of links too.
        title: title of the figure; None: the robot's name.
        skeleton: draw bars and plates between joints in place of the robot's visuals.

    Returns:
        The figure.

    Raises:
        InputError: for a batch of states, and for other suffixes.
        MissingPackageError: without Matplotlib.
    """
    need_matplotlib()
    robot = robot_of(robot)
    from .figure import robot_figure  # noqa: PLC0415  needs Matplotlib

    figure = robot_figure(robot, state, checked_names(names), title, skeleton)
    write(figure, path)
    return figure


def draw_on(
    axes: Axes,
    robot: AnyRobot,
    state: ClosedState | None = None,
    *,
    names: Names = "active",
    skeleton: bool = False,
) -> None:
    """Draw a robot on axes, without title and key.

    Args:
        axes: two-dimensional, of final size; their limits are set here.
        robot: to be drawn, or its description.
        state: one closed state; None: the reference configuration.
        names: which names to show.
        skeleton: draw bars and plates between joints in place of the robot's visuals.

    Raises:
        InputError: for a batch of states.
        MissingPackageError: without Matplotlib.
    """
    need_matplotlib()
    robot = robot_of(robot)
    from .paint.picture import (  # noqa: PLC0415
        limits_of,
        make_scene,
        paint_scene,
        with_visuals,
    )

    scene = make_scene(robot, state)
    if not skeleton:
        scene = with_visuals(scene, robot, state)
    paint_scene(axes, scene, checked_names(names), limits_of(scene))


def draw_modes(  # noqa: PLR0913 - options of one picture
    robot: AnyRobot,
    u: ArrayLike | None = None,
    path: str | os.PathLike[str] | None = None,
    *,
    most: int = 16,
    names: Names = "none",
    title: str | None = None,
    mark_own: bool = True,
) -> Figure:
    """Draw the assembly modes of a robot at active coordinates, side by side in one scale.

    Args:
        robot: to be drawn, or its description.
        u: (n,) active coordinates [rad or m]; None: the reference configuration.
        path: file of the figure, .svg, .png or .pdf.
        most: largest number of modes to draw, in the order of `robot.assembly_modes`. The robot's
            own mode is always drawn.
        names: which names to show.
        title: title of the figure; None: the robot's name.
        mark_own: whether the robot's own mode is marked.

    Returns:
        The figure.

    Raises:
        InputError: where no mode closes, and for other suffixes.
        MissingPackageError: without Matplotlib.
    """
    need_matplotlib()
    robot = robot_of(robot)
    from .maps.modes import modes_figure  # noqa: PLC0415  needs Matplotlib

    u = robot.reference if u is None else u
    modes = robot.assembly_modes(u)
    if not modes:
        raise InputError(
            f"{robot.name} has no assembly mode at these active coordinates: its loops do not close"
        )
    marked = robot.close(u, check=False).branch if mark_own else {}
    figure = modes_figure(robot, modes, marked, checked_names(names), title, most)
    write(figure, path)
    return figure


def draw_workspace(
    robot: AnyRobot,
    workspace: Workspace | None = None,
    path: str | os.PathLike[str] | None = None,
    *,
    colour: Colour = "singularity",
    title: str | None = None,
) -> Figure:
    """Draw the reachable places of the end effector, with the robot at its reference on top.

    A planar robot is shown in its plane. An arm on a turning column is shown in the arm's plane.
    Others are shown in three views.

    Args:
        robot: to be drawn, or its description.
        workspace: `robot.workspace()` if None.
        path: file of the figure, .svg, .png or .pdf.
        colour: quantity shown by colours. Each point shows one of the samples projected onto it:
            the least distance to a singularity, or the largest distance to a limit.
        title: title of the figure; None: the robot's name.

    Returns:
        The figure.

    Raises:
        InputError: for another colour, and for other suffixes.
        MissingPackageError: without Matplotlib.
    """
    need_matplotlib()
    robot = robot_of(robot)
    from .maps.workspace import workspace_figure  # noqa: PLC0415  needs Matplotlib

    if workspace is None:
        workspace = robot.workspace()
    figure = workspace_figure(robot, workspace, checked_colour(colour), title)
    write(figure, path)
    return figure


def draw_margins(
    robot: AnyRobot,
    over: tuple[str, str],
    u: ArrayLike | None = None,
    path: str | os.PathLike[str] | None = None,
    *,
    colour: Colour = "singularity",
    title: str | None = None,
) -> Figure:
    """Draw a map of distances to singularities or limits over two active coordinates.

    Args:
        robot: to be drawn, or its description.
        over: names of the two coordinates.
        u: (n,) constant values of the other active coordinates [rad or m]; None: the reference.
        path: file of the figure, .svg, .png or .pdf.
        colour: quantity shown by colours.
        title: title of the figure; None: the names of robot and coordinates.

    Returns:
        The figure.

    Raises:
        InputError: for names that are not active coordinates, and for other suffixes.
        MissingPackageError: without Matplotlib.
    """
    need_matplotlib()
    robot = robot_of(robot)
    from .maps.margin_map import margin_figure  # noqa: PLC0415  needs Matplotlib

    figure = margin_figure(robot, over, u, checked_colour(colour), title)
    write(figure, path)
    return figure


def draw_lifting_chart(
    robot: AnyRobot,
    chart: LiftingChart | None = None,
    path: str | os.PathLike[str] | None = None,
    *,
    title: str | None = None,
) -> Figure:
    """Draw a lifting chart: the mass that the drives hold over reach and height.

    Args:
        robot: to be drawn, or its description.
        chart: `capability.lifting_chart(robot)` if None.
        path: file of the figure, .svg, .png or .pdf.
        title: title of the figure; None: the robot's name.

    Returns:
        The figure.

    Raises:
        InputError: for other suffixes.
        MissingPackageError: without Matplotlib.
    """
    need_matplotlib()
    robot = robot_of(robot)
    from .maps.lifting import lifting_figure  # noqa: PLC0415  needs Matplotlib

    figure = lifting_figure(robot, lifting_chart(robot) if chart is None else chart, title)
    write(figure, path)
    return figure


def draw_cells(
    robot: AnyRobot,
    cells: CertifiedCells,
    path: str | os.PathLike[str] | None = None,
    *,
    title: str | None = None,
) -> Figure:
    """Draw certified cells of two active coordinates: inner and outer bounds of the workspace.

    Args:
        robot: to be drawn, or its description.
        cells: `robot.certify_cells(ranges)` with two ranges.
        path: file of the figure, .svg, .png or .pdf.
        title: title of the figure; None: the robot's name.

    Returns:
        The figure.

    Raises:
        InputError: for cells of more or fewer coordinates, and for other suffixes.
        MissingPackageError: without Matplotlib.
    """
    need_matplotlib()
    robot = robot_of(robot)
    from .maps.certified_cells import cells_figure  # noqa: PLC0415  needs Matplotlib

    figure = cells_figure(robot, cells, title)
    write(figure, path)
    return figure


def draw_simulation(
    robot: AnyRobot,
    motion: Simulation,
    path: str | os.PathLike[str] | None = None,
    *,
    title: str | None = None,
) -> Figure:
    """Draw a simulated motion over time: coordinates, rates, efforts, energy, and events.

    Args:
        robot: robot of the motion.
        motion: the simulated motion.
        path: file of the figure, .svg, .png or .pdf.
        title: title of the figure; None: the robot's name.

    Returns:
        The figure.

    Raises:
        InputError: for a motion of other active joints, and for other suffixes.
        MissingPackageError: without Matplotlib.
    """
    need_matplotlib()
    robot = robot_of(robot)
    from .plots.simulation import simulation_figure  # noqa: PLC0415  needs Matplotlib

    figure = simulation_figure(robot, motion, title)
    write(figure, path)
    return figure
