"""Drawings of elastic robots: displaced links, and maps of stiffness."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..errors import InputError
from ..robot.taken import AnyRobot, robot_of
from ..stiffness import StiffnessMap
from .options import vectors_of_links
from .output import need_matplotlib, write

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_displaced(
    robot: AnyRobot,
    state: ClosedState,
    displacements: Mapping[str, ArrayLike],
    path: str | os.PathLike[str] | None = None,
    *,
    scale: float | None = None,
    title: str | None = None,
) -> Figure:
    """Draw a robot whose links are displaced, as under a load or in a natural mode.

    Args:
        robot: to be drawn, or its description.
        state: one closed state.
        displacements: displacement (6,) of each link's origin and its turn, base axes [m, rad], as
            `links` of a deflection has them.
        path: file of the figure, .svg, .png or .pdf.
        scale: by which displacements are multiplied; None: a round number that shows them well.
        title: title of the figure; None: the robot's name.

    Returns:
        The figure.

    Raises:
        InputError: for a link that is not there, and for other suffixes.
    """
    need_matplotlib()
    robot = robot_of(robot)
    from .maps.displaced import displaced_figure  # noqa: PLC0415  needs Matplotlib

    moved = vectors_of_links(robot, displacements)
    figure = displaced_figure(robot, state, moved, title or robot.name, scale)
    write(figure, path)
    return figure


def draw_stiffness(
    robot: AnyRobot,
    chart: StiffnessMap,
    path: str | os.PathLike[str] | None = None,
    *,
    title: str | None = None,
) -> Figure:
    """Draw a map of how far a frame gives way under a force.

    Args:
        robot: the robot, or its description.
        chart: `stiffness.stiffness_map(robot, joints, force)`.
        path: file of the figure, .svg, .png or .pdf.
        title: title of the figure; None: the robot's name.

    Returns:
        The figure.

    Raises:
        InputError: where the robot is nowhere held, and for other suffixes.
    """
    need_matplotlib()
    robot = robot_of(robot)
    from .maps.stiffness import stiffness_figure  # noqa: PLC0415  needs Matplotlib

    if not np.isfinite(chart.deflection).any():
        raise InputError(f"{robot.name} is nowhere held within its limits; the map is empty")
    figure = stiffness_figure(robot, chart, title)
    write(figure, path)
    return figure
