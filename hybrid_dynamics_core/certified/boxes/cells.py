"""Cells of active coordinates in which all configurations are proved to close, or none."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...ground.arrays import Array
from .closed_box import ClosedBoxes, closed_boxes
from .closed_forms import ClosedForms, Verdicts
from .loop_graph import Cells, LoopGraph

Near = Callable[[Array], tuple[Array, NDArray[np.bool_]]]


class CellKind(IntEnum):
    """What is proved of a cell."""

    CLOSED = 0  # the loops close for each u in it, and none of the configurations is singular
    OPEN = 1  # some loop closes for no u in it
    UNDECIDED = 2


@dataclass(frozen=True, eq=False)
class CertifiedCells:
    """Cells that fill a box of active coordinates.

    The closed ones are an inner bound of the coordinates at which the robot closes on its assembly
    modes without a singularity. All but the open ones are an outer bound.

    Attributes:
        lower: (N, n) lower bounds of the active coordinates [rad or m].
        upper: (N, n) upper bounds.
        kind: (N,) CellKind.
        position_lower: (N, 3) lower bounds of the frame's places, base axes [m]; NaN where the cell
            is not closed.
        position_upper: (N, 3) upper bounds.
    """

    lower: Array
    upper: Array
    kind: NDArray[np.int64]
    position_lower: Array
    position_upper: Array

    def share(self, kind: CellKind) -> float:
        """The share of the box that cells of a kind take."""
        widths = self.upper - self.lower
        free = widths.max(axis=0) > 0.0
        volumes = widths[:, free].prod(axis=1)
        return float(volumes[self.kind == kind].sum() / volumes.sum())


class Decided(NamedTuple):
    """Cells with what is proved of them.

    Attributes:
        cells: the cells (N).
        kinds: CellKind of each (N,).
        boxes: boxes of the other coordinates, where Krawczyk's test holds.
        forms: what closed forms prove.
    """

    cells: Cells
    kinds: NDArray[np.int64]
    boxes: ClosedBoxes
    forms: Verdicts


class Subdivision:
    """Divides a box of active coordinates until its cells are decided.

    Args:
        graph: the equations of the loops.
        forms: the closed forms of the loops.
        near: gives the other coordinates (N, m) at given ones (N, n), and whether they close (N,).
    """

    def __init__(
        self,
        graph: LoopGraph,
        forms: ClosedForms,
        near: Near,
    ) -> None:
        self._graph = graph
        self._forms = forms
        self._near = near

    def decided(
        self,
        lower: Array,
        upper: Array,
        depth: int,
    ) -> Decided:
        """The cells of a box.

        Args:
            lower: lower bounds (n,) of the active coordinates [rad, m].
            upper: upper bounds (n,).
            depth: how often a cell is halved at most, each time across its longest side.
        """
        widths = np.where(upper > lower, upper - lower, 1.0)
        parts: list[Decided] = []
        lowers, uppers = lower[None], upper[None]
        for level in range(depth + 1):
            decided = self._classified(lowers, uppers)
            goes_on = (decided.kinds == CellKind.UNDECIDED) & (level < depth)
            parts.append(_chosen(decided, ~goes_on))
            if not goes_on.any():
                break
            lowers, uppers = _halved(lowers[goes_on], uppers[goes_on], widths)
        return _joined(parts)

    def _classified(self, lower: Array, upper: Array) -> Decided:
        near, closes = self._near(0.5 * (lower + upper))
        cells = Cells(lower, upper, near)
        with np.errstate(all="ignore"):
            boxes = closed_boxes(self._graph, cells)
            forms = self._forms.at(lower, upper)
        boxes = boxes._replace(holds=boxes.holds & closes)
        kinds = np.full(
            len(lower),
            CellKind.UNDECIDED,
            dtype=np.int64,
        )
        kinds[forms.is_open] = CellKind.OPEN
        kinds[boxes.holds | forms.closes] = CellKind.CLOSED
        return Decided(cells, kinds, boxes, forms)


def _chosen(
    decided: Decided,
    rows: NDArray[np.bool_],
) -> Decided:
    """Some of the cells."""
    cells = Cells(*(part[rows] for part in decided.cells))
    boxes = decided.boxes
    box = ClosedBoxes(
        boxes.lower[rows],
        boxes.upper[rows],
        boxes.alone[rows],
        boxes.holds[rows],
    )
    forms = decided.forms
    closes, is_open = forms.closes[rows], forms.is_open[rows]
    verdicts = Verdicts(
        closes,
        is_open,
        forms.place_lower[rows],
        forms.place_upper[rows],
    )
    return Decided(cells, decided.kinds[rows], box, verdicts)


def _joined(parts: Sequence[Decided]) -> Decided:
    """All cells of some parts."""
    cells, kinds, boxes, forms = zip(*parts, strict=True)
    return Decided(
        Cells(*map(np.concatenate, zip(*cells, strict=True))),
        np.concatenate(kinds),
        ClosedBoxes(*map(np.concatenate, zip(*boxes, strict=True))),
        Verdicts(*map(np.concatenate, zip(*forms, strict=True))),
    )


def _halved(
    lower: Array,
    upper: Array,
    widths: Array,
) -> tuple[Array, Array]:
    """Both halves of cells (N, n), divided across the longest side in shares of `widths`."""
    sides = ((upper - lower) / widths).argmax(axis=1)
    rows = np.arange(len(lower))
    middle = 0.5 * (lower[rows, sides] + upper[rows, sides])
    first_upper, second_lower = upper.copy(), lower.copy()
    first_upper[rows, sides] = middle
    second_lower[rows, sides] = middle
    return np.concatenate([lower, second_lower]), np.concatenate([first_upper, upper])
