"""The range of a given coordinate between the toggle points, where the loops close."""

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
from .closed_motion import SolvedBlock
from .constraints.equations import loops_of
from .plan import ClosurePlan

Flags = NDArray[np.bool_]
Range = tuple[float, float]
# distance below which a configuration is singular: a toggle point, up to rounding
SINGULAR = 1e-8
# samples are shifted by this share of a step, so that none falls on a change point
_OFF_GRID = 0.1234567
_SAMPLES = 4001  # a range narrower than 1/4000 of the searched one may be missed
_TURN = 2.0 * math.pi  # [rad] searched to either side
_SPAN = 6.0  # searched displacements to either side, in lengths of the longest loop
_PARTS = 32  # pieces into which an interval around an end is divided
_ROUNDS = 11  # divisions until an end is exact to rounding


def given_inputs(plan: ClosurePlan, block: BlockSolver) -> list[int]:
    """The given coordinates that a block depends on, directly or through passive ones, in order."""
    solver_of: dict[int, BlockSolver] = {}
    for solver in plan.blocks:
        for unknown in solver.unknowns:
            solver_of[unknown] = solver
    reached: set[int] = set()
    waiting = list(block.inputs)
    while waiting:
        k = waiting.pop()
        if k in reached:
            continue
        reached.add(k)
        if k in solver_of:
            waiting += solver_of[k].inputs
    return [k for k in plan.given if k in reached]


def searched_half(tree: Tree, plan: ClosurePlan, k: int) -> float:
    """Half the width of the searched range of a coordinate [rad or m]."""
    if tree.is_revolute(k):
        return _TURN
    return _SPAN * max(loop.reach(plan.reference) for loop in plan.loops)


class ClosingSearch:
    """The values of one given coordinate at which the loops close, with the others constant.

    Args:
        tree: the spanning tree.
        plan: closure plan.
        u: given coordinates (n,) [rad, m].
        signs: branch signs (blocks,).
        k: the given coordinate that moves.
        blocks: the blocks to close, with those that they depend on; None for all.
    """

    def __init__(
        self,
        tree: Tree,
        plan: ClosurePlan,
        u: Sequence[float],
        signs: Sequence[float],
        k: int,
        blocks: Sequence[BlockSolver] | None = None,
    ) -> None:
        self._tree = tree
        self._plan = plan
        self._given: dict[int, Scalar] = {}
        for coordinate, value in zip(plan.given, u, strict=True):
            self._given[coordinate] = float(value)
        self._k = k
        self._solved: list[tuple[BlockSolver, float]] = []
        of_blocks, self._charts = plan.split(signs)
        for block, sign in zip(plan.blocks, of_blocks, strict=True):
            is_needed = blocks is None or block in blocks or not given_inputs(plan, block)
            if is_needed:
                self._solved.append((block, float(sign)))
        # frames that are turned by half a turn: checked once all coordinates are solved
        self._guarded = plan.loops if blocks is None else ()
        self._guess = [float(q) for q in plan.reference.q]

    def closes(self, values: Array) -> Flags:
        """Whether the loops close (N,) at values (N,) of the coordinate [rad or m]."""
        given = self._given | {self._k: values}
        configuration = given_configuration(self._tree, given, self._charts)
        good = np.ones(values.shape, dtype=bool)
        with np.errstate(all="ignore"):
            for block, sign in self._solved:
                margin = block.solve(configuration, sign, self._guess)
                good &= np.asarray(margin) > 0.0
                good &= np.asarray(self._distance(block, margin, configuration)) > SINGULAR
            for loop in self._guarded:
                for guard in loop.guards(configuration):
                    good &= np.asarray(guard) > 0.0
        return good

    def _distance(self, block: BlockSolver, margin: Scalar, configuration: Configuration) -> Scalar:
        """Distance of a solved block to a singularity, since a range may end at one."""
        linear = {loop: loop.linearise(configuration) for loop in loops_of(block.equations)}
        rows = [linear[equation.loop].rows[equation.index] for equation in block.equations]
        return SolvedBlock(block, margin, rows).distance(self._tree)

    def interval(self, near: float) -> Range | None:
        """The interval in which the loops close.

        Args:
            near: a value [rad or m]; of several intervals the nearest to it is taken.

        Returns:
            Lower and upper end [rad or m], infinite if the search met none. None if the loops close
            nowhere.
        """
        half = searched_half(self._tree, self._plan, self._k)
        step = 2.0 * half / (_SAMPLES - 1)
        values = near + half * np.linspace(-1.0, 1.0, _SAMPLES) + _OFF_GRID * step
        closes = self.closes(values)
        if not closes.any():
            return None
        distances = np.where(closes, np.abs(values - near), np.inf)
        inside = int(np.argmin(distances))
        return self._end(values, closes, inside, -1), self._end(values, closes, inside, 1)

    def _end(self, values: Array, closes: Flags, inside: int, way: int) -> float:
        """The end of the interval around a value inside, in one direction (-1 or +1)."""
        k = inside
        while 0 <= k + way < len(values) and closes[k + way]:
            k += way
        if not 0 <= k + way < len(values):
            return way * math.inf
        good, bad = float(values[k]), float(values[k + way])
        for _ in range(_ROUNDS):
            points = np.linspace(good, bad, _PARTS + 1)
            opened = np.flatnonzero(~self.closes(points[1:-1]))
            last = int(opened[0]) if len(opened) else _PARTS - 1
            good, bad = float(points[last]), float(points[last + 1])
        return good


def closing_interval(
    tree: Tree, plan: ClosurePlan, u: Sequence[float], signs: Sequence[float], k: int
) -> Range | None:
    """The interval of a given coordinate in which the mechanism closes, with the others constant.

    Of several intervals it is the one nearest to the reference.

    Args:
        tree: the spanning tree.
        plan: closure plan.
        u: given coordinates (n,) [rad, m]; that of k does not matter.
        signs: branch signs (blocks,).
        k: the given coordinate.

    Returns:
        Lower and upper end [rad or m], infinite if there is none. None if the loops close nowhere,
        or if a block iterates.
    """
    for block in plan.blocks:
        if block.iterates and k in given_inputs(plan, block):
            return None
    search = ClosingSearch(tree, plan, u, signs, k)
    return search.interval(float(plan.reference.q[k]))


def independent_range(tree: Tree, plan: ClosurePlan, k: int) -> Range:
    """The range of a given coordinate that does not depend on the other ones.

    Only loops that depend on no other given coordinate count. An end is finite only if the whole
    mechanism closes just inside it, with the other coordinates at the reference.

    Args:
        tree: the spanning tree.
        plan: closure plan with its own assembly modes.
        k: the given coordinate.

    Returns:
        Lower and upper end [rad or m].
    """
    everywhere = (-math.inf, math.inf)
    blocks: list[BlockSolver] = []
    for block in plan.blocks:
        inputs = given_inputs(plan, block)
        if k in inputs and block.iterates:
            return everywhere
        if inputs == [k]:
            blocks.append(block)
    if not blocks:
        return everywhere
    reference = [float(plan.reference.q[coordinate]) for coordinate in plan.given]
    near = float(plan.reference.q[k])
    allowed = ClosingSearch(tree, plan, reference, plan.signs, k, blocks).interval(near)
    if allowed is None:
        return everywhere
    complete = ClosingSearch(tree, plan, reference, plan.signs, k)
    lower, upper = allowed
    if math.isfinite(lower) and not complete.closes(np.array([lower]))[0]:
        lower = -math.inf
    if math.isfinite(upper) and not complete.closes(np.array([upper]))[0]:
        upper = math.inf
    return lower, upper
