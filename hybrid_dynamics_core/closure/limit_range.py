"""The range of a given coordinate in which the joints that follow it stay within their limits."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..algebra.scalar import Scalar
from ..ground.arrays import Array
from ..mechanism.configuration import Configuration, given_configuration
from ..mechanism.tree import Tree
from .blocks.block_solver import BlockSolver
from .blocks.joint_coupling import JointCouplingBlock
from .numeric_closure import CLOSED
from .plan import ClosurePlan
from .toggle_range import Range, given_inputs, searched_half

Flags = NDArray[np.bool_]
EVERYWHERE = (-math.inf, math.inf)
_SAMPLES = 2000  # to either side
_PARTS = 32  # pieces into which an interval around an end is divided
_ROUNDS = 11  # divisions until an end is exact to rounding


def limited_range(tree: Tree, plan: ClosurePlan, k: int) -> Range:
    """The range of a given coordinate that the limits of dependent joints allow.

    Only joints that depend on no other given coordinate count. Angles are followed from the
    reference, with whole turns.

    Args:
        tree: the spanning tree.
        plan: closure plan with its own assembly modes.
        k: the given coordinate.

    Returns:
        Lower and upper end [rad or m]; infinite if no joint meets a limit, or only an iteration
        could find it.
    """
    search = LimitSearch(tree, plan, k)
    if not search.limits:
        return EVERYWHERE
    return search.end(-1), search.end(1)


class LimitSearch:
    """Follows the joints that depend on one given coordinate while it moves.

    Args:
        tree: the spanning tree.
        plan: closure plan.
        k: the given coordinate that moves.

    Attributes:
        limits: finite limits of the joints that follow it alone, by coordinate [rad or m].
    """

    def __init__(self, tree: Tree, plan: ClosurePlan, k: int) -> None:
        self._tree = tree
        self._k = k
        self._reference = [float(q) for q in plan.reference.q]
        self._plan = plan
        self._solved = _blocks_behind(plan, k)
        moved = {k}
        for block, _ in self._solved:
            moved.update(block.unknowns)
        # joints that do not move stay at the reference
        self._still: dict[int, Scalar] = {}
        for coordinate, value in enumerate(self._reference):
            if coordinate not in moved:
                self._still[coordinate] = value
        self.limits: dict[int, Range] = {}
        for block, _ in self._solved:
            # limits of a joint that follows by a coupling are exact without a search
            if isinstance(block, JointCouplingBlock) and block.inputs == [k]:
                continue
            self.limits |= self._limits_of(block.unknowns)

    def _limits_of(self, coordinates: Sequence[int]) -> dict[int, Range]:
        """Limits of some coordinates, widened to the reference where it passes them by rounding."""
        limits: dict[int, Range] = {}
        for body in self._tree.bodies:
            if body.coordinate not in coordinates or body.limits == EVERYWHERE:
                continue
            value = self._reference[body.coordinate]
            lower, upper = body.limits
            if lower - CLOSED <= value <= upper + CLOSED:
                limits[body.coordinate] = (min(lower, value), max(upper, value))
        return limits

    def end(self, way: int) -> float:
        """The value [rad or m] at which the first limit is met, in one direction (-1 or +1)."""
        good, s = self._reference[self._k], self._reference
        bad = good + way * searched_half(self._tree, self._plan, self._k)
        points = np.linspace(good, bad, _SAMPLES + 1)[1:]
        closes, obeys, followed = self._follow(points, s)
        is_limit = False
        for _ in range(_ROUNDS):
            stopped = np.flatnonzero(~(closes & obeys))
            if not len(stopped):
                return way * math.inf
            first = int(stopped[0])
            is_limit = bool(closes[first])
            bad = float(points[first])
            if first:
                good = float(points[first - 1])
                s = followed[first - 1].tolist()
            points = np.linspace(good, bad, _PARTS + 1)[1:]
            closes, obeys, followed = self._follow(points, s)
        return good if is_limit else way * math.inf

    def _follow(self, values: Array, start: Sequence[float]) -> tuple[Flags, Flags, Array]:
        """Follow the motion from a configuration.

        Args:
            values: values of the coordinate, one after the other (N,) [rad or m].
            start: all coordinates (n_s,) just before the first [rad or m].

        Returns:
            Whether the loops close (N,), whether all limits are obeyed (N,), and all coordinates
            (N, n_s) [rad or m].
        """
        configuration = given_configuration(self._tree, self._still | {self._k: values})
        closes = np.ones(values.shape, dtype=bool)
        with np.errstate(all="ignore"):
            for block, sign in self._solved:
                margin = block.solve(configuration, sign, self._reference)
                closes &= np.asarray(margin) > 0.0
                self._count_turns(configuration, block, start)
        followed = np.empty((len(values), len(start)))
        for coordinate, q in enumerate(configuration.q):
            followed[:, coordinate] = q
        obeys = np.ones(values.shape, dtype=bool)
        for coordinate, (lower, upper) in self.limits.items():
            obeys &= (lower <= followed[:, coordinate]) & (followed[:, coordinate] <= upper)
        return closes, obeys, followed

    def _count_turns(
        self, configuration: Configuration, block: BlockSolver, start: Sequence[float]
    ) -> None:
        """Add whole turns to the angles of a block, so that none of them jumps."""
        for unknown in block.unknowns:
            if self._tree.is_revolute(unknown):
                angles = np.append(start[unknown], configuration.q[unknown])
                configuration.q[unknown] = np.unwrap(angles)[1:]


def _blocks_behind(plan: ClosurePlan, k: int) -> list[tuple[BlockSolver, float]]:
    """Blocks that depend on one given coordinate alone and do not iterate, with their signs."""
    solved: list[tuple[BlockSolver, float]] = []
    unknown: set[int] = set()  # results of iterations
    for block, sign in zip(plan.blocks, plan.branch, strict=True):
        if given_inputs(plan, block) != [k]:
            continue
        if block.iterates or unknown.intersection(block.inputs):
            unknown.update(block.unknowns)
            continue
        solved.append((block, float(sign)))
    return solved
