"""A closed, regular configuration near the drawn pose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..ground.arrays import Array
from ..mechanism.tree import Tree
from .constraints.equations import LoopEquations
from .numeric_closure import CLOSED, close_numerically, gaps_and_jacobian, largest_gaps
from .start_search import StartSearch, limits_of

MOVES = (0.03, -0.03, 0.1, -0.1, 0.3)  # [rad or m] off a singular place
REGULAR = 1e-3  # share of a singular value nearby below which a place counts as singular
RANK_TOLERANCE = 1e-8  # singular values below this share of the largest count as zero
SUSPECT = 1e-6  # smallest singular value of J_z over the largest that calls for a search
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

    The least open one where none closes. Loops without a coordinate in common are searched one
    after the other: about the drawn pose first, then far and wide.

    Args:
        tree: the spanning tree.
        loops: all equations.
        start: the drawn pose (n_s,) [rad or m].
        passive: coordinates that may change first.
        driven_may_move: whether the driven ones may change if these are not enough.
    """
    drawn = np.asarray(start, dtype=float)
    if _gaps(tree, loops, drawn) <= CLOSED:
        return Closed(*close_numerically(tree, loops, start, passive))
    # all that no loop holds stays where the drawing has it, but for its limits
    s = np.clip(drawn, *limits_of(tree).T)
    for group in _groups(loops):
        held = _coordinates_of(group)
        s[held] = drawn[held]
        s[held] = StartSearch(tree, group, s, passive).nearest(driven_may_move)[held]
    return Closed(s, largest_gaps(tree, loops, s))


def _coordinates_of(loops: Sequence[LoopEquations]) -> list[int]:
    """Coordinates that some loops hold."""
    return sorted({k for loop in loops for k in loop.coordinates})


def _groups(loops: Sequence[LoopEquations]) -> list[list[LoopEquations]]:
    """Loops that share coordinates, directly or through others."""
    groups: list[list[LoopEquations]] = []
    for loop in loops:
        apart: list[list[LoopEquations]] = []
        together = [loop]
        for group in groups:
            if set(_coordinates_of(group)).isdisjoint(loop.coordinates):
                apart.append(group)
            else:
                together = [*group, *together]
        groups = [*apart, together]
    return groups


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
    if not loops:
        return s
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


def may_be_singular(
    tree: Tree, loops: Sequence[LoopEquations], s: Array, passive: Sequence[int]
) -> bool:
    """Whether J_z is singular at s up to rounding, by one decomposition."""
    return bool(loops) and _smallest(tree, loops, s, passive) < SUSPECT


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
