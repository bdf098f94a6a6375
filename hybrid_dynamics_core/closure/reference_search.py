"""A closed, regular configuration near the drawn pose."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..ground.arrays import Array
from ..mechanism.tree import Tree
from .constraints.equations import LoopEquations
from .numeric_closure import CLOSED, close_numerically, gaps_and_jacobian

# [rad or m] distances of further starts from the drawn pose, and their number at each
DISTANCES = (0.03, 0.1, 0.3, 1.0)
STARTS = 6
NEAR = 0.5  # [rad or m] a configuration this near to the drawn pose is accepted at once
BEYOND = 1e3  # cost added to a configuration that closes beyond limits
MOVES = (0.03, -0.03, 0.1, -0.1, 0.3)  # [rad or m] moves away from a singularity
REGULAR = 1e-3  # least share of the smallest singular value nearby that counts as regular
RANK_TOLERANCE = 1e-8  # singular values below this share of the largest count as zero
TINY = 1e-300


class Closed(NamedTuple):
    """A configuration, and how it closes.

    Attributes:
        s: all coordinates (n_s,) [rad or m].
        gaps: largest gap of each loop by name, in lengths of the loop or [rad].
    """

    s: Array
    gaps: Mapping[str, float]

    @property
    def is_closed(self) -> bool:
        """Whether all loops close."""
        return max(self.gaps.values(), default=0.0) <= CLOSED


def closed_near(
    tree: Tree,
    loops: Sequence[LoopEquations],
    start: Sequence[float],
    passive: Sequence[int],
    *,
    driven_may_move: bool = True,
) -> Closed:
    """The closed configuration nearest to a drawn pose, within the limits if possible.

    If none closes, it is the one with the smallest gap.

    Args:
        tree: the spanning tree.
        loops: all equations.
        start: the drawn pose (n_s,) [rad or m].
        passive: coordinates that may change first.
        driven_may_move: whether the driven ones may change if these are not enough.
    """
    drawn = np.asarray(start, dtype=float)
    driven = [k for k in range(len(drawn)) if k not in passive]
    best = Closed(*close_numerically(tree, loops, start, passive))
    if _gaps(tree, loops, drawn) <= CLOSED:
        return best
    # coordinates outside of loops keep their drawn values; redundant motors must move
    held = sorted({k for loop in loops for k in loop.coordinates})
    for unknowns in _movable(held, passive, driven, driven_may_move):
        for other_start in _starts(tree, drawn, unknowns):
            if _merit(tree, best, drawn, driven) <= NEAR:
                return best
            other = Closed(*close_numerically(tree, loops, other_start, unknowns))
            best = min(best, other, key=lambda closed: _merit(tree, closed, drawn, driven))
        if _merit(tree, best, drawn, driven) < BEYOND:
            return best
    return best


def _movable(
    held: Sequence[int], passive: Sequence[int], driven: Sequence[int], driven_may_move: bool
) -> Iterator[list[int]]:
    """Sets of coordinates that may change: passive ones, then more and more of the last driven."""
    yield [k for k in held if k in passive]
    if not driven_may_move:
        return
    for count in range(len(driven) - 1, -1, -1):
        yield [k for k in held if k not in driven[:count]]


def is_closed_at(tree: Tree, loops: Sequence[LoopEquations], s: Sequence[float]) -> bool:
    """Whether all loops close at a pose (n_s,)."""
    return _gaps(tree, loops, np.asarray(s, dtype=float)) <= CLOSED


def generic_near(tree: Tree, loops: Sequence[LoopEquations], s: Array) -> Array:
    """A configuration near a closed one at which the equations have their generic rank.

    At a singularity, such as a change point, the rank is lower than near it.

    Args:
        tree: the spanning tree.
        loops: all equations.
        s: a closed configuration (n_s,) [rad or m].

    Returns:
        The configuration (n_s,) with the highest rank among some near s; s itself if none closes.
    """
    sizes, motion = _singular_values(tree, loops, s)
    most = -1
    best = s
    for move in MOVES:
        moved = _moved(tree, loops, s, move * motion)
        if moved is None:
            continue
        sizes, _ = _singular_values(tree, loops, moved)
        rank = int(np.count_nonzero(sizes > RANK_TOLERANCE))
        if rank > most:
            best, most = moved, rank
    return best


def is_singular_for(
    tree: Tree, loops: Sequence[LoopEquations], s: Array, generic: Array, passive: Sequence[int]
) -> bool:
    """Whether J_z is singular at s, but regular near it.

    Args:
        tree: the spanning tree.
        loops: all equations.
        s: a closed configuration (n_s,) [rad or m].
        generic: a closed configuration (n_s,) near s, of generic rank.
        passive: the coordinates that the loops are to determine.
    """
    here = _smallest(tree, loops, s, passive)
    return here < REGULAR * _smallest(tree, loops, generic, passive)


def _smallest(
    tree: Tree, loops: Sequence[LoopEquations], s: Array, passive: Sequence[int]
) -> float:
    """Smallest singular value of J_z over the largest; 0 if the rank is short."""
    _, jacobian = gaps_and_jacobian(tree, loops, s, passive)
    if not passive or len(jacobian) < len(passive):
        return 0.0
    sizes = np.linalg.svd(jacobian, compute_uv=False)
    return float(sizes[len(passive) - 1] / max(float(sizes[0]), TINY))


def _moved(tree: Tree, loops: Sequence[LoopEquations], s: Array, motion: Array) -> Array | None:
    """A closed configuration in the direction of a motion; None if none closes."""
    held = sorted({k for loop in loops for k in loop.coordinates})
    moved, gaps = close_numerically(tree, loops, s + motion, held)
    lower, upper = limits_of(tree).T
    is_within = bool(((moved >= lower - CLOSED) & (moved <= upper + CLOSED)).all())
    if max(gaps.values(), default=0.0) > CLOSED or not is_within:
        return None
    return moved


def _singular_values(tree: Tree, loops: Sequence[LoopEquations], s: Array) -> tuple[Array, Array]:
    """Singular values of J_s over the largest, and one motion (n_s,) that keeps all loops closed.

    The motion combines all null-space motions, with a largest entry of 1.
    """
    _, jacobian = gaps_and_jacobian(tree, loops, s, range(len(s)))
    if not len(jacobian):
        return np.zeros(0), np.ones(len(s))
    _, sizes, vectors = np.linalg.svd(jacobian)
    sizes = sizes / max(float(sizes[0]), TINY)
    rank = np.count_nonzero(sizes > RANK_TOLERANCE)
    free = vectors[rank:]
    weights = np.linspace(1.0, 0.6, len(free))
    motion = weights @ free
    return sizes, motion / max(float(np.abs(motion).max(initial=0.0)), TINY)


def _gaps(tree: Tree, loops: Sequence[LoopEquations], s: Array) -> float:
    """The largest gap at s; infinite where frames are half a turn apart."""
    try:
        gaps, _ = gaps_and_jacobian(tree, loops, s, ())
    except ZeroDivisionError:
        return float(np.inf)
    return float(np.abs(gaps).max(initial=0.0))


def _merit(tree: Tree, closed: Closed, drawn: Array, driven: Sequence[int]) -> float:
    """Cost of a configuration, 0 at best.

    Within the limits it is the distance of the driven coordinates from the drawn pose. Any
    configuration beyond limits costs more, and open loops cost most.
    """
    worst = max(closed.gaps.values(), default=0.0)
    if worst > CLOSED:
        return 2.0 * BEYOND + worst
    lower, upper = limits_of(tree).T
    beyond = float(np.maximum(lower - closed.s, closed.s - upper).max(initial=0.0))
    if beyond > CLOSED:
        return BEYOND + beyond
    moves = np.abs(closed.s - drawn)[list(driven)]
    return min(float(moves.max(initial=0.0)), 0.5 * BEYOND)


def limits_of(tree: Tree) -> Array:
    """Lower and upper limits (n_s, 2) in the order of the coordinates [rad or m]."""
    bodies = sorted(tree.bodies, key=lambda body: body.coordinate)
    return np.reshape([body.limits for body in bodies], (-1, 2)).astype(float)


def _starts(tree: Tree, drawn: Array, held: Sequence[int]) -> Iterator[Array]:
    """Start configurations around the drawn pose, then one in the middle of the limits.

    Only coordinates in loops are moved, and only within their limits. The starts are the same in
    every run.
    """
    lower, upper = limits_of(tree).T
    yield np.clip(drawn, lower, upper)
    rng = np.random.default_rng(0)
    for size in DISTANCES:
        for _ in range(STARTS):
            moved = drawn.copy()
            moved[held] += rng.uniform(-size, size, len(held))
            yield np.clip(moved, lower, upper)
    middle = drawn.copy()
    bounded = [k for k in held if np.isfinite(lower[k]) and np.isfinite(upper[k])]
    middle[bounded] = 0.5 * (lower[bounded] + upper[bounded])
    yield middle
