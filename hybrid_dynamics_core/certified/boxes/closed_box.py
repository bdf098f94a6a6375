"""Boxes in which a mechanism is proved to close, in one way, for all given coordinates in a box.

For a box of given coordinates U, a box of the others X about y, and C near the inverse of the
Jacobian, Krawczyk's operator

    K(X) = y - C f(U, y) + (I - C J(U, X)) (X - y)

is evaluated over the traced graph of the loops' equations. If K(X) lies inside X, then for each u
in U there is one closed configuration in X, it lies in K(X), and the Jacobian is regular in X.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...algebra.scalar import Scalar
from ...closure.constraints.equations import loops_of
from ...ground.arrays import Array
from ...kernels.differentiate import jacobian
from ...kernels.graph import Graph
from ...mechanism.configuration import given_configuration
from ...programs import Model
from ..interval import Interval
from ..rounding import SHARE, bound, down, up
from .graph_values import GraphValues, columns
from .interval_matrix import IntervalMatrix

ATTEMPTS = 12
INFLATED = 1.5  # the box grows by this factor of what it would need
LEAST = 1e-15  # [rad, m] radius that is added
WIDER = (0.1, 0.03, 0.01, 1e-3, 1e-4, 1e-6)  # [rad, m]
MOST = 1.0  # [rad, m] radius above which a box is given up


class Cells(NamedTuple):
    """N boxes of given coordinates, with a configuration near the middle of each.

    Attributes:
        lower: lower bounds of the given coordinates (N, n) [rad, m].
        upper: upper bounds (N, n).
        near: values of the other coordinates (N, m) [rad, m].
    """

    lower: Array
    upper: Array
    near: Array


class ClosedBoxes(NamedTuple):
    """Boxes of the other coordinates.

    Attributes:
        lower: lower bounds (N, m) of the closed configurations [rad, m].
        upper: upper bounds (N, m).
        alone: radius (N, m) about `near` in which there is no other closed configuration.
        holds: whether all this was proved (N,).
    """

    lower: Array
    upper: Array
    alone: Array
    holds: NDArray[np.bool_]


class LoopGraph:
    """The equations of all loops as a traced graph, with their exact Jacobian.

    Attributes:
        given: the given coordinates.
        unknown: the other ones.
        is_square: whether there are as many equations as unknowns.
    """

    def __init__(
        self,
        model: Model,
        charts: Sequence[float],
    ) -> None:
        """Trace the equations.

        Args:
            model: tree and plan.
            charts: chart of each ball or free joint.
        """
        plan = model.plan
        self.given = list(plan.given)
        self.unknown = list(chain.from_iterable(block.unknowns for block in plan.blocks))
        graph = Graph()
        size = len(model.tree.coordinates)
        symbols = [graph.input(0, k) for k in range(size)]
        configuration = given_configuration(
            model.tree,
            dict(enumerate(symbols)),
            tuple(charts),
        )
        residuals: list[Scalar] = []
        guards: list[Scalar] = []
        for block in plan.blocks:
            linear = {}
            for loop in loops_of(block.equations):
                linear[loop] = loop.linearise(configuration).residual
                guards += loop.guards(configuration)
            residuals += [linear[e.loop][e.index] for e in block.equations]
        self.is_square = len(residuals) == len(self.unknown)
        slopes = jacobian(
            residuals,
            [symbols[k] for k in self.unknown],
        )
        self._residuals = GraphValues(graph, residuals)
        self._jacobian = GraphValues(graph, list(chain.from_iterable(slopes)))
        self._guards = GraphValues(graph, guards)

    def residuals(self, cells: Cells) -> IntervalMatrix:
        """f(U, y), as columns (N, m, 1)."""
        count = len(cells.near)
        inputs = self._inputs(cells, cells.near, cells.near)
        return IntervalMatrix.of(
            self._residuals.at(inputs, count),
            1,
            count,
        )

    def jacobian(self, cells: Cells, radius: Array) -> IntervalMatrix:
        """J(U, X) for boxes of this radius (N, m) about `near`."""
        count = len(cells.near)
        lower, upper = down(cells.near - radius), up(cells.near + radius)
        inputs = self._inputs(cells, lower, upper)
        entries = self._jacobian.at(inputs, count)
        return IntervalMatrix.of(entries, len(self.unknown), count)

    def guarded(
        self,
        cells: Cells,
        lower: Array,
        upper: Array,
    ) -> NDArray[np.bool_]:
        """Whether frames that must be parallel are proved not to be opposed (N,)."""
        count = len(cells.near)
        holds = np.ones(count, dtype=bool)
        for guard in self._guards.at(
            self._inputs(cells, lower, upper),
            count,
        ):
            holds &= guard.lower > 0.0
        return holds

    def _inputs(
        self,
        cells: Cells,
        lower: Array,
        upper: Array,
    ) -> dict[tuple[int, int], Interval]:
        inputs: dict[tuple[int, int], Interval] = {}
        for k, value in zip(
            self.given,
            columns(cells.lower, cells.upper),
            strict=True,
        ):
            inputs[0, k] = value
        for k, value in zip(
            self.unknown,
            columns(lower, upper),
            strict=True,
        ):
            inputs[0, k] = value
        return inputs


def closed_boxes(graph: LoopGraph, cells: Cells) -> ClosedBoxes:
    """Boxes that are proved to hold one closed configuration for each u of a cell."""
    count, size = cells.near.shape
    if not size:
        return ClosedBoxes(
            cells.near,
            cells.near,
            cells.near,
            np.ones(count, dtype=bool),
        )
    residual = graph.residuals(cells)
    radius = np.full((count, size), LEAST)
    holds = np.zeros(count, dtype=bool)
    step = np.zeros((count, size))
    doubt = np.full((count, size), np.inf)
    for _ in range(ATTEMPTS):
        slopes = graph.jacobian(cells, radius)
        inverse = slopes.preconditioner()
        step, doubt = _krawczyk(
            inverse,
            residual,
            slopes.defect(inverse),
            radius,
        )
        needed = bound(np.abs(step) + doubt)
        holds = np.asarray((needed < radius).all(axis=1))
        grows = ~holds & (needed < MOST).all(axis=1)
        if not grows.any():
            break
        radius = np.where(
            grows[:, None],
            np.maximum(radius, INFLATED * needed) + LEAST,
            radius,
        )
    centre = cells.near - step
    lower, upper = down(down(centre) - doubt), up(up(centre) + doubt)
    holds &= np.isfinite(lower).all(axis=1)
    holds &= graph.guarded(cells, lower, upper)
    return ClosedBoxes(lower, upper, radius, holds)


def alone_within(graph: LoopGraph, cells: Cells, boxes: ClosedBoxes) -> Array:
    """Larger radii (N, m) about `near` within which no other configuration is closed."""
    largest = boxes.alone.copy()
    residual = graph.residuals(cells)
    for size in WIDER:
        radius = np.full_like(largest, size)
        slopes = graph.jacobian(cells, radius)
        inverse = slopes.preconditioner()
        step, doubt = _krawczyk(
            inverse,
            residual,
            slopes.defect(inverse),
            radius,
        )
        proved = (bound(np.abs(step) + doubt) < radius).all(axis=1) & boxes.holds
        largest = np.where(
            proved[:, None],
            np.maximum(largest, radius),
            largest,
        )
        if proved.all():
            break
    return largest


def _krawczyk(
    inverse: Array, residual: IntervalMatrix, defect: Array, radius: Array
) -> tuple[Array, Array]:
    """C f (N, m), and the radius (N, m) of K(X) about y - C f."""
    sizes = np.abs(inverse)
    with np.errstate(invalid="ignore"):
        step = (inverse @ residual.middle)[..., 0]
        errors = residual.radius + SHARE * np.abs(residual.middle)
        doubt = (sizes @ errors)[..., 0] + (defect @ radius[:, :, None])[..., 0]
    return step, bound(doubt)
