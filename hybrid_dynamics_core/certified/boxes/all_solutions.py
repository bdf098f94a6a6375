"""All solutions of the equations of loops in a box, by subdivision.

A box is dropped if an equation cannot vanish in it, or if Krawczyk's operator maps a slightly
larger box outside of it (Moore, Kearfott and Cloud 2009, chapter 8). If the operator maps the
larger box into itself, that box holds exactly one solution. Other boxes shrink to what the operator
leaves of them, and are halved. If no box is left, all solutions are proved.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...ground.arrays import Array
from ..rounding import bound, down, up
from .closed_box import krawczyk, solution_boxes
from .loop_graph import Cells, LoopGraph

AT_ONCE = 4096  # boxes whose arrays are in memory together
WORK = 200_000  # boxes times unknowns after which the search is given up
SINGULAR = 1e-7  # [rad, m] a box of this width that is not decided holds a singular place
LARGER = 1.05  # share by which the tested box is larger, so that faces of boxes hold no solution
MORE = 1e-9  # [rad, m] and this, for small boxes
TURNS = 1e-13  # [rad] more than the rounding of a whole turn
TURN = 2.0 * np.pi
STEPS = 8  # of Newton's method from a box in which Krawczyk's operator contracts


class Region(NamedTuple):
    """Where solutions are sought.

    Attributes:
        given_lower: lower bounds of the given coordinates (n,) [rad, m].
        given_upper: upper bounds (n,).
        lower: lower bounds of the unknowns (m,).
        upper: upper bounds (m,); for angles, a whole turn above the lower ones or a little more.
        turns: which of the unknowns are angles (m,).
    """

    given_lower: Array
    given_upper: Array
    lower: Array
    upper: Array
    turns: NDArray[np.bool_]

    def cells(self, near: Array) -> Cells:
        """The given coordinates beside N rows of unknowns."""
        shape = (len(near), len(self.given_lower))
        return Cells(
            np.broadcast_to(self.given_lower, shape),
            np.broadcast_to(self.given_upper, shape),
            near,
        )


class Solutions(NamedTuple):
    """Certified solutions.

    Attributes:
        middle: values of the unknowns (modes, m), within 1e-12 of each solution [rad, m].
        complete: whether they were proved to be all.
        boxes: how many boxes were looked at.
    """

    middle: Array
    complete: bool
    boxes: int


class _Certified(NamedTuple):
    """Boxes with one solution each, about `middle`, alone within `radius`; both (N, m)."""

    middle: Array
    radius: Array


def all_solutions(graph: LoopGraph, region: Region) -> Solutions:
    """All solutions of the equations whose guards are positive."""
    size = len(region.lower)
    waiting = [(region.lower[None], region.upper[None])]
    certificates: list[_Certified] = []
    boxes = 0
    while waiting and boxes * size < WORK:
        lower, upper = waiting.pop()
        boxes += len(lower)
        lower, upper, certified = _step(graph, region, lower, upper)
        certificates.append(certified)
        if ((upper - lower).max(axis=1) < SINGULAR).any():
            waiting.append((lower, upper))
            break
        for first in range(0, len(lower), AT_ONCE):
            part = slice(first, first + AT_ONCE)
            waiting.append((lower[part], upper[part]))
    middle = np.concatenate([one.middle for one in certificates])
    radius = np.concatenate([one.radius for one in certificates])
    distinct, decided = _distinct(graph, region, _Certified(middle, radius))
    return Solutions(distinct, decided and not waiting, boxes)


def _step(
    graph: LoopGraph, region: Region, lower: Array, upper: Array
) -> tuple[Array, Array, _Certified]:
    """The halves of boxes (N, m) that are not decided, and the boxes with one solution."""
    middle, radius = _around(lower, upper)
    possible = graph.may_vanish(region.cells(middle), radius)
    lower, upper, middle = lower[possible], upper[possible], middle[possible]
    radius = bound(LARGER * radius[possible] + MORE)
    if not len(middle):
        return lower, upper, _Certified(middle, radius)
    cells = region.cells(middle)
    slopes = graph.jacobian(cells, radius)
    inverse = slopes.preconditioner()
    move, uncertainty = krawczyk(inverse, graph.residuals(cells), slopes.defect(inverse), radius)
    with np.errstate(invalid="ignore"):
        alone = (bound(np.abs(move) + uncertainty) < radius).all(axis=1)
        lower = np.fmax(lower, down(down(middle - move) - uncertainty))
        upper = np.fmin(upper, up(up(middle - move) + uncertainty))
    left = ~alone & (lower <= upper).all(axis=1)
    sizes = np.abs(slopes.middle) + slopes.radius
    halves = _halves(lower[left], upper[left], sizes[left])
    return *halves, _Certified(middle[alone], radius[alone])


def _around(lower: Array, upper: Array) -> tuple[Array, Array]:
    """Middles and radii of boxes."""
    middle = 0.5 * (lower + upper)
    return middle, np.maximum(up(upper - middle), up(middle - lower))


def _halves(lower: Array, upper: Array, slopes: Array) -> tuple[Array, Array]:
    """Both halves of boxes (N, m), cut where it changes the equations most.

    Args:
        lower: lower bounds.
        upper: upper bounds.
        slopes: magnitudes of the Jacobian (N, m, m).
    """
    width = upper - lower
    effect = np.nan_to_num(slopes.max(axis=1), posinf=1.0) * width
    cut = effect.argmax(axis=1)
    rows = np.arange(len(cut))
    middle = 0.5 * (lower[rows, cut] + upper[rows, cut])
    below, above = upper.copy(), lower.copy()
    below[rows, cut] = above[rows, cut] = middle
    return np.concatenate([lower, above]), np.concatenate([below, upper])


def _distinct(graph: LoopGraph, region: Region, proved: _Certified) -> tuple[Array, bool]:
    """The solutions (modes, m) with positive guards, each once, and whether all was decided."""
    if not len(proved.middle):
        return proved.middle, True
    near = _refined(graph, region, proved)
    cells = region.cells(near)
    boxes = solution_boxes(graph, cells)
    middle, uncertainty = _around(boxes.lower, boxes.upper)
    slack = uncertainty + TURNS
    inside = (bound(np.abs(middle - proved.middle) + slack) < proved.radius).all(axis=1)
    decided = bool((boxes.holds & inside).all())
    guards = graph.guards(cells, boxes.lower, boxes.upper)
    decided &= bool(((guards.lower > 0.0) | (guards.upper < 0.0)).all())
    chosen: list[int] = []
    for k in np.flatnonzero(guards.lower > 0.0).tolist():
        apart = _apart(region, middle[k], middle[chosen])
        others = bound(apart) > slack[k] + slack[chosen]
        same = bound(np.abs(middle[k] - proved.middle[k]) + apart + slack[chosen])
        is_other = others.any(axis=1)
        is_same = (same < proved.radius[k]).all(axis=1)
        decided &= bool((is_other | is_same).all())
        if is_other.all():
            chosen.append(k)
    return middle[chosen], decided


def _apart(region: Region, x: Array, others: Array) -> Array:
    """Distances of unknowns, of angles to the next whole turn (N, m)."""
    distance = x - others
    turned = np.rint(distance / TURN) * TURN
    return np.abs(np.where(region.turns, distance - turned, distance))


def _refined(graph: LoopGraph, region: Region, proved: _Certified) -> Array:
    """The middles after some steps of Newton's method."""
    near = proved.middle
    still = np.zeros_like(near)
    for _ in range(STEPS):
        cells = region.cells(near)
        slopes = graph.jacobian(cells, still)
        inverse = slopes.preconditioner()
        move, _ = krawczyk(
            inverse, graph.residuals(cells), still[:, :, None] + still[:, None], still
        )
        near = near - move
    return near
