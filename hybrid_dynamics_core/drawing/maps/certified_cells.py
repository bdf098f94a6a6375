"""Certified cells over two active coordinates."""

from __future__ import annotations

from typing import Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from ...certified.boxes.cells import CellKind, CertifiedCells
from ...errors import InputError
from ...ground.arrays import Array
from ...ground.units import coordinate_unit
from ...ground.wording import counted
from ...robot.robot import Robot
from ...scene.style import INK, SKY, STEEL, STYLE
from ..paint.layout import axes_at
from .colours import head

_SIZE: Final = (6.9, 5.3)  # [in] of the figure
_BOX: Final = (0.8, 1.1, 5.9, 3.5)  # [in] of the axes
_COLOURS: Final = {
    CellKind.CLOSED: SKY,
    CellKind.OPEN: STEEL,
    CellKind.UNDECIDED: "#f0c987",
}
_WORDS: Final = {
    CellKind.CLOSED: "closed, not singular",
    CellKind.OPEN: "open",
    CellKind.UNDECIDED: "undecided",
}


def cells_figure(
    robot: Robot,
    cells: CertifiedCells,
    title: str | None,
) -> Figure:
    """The cells of two coordinates.

    Raises:
        InputError: the cells are not those of two coordinates of the robot.
    """
    free = _free(robot, cells)
    share = 100.0 * (1.0 - cells.share(CellKind.UNDECIDED))
    line = f"{counted(len(cells.kind), 'cell')}; {share:.1f} % of the box are decided"
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=_SIZE)
        head(figure, title or f"Certified cells: {robot.name}", line)
        axes = axes_at(figure, _BOX)
        for kind, colour in _COLOURS.items():
            rows = cells.kind == kind
            _paint(
                axes,
                cells.lower[rows][:, free],
                cells.upper[rows][:, free],
                colour,
            )
        names = [robot.active[k] for k in free]
        units = [coordinate_unit(robot.joint_types[name]) for name in names]
        axes.set(xlabel=f"{names[0]} [{units[0]}]", ylabel=f"{names[1]} [{units[1]}]")
        handles = [Patch(facecolor=_COLOURS[kind], label=_WORDS[kind]) for kind in CellKind]
        figure.legend(
            handles=handles,
            loc="lower left",
            ncols=3,
            frameon=False,
        )
    return figure


def _free(robot: Robot, cells: CertifiedCells) -> list[int]:
    """The two coordinates that are not constant."""
    differences = cells.upper - cells.lower
    widths = differences.max(axis=0, initial=0.0)
    free = np.flatnonzero(widths > 0.0).tolist()
    if len(widths) != len(robot.active) or len(free) != 2:
        count = counted(len(free), "coordinate")
        raise InputError(f"cells: they vary {count}; expected two of robot '{robot.name}'")
    return free


def _paint(
    axes: Axes,
    lower: Array,
    upper: Array,
    colour: str,
) -> None:
    """Rectangles (N, 2)."""
    left, bottom = lower.T
    right, top = upper.T
    corners = [
        (left, bottom),
        (right, bottom),
        (right, top),
        (left, top),
    ]
    shapes = np.stack(
        [np.stack(corner, axis=1) for corner in corners],
        axis=1,
    )
    cells = PolyCollection(
        list(shapes),
        facecolors=colour,
        edgecolors=INK,
        linewidths=0.1,
    )
    axes.add_collection(cells)
    axes.autoscale_view()
