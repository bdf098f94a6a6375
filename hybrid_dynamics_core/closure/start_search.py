"""Search for a closed configuration near a drawn pose: locally, then globally, then refined.

The starts are the same in every run. All loops are closed from each start.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..ground.arrays import Array
from ..mechanism.tree import Tree
from .constraints.equations import LoopEquations
from .many_starts import close_from_starts
from .numeric_closure import CLOSED, close_numerically, gaps_and_jacobian

# (distance from the drawn pose [rad or m], number of starts) of the local search
DISTANCES = (0.03, 0.1, 0.3, 1.0)
STARTS = 6
WIDE_STARTS = 120  # starts of the global search, if none of the local ones closes
WIDE_PARTS = 4  # of these starts; the search ends after the first with a closed start
WIDE = np.pi  # [rad, or lengths of the longest loop] their largest distance from the drawn pose
NEAR = 0.5  # [rad or m] distance of the drives from the drawn pose that is accepted
FAR = 2.0  # [rad or m] distance of all coordinates above which refinement is tried
BEYOND = 1e3  # penalty of a configuration that closes beyond limits
MOST_PULLS = 40  # steps of the refinement towards the drawn pose
PULL = 0.3  # [rad or m] longest step
SHORTEST_PULL = 0.02  # [rad or m]
GAIN = 0.01  # [rad or m] least gain of a step
STILL_REGULAR = 0.3  # least singular value along the refinement, relative to its start
RANK_TOLERANCE = 1e-8  # singular values below this share of the largest count as zero
TINY = 1e-300


def limits_of(tree: Tree) -> Array:
    """Lower and upper limits (n_s, 2) in the order of the coordinates [rad or m]."""
    bodies = sorted(tree.bodies, key=lambda body: body.coordinate)
    return np.reshape([body.limits for body in bodies], (-1, 2)).astype(float)


@dataclass(frozen=True)
class _Place:
    """A configuration that is closed, or has the least gap.

    Attributes:
        s: all coordinates (n_s,) [rad or m].
        merit: penalty, 0 at best.
        distance: distance of the coordinates in loops from the drawn pose [rad or m].
    """

    s: Array
    merit: float
    distance: float

    @property
    def order(self) -> tuple[float, float]:
        """Sort key, least first: by the drives; if they are near enough, by all coordinates."""
        return max(self.merit, NEAR), self.distance


class StartSearch:
    """Search for one group of loops, which shares no coordinate with the others."""

    def __init__(
        self, tree: Tree, loops: Sequence[LoopEquations], drawn: Array, passive: Sequence[int]
    ) -> None:
        """Prepare the search.

        Args:
            tree: the spanning tree.
            loops: the equations of the group.
            drawn: the drawn pose (n_s,) [rad or m].
            passive: coordinates that are varied first.
        """
        self.tree = tree
        self.loops = loops
        self.drawn = drawn
        self.held = sorted({k for loop in loops for k in loop.coordinates})
        self.passive = [k for k in self.held if k in passive]
        self.driven = [k for k in self.held if k not in passive]
        self.lower, self.upper = limits_of(tree).T

    def nearest(self, driven_may_move: bool) -> Array:
        """The best configuration (n_s,) [rad or m]; the one with the least gap if none closes.

        Args:
            driven_may_move: whether to vary driven coordinates too.
        """
        unknowns = self.passive
        best = self._closed(self.drawn, unknowns)
        if best.order <= (NEAR, FAR):
            return best.s
        for unknowns in self._movable(driven_may_move):
            best = self._better(best, self._near_starts(unknowns), unknowns)
            if best.merit < BEYOND:
                break
        wide = iter(self._wide_starts(unknowns))
        while best.merit >= BEYOND and (starts := next(wide, None)) is not None:
            best = self._better(best, starts, unknowns)
        if NEAR < best.merit < BEYOND:
            best = self._pulled(best, unknowns)
        return best.s

    def _movable(self, driven_may_move: bool) -> Iterator[list[int]]:
        """Sets of varied coordinates: the passive ones, then more and more of the last driven ones.

        Redundant motors are always varied.
        """
        yield self.passive
        if not driven_may_move:
            return
        giving = 1
        while giving < 2 * len(self.driven):
            fixed = self.driven[: max(len(self.driven) - giving, 0)]
            yield [k for k in self.held if k not in fixed]
            giving *= 2

    def _closed(self, start: Array, unknowns: Sequence[int]) -> _Place:
        s, gaps = close_numerically(self.tree, self.loops, start, unknowns)
        return self._places(s[None], np.array([max(gaps.values(), default=0.0)]))[0]

    def _places(self, s: Array, gaps: Array) -> list[_Place]:
        """The places of configurations (B, n_s) with gaps (B,)."""
        merits = self._merits(s, gaps)
        distances = np.linalg.norm((s - self.drawn)[:, self.held], axis=-1)
        return [_Place(*place) for place in zip(s, merits, distances, strict=True)]

    def _better(self, best: _Place, starts: Array, unknowns: Sequence[int]) -> _Place:
        """The best place from these starts (B, n_s), or the previous best."""
        ends, gaps = close_from_starts(self.tree, self.loops, starts, unknowns)
        place = min(self._places(ends, gaps), key=lambda place: place.order)
        if place.order >= best.order:
            return best
        return self._closed(place.s, unknowns)

    def _merits(self, s: Array, gaps: Array) -> Array:
        """Penalties (B,) of configurations (B, n_s) with gaps (B,), 0 at best.

        Within the limits, the penalty is the distance of the driven coordinates from the drawn
        pose. It is larger beyond limits, and grows with the gap of open loops.
        """
        held = self.held
        below = self.lower[held] - s[:, held]
        above = s[:, held] - self.upper[held]
        beyond = np.maximum(below, above).max(axis=-1, initial=0.0)
        moves = np.abs(s - self.drawn)[:, self.driven].max(axis=-1, initial=0.0)
        merits = np.where(beyond > CLOSED, BEYOND + beyond, np.minimum(moves, 0.5 * BEYOND))
        return np.where(gaps > CLOSED, 2.0 * BEYOND + gaps, merits)

    def _near_starts(self, unknowns: Sequence[int]) -> Array:
        """Starts (B, n_s) around the drawn pose, and one in the middle of the limits."""
        rng = np.random.default_rng(0)
        starts = [self.drawn]
        for size in DISTANCES:
            for _ in range(STARTS):
                moved = self.drawn.copy()
                moved[unknowns] += rng.uniform(-size, size, len(unknowns))
                starts.append(moved)
        middle = self.drawn.copy()
        is_bounded = np.isfinite(self.lower) & np.isfinite(self.upper)
        bounded = [k for k in unknowns if is_bounded[k]]
        middle[bounded] = 0.5 * (self.lower[bounded] + self.upper[bounded])
        starts.append(middle)
        return np.clip(starts, self.lower, self.upper)

    def _wide_starts(self, unknowns: Sequence[int]) -> list[Array]:
        """Starts (B, n_s) over the whole range of the limits or of the loops, in parts."""
        columns = list(unknowns)
        reach = np.full(len(self.drawn), WIDE)
        longest = max((loop.length for loop in self.loops if loop.has_length), default=1.0)
        for body in self.tree.bodies:
            if not body.is_revolute:
                reach[body.coordinate] = longest
        lower = np.maximum(self.lower, self.drawn - reach)
        upper = np.minimum(self.upper, self.drawn + reach)
        starts = np.tile(self.drawn, (WIDE_STARTS, 1))
        shares = np.random.default_rng(1).uniform(0.0, 1.0, (WIDE_STARTS, len(columns)))
        starts[:, columns] = lower[columns] + shares * (upper - lower)[columns]
        return np.split(starts, WIDE_PARTS)

    def _pulled(self, place: _Place, unknowns: Sequence[int]) -> _Place:
        """The nearest place on a path of regular closed configurations towards the drawn pose."""
        size = PULL
        least = STILL_REGULAR * self._regularity(place.s)
        for _ in range(MOST_PULLS):
            step = self._step_to_drawn(place.s, unknowns)
            longest = float(np.abs(step).max(initial=0.0))
            if longest < SHORTEST_PULL:
                return place
            moved = place.s + step * min(1.0, size / longest)
            other = self._closed(moved, unknowns)
            if other.merit < place.merit - GAIN and self._regularity(other.s) >= least:
                place = other
            else:
                size *= 0.5
            if size < SHORTEST_PULL:
                break
        return place

    def _step_to_drawn(self, s: Array, unknowns: Sequence[int]) -> Array:
        """The step (n_s,) of closed loops that brings driven coordinates nearest to the drawn pose.

        To first order.
        """
        columns = list(unknowns)
        _, jacobian = gaps_and_jacobian(self.tree, self.loops, s, columns)
        _, sizes, vectors = np.linalg.svd(jacobian)
        least = RANK_TOLERANCE * max(float(sizes.max(initial=0.0)), TINY)
        motions = vectors[np.count_nonzero(sizes > least) :].T
        rows = [row for row, k in enumerate(columns) if k in self.driven]
        wanted = (self.drawn - s)[columns][rows]
        shares = np.linalg.lstsq(motions[rows], wanted, rcond=RANK_TOLERANCE)[0]
        step = np.zeros(len(s))
        step[columns] = motions @ shares
        return step

    def _regularity(self, s: Array) -> float:
        """Least over largest singular value of J_z; 0 if passive rates are not determined."""
        _, jacobian = gaps_and_jacobian(self.tree, self.loops, s, self.passive)
        if not self.passive or len(jacobian) < len(self.passive):
            return 0.0
        sizes = np.linalg.svd(jacobian, compute_uv=False)
        return float(sizes[len(self.passive) - 1] / max(float(sizes[0]), TINY))
