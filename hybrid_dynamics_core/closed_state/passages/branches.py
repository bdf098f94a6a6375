"""The velocities with which a motion can leave a change point.

There J_z has a null space K, and a left null space L. Rates s' + K a have the same given rates for
every a. They belong to a motion if the second derivative of the equations vanishes along L too:
L^T J_s'(s') s' = 0, one quadratic for each direction of L. a = 0 is the motion that arrives, the
other roots are those that branch off.

Blocks are solved one after the other. So K and L have bases in which each quadratic has only one
more unknown than the one before it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ...closure.constraints.equations import loops_of
from ...ground.arrays import Array
from ...mechanism.configuration import configuration_at
from ...programs import Model

NULL = 1e-6  # singular values below this share of the largest one are zero
SAME = 1e-6  # change of rates, relative to their size, below which two motions are the same
ROUNDING = 1e-11  # share of the coefficients' squares below which a discriminant is zero
STRAIGHT = 1e-9  # ratio of the coefficients below which a quadratic is linear
TINY = 1e-12


def other_rates(
    model: Model,
    charts: Array,
    s: Array,
    rates: Array,
) -> dict[int, Array]:
    """Rates of the motions that branch off at a change point.

    Args:
        model: tree and closure plan.
        charts: charts of ball and free joints.
        s: all coordinates (n_s,) at the place [rad, m].
        rates: rates (n_s,) of the motion that arrives, for some given rates.

    Returns:
        Rates (n_s,) by index of a block of the plan, which goes the other way. Those after it go on
        with the velocity nearest to theirs. The given rates are the same, or zero if the other
        motion holds the given coordinates at rest. Blocks without another motion are left out, and
        so are those with more than one singular direction.
    """
    place = _Place(
        model,
        charts,
        s,
    )
    branches: dict[int, Array] = {}
    for block in place.singular:
        other = place.turned_off(block, rates)
        if other is not None:
            branches[block] = other
    return branches


@dataclass(frozen=True, eq=False)
class _Quadratic:
    """a t^2 + b t + c = 0."""

    a: float
    b: float
    c: float

    @property
    def is_linear(self) -> bool:
        """Whether a is zero to rounding."""
        return abs(self.a) <= STRAIGHT * abs(self.b)

    def nearest(self) -> float | None:
        """Its real root nearest to zero; None if there is none."""
        if self.is_linear:
            return -self.c / self.b if self.b else 0.0
        return min(
            self._roots(),
            key=abs,
            default=None,
        )

    def farthest(self) -> float | None:
        """Its real root farthest from zero; None if there is none."""
        return max(
            self._roots(),
            key=abs,
            default=None,
        )

    def _roots(self) -> list[float]:
        """The real roots; two that only rounding sets apart are one."""
        squares = self.b**2, 4.0 * self.a * self.c
        inside = squares[0] - squares[1]
        if abs(inside) < ROUNDING * (self.a**2 + squares[0]):
            inside = 0.0
        if inside < 0.0:
            return []
        root = math.sqrt(inside)
        ends = (-self.b + root, -self.b - root)
        return [end / (2.0 * self.a) for end in ends]


class _Place:
    """The equations of all blocks at a change point.

    Attributes:
        singular: indices of the blocks with one singular direction.
    """

    def __init__(
        self,
        model: Model,
        charts: Array,
        s: Array,
    ) -> None:
        self._configuration = configuration_at(
            model.tree,
            s,
            charts,
        )
        self._equations = []
        unknowns: list[int] = []
        for block in model.plan.blocks:
            self._equations += list(block.equations)
            unknowns += list(block.unknowns)
        self._loops = loops_of(self._equations)
        left, sizes, right = np.linalg.svd(self._jacobian(len(s))[:, unknowns])
        rank = int((sizes > NULL * sizes.max(initial=0.0)).sum())
        null = np.zeros((len(s), len(unknowns) - rank))
        null[unknowns] = right[rank:].T
        blocks = model.plan.blocks
        columns = [list(block.unknowns) for block in blocks]
        rows = _ranges([len(block.equations) for block in blocks])
        staircase = _staircase(null, enumerate(columns))
        parts = list(enumerate(rows))
        self._combinations = _staircase(left[:, rank:], parts[::-1])
        self._directions = {
            k: vectors[:, 0] for k, vectors in staircase.items() if vectors.shape[1] == 1
        }
        self.singular = sorted(self._directions.keys() & self._combinations.keys())

    def _jacobian(self, size: int) -> Array:
        """J_s of the equations of all blocks, (equations, n_s)."""
        rows = {loop: loop.linearise(self._configuration).rows for loop in self._loops}
        jacobian = np.zeros((len(self._equations), size))
        for index, equation in enumerate(self._equations):
            for k, value in rows[equation.loop][equation.index].items():
                jacobian[index, k] = value
        return jacobian

    def _curvature(
        self,
        block: int,
        rates: Array,
    ) -> Array:
        """The quadratics of a block at given rates; more than one if equations are redundant."""
        terms = {loop: loop.bias(self._configuration, rates.tolist()) for loop in self._loops}
        values = [float(terms[equation.loop][equation.index]) for equation in self._equations]
        return np.asarray(np.array(values) @ self._combinations[block])

    def turned_off(
        self,
        block: int,
        rates: Array,
    ) -> Array | None:
        """Rates of the motion in which a block goes the other way; None if there is none."""
        size = max(float(np.abs(rates).max()), TINY)
        changes = {k: size * self._directions[k] for k in self.singular}
        quadratic = self._along(
            block,
            rates,
            changes[block],
        )
        if quadratic.is_linear:
            # its other root is infinite: the given coordinates are at rest
            result = changes[block]
        else:
            share = quadratic.farthest()
            if share is None:
                return None
            result = rates + share * changes[block]
        for later in self.singular:
            if later <= block:
                continue
            share = self._along(
                later,
                result,
                changes[later],
            ).nearest()
            if share is None:
                return None
            result = result + share * changes[later]
        if np.abs(result - rates).max() <= SAME * size:
            return None
        return result

    def _along(
        self,
        block: int,
        rates: Array,
        direction: Array,
    ) -> _Quadratic:
        """The quadratic of a block along a direction; exact by differences, being quadratic."""
        middle = self._curvature(block, rates)
        ahead = self._curvature(block, rates + direction)
        behind = self._curvature(block, rates - direction)
        square = 0.5 * (ahead + behind) - middle
        slope = 0.5 * (ahead - behind)
        # redundant equations agree: the one that feels the direction most is taken
        most = int(np.argmax(np.abs(square) + np.abs(slope)))
        return _Quadratic(
            float(square[most]),
            float(slope[most]),
            float(middle[most]),
        )


def _ranges(counts: Sequence[int]) -> list[list[int]]:
    """Indices of consecutive parts with some lengths."""
    ranges = []
    begin = 0
    for count in counts:
        ranges.append(list(range(begin, begin + count)))
        begin += count
    return ranges


def _staircase(null: Array, parts: Iterable[tuple[int, Sequence[int]]]) -> dict[int, Array]:
    """Vectors of a null space by part, as columns: each is zero in the parts before its own.

    Args:
        null: orthonormal basis of the null space, (size, r).
        parts: name of each part and its rows.
    """
    vectors: dict[int, Array] = {}
    for name, rows in parts:
        if not null.shape[1]:
            break
        _, sizes, right = np.linalg.svd(null[rows])
        rank = int((sizes > NULL).sum())
        if rank:
            vectors[name] = null @ right[:rank].T
        null = null @ right[rank:].T
    return vectors
