"""Boxes in which a mechanism is proved to close, in one way, for all given coordinates in a box.

For a box of given coordinates U, a box of the others X about y, and C near the inverse of the
Jacobian, Krawczyk's operator

    K(X) = y - C f(U, y) + (I - C J(U, X)) (X - y)

is evaluated over the traced graph of the loops' equations. If K(X) lies inside X, then for each u
in U there is one closed configuration in X, it lies in K(X), and the Jacobian is regular in X.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...ground.arrays import Array
from ..rounding import SHARE, bound, down, up
from .interval_matrix import IntervalMatrix
from .loop_graph import Cells, LoopGraph

ATTEMPTS = 12
INFLATED = 1.5  # the box grows by this factor of what it would need
LEAST = 1e-15  # [rad, m] radius that is added
WIDER = (0.1, 0.03, 0.01, 1e-3, 1e-4, 1e-6)  # [rad, m]
MOST = 1.0  # [rad, m] radius above which a box is given up


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


def closed_boxes(graph: LoopGraph, cells: Cells) -> ClosedBoxes:
    """Boxes that are proved to hold one closed configuration for each u of a cell."""
    boxes = solution_boxes(graph, cells)
    guards = graph.guards(cells, boxes.lower, boxes.upper)
    return boxes._replace(holds=boxes.holds & (guards.lower > 0.0))


def solution_boxes(graph: LoopGraph, cells: Cells) -> ClosedBoxes:
    """Boxes that are proved to hold one solution of the equations, whatever the guards."""
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
    uncertainty = np.full((count, size), np.inf)
    for _ in range(ATTEMPTS):
        slopes = graph.jacobian(cells, radius)
        inverse = slopes.preconditioner()
        step, uncertainty = krawczyk(
            inverse,
            residual,
            slopes.defect(inverse),
            radius,
        )
        needed = bound(np.abs(step) + uncertainty)
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
    lower, upper = down(down(centre) - uncertainty), up(up(centre) + uncertainty)
    holds &= np.isfinite(lower).all(axis=1)
    return ClosedBoxes(lower, upper, radius, holds)


def alone_within(graph: LoopGraph, cells: Cells, boxes: ClosedBoxes) -> Array:
    """Larger radii (N, m) about `near` within which no other configuration is closed."""
    largest = boxes.alone.copy()
    residual = graph.residuals(cells)
    for size in WIDER:
        radius = np.full_like(largest, size)
        slopes = graph.jacobian(cells, radius)
        inverse = slopes.preconditioner()
        step, uncertainty = krawczyk(
            inverse,
            residual,
            slopes.defect(inverse),
            radius,
        )
        proved = (bound(np.abs(step) + uncertainty) < radius).all(axis=1) & boxes.holds
        largest = np.where(
            proved[:, None],
            np.maximum(largest, radius),
            largest,
        )
        if proved.all():
            break
    return largest


def krawczyk(
    inverse: Array, residual: IntervalMatrix, defect: Array, radius: Array
) -> tuple[Array, Array]:
    """C f (N, m), and the radius (N, m) of K(X) about y - C f."""
    sizes = np.abs(inverse)
    with np.errstate(invalid="ignore"):
        step = (inverse @ residual.middle)[..., 0]
        errors = residual.radius + SHARE * np.abs(residual.middle)
        uncertainty = (sizes @ errors)[..., 0] + (defect @ radius[:, :, None])[..., 0]
    return step, bound(uncertainty)
