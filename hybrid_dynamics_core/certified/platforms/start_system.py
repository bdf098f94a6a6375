"""A generic complex platform with its forty solutions, where all homotopies begin.

One solution is chosen, and legs of random complex geometry that fit it. Going round closed paths in
the space of geometries permutes the solutions and reaches the others (monodromy). Nothing has to
be trusted here: what is proved later is proved of the ends.
"""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from .paths import PathTracker
from .study import Complex, Legs, quadrics

# most poses of platforms on six legs: Ronga and Vust 1992, Lazard 1992, Mourrain 1993
MOST_POSES = 40
# if three tips take two legs each: three equations that are quadratic in each of two of three
# angles' tangents, 2 * 2 * 2 + 2 * 2 * 2 by Bezout's theorem for products of lines
MOST_POSES_OF_PAIRS = 16
MOST_LOOPS = 60
SAME = 1e-8  # unit vectors with a product this near to 1 are the same point
_SIZE = 0.5  # of random numbers


class StartSystem(NamedTuple):
    """A geometry and its solutions.

    Attributes:
        legs: the legs, complex.
        points: solutions (40, 8) in Study's coordinates.
    """

    legs: Legs
    points: Complex


@cache
def start_system(number: int, in_pairs: bool = False) -> StartSystem:
    """One of several start systems; always the same for a number.

    The first is computed by monodromy, the others by a homotopy from it.

    Args:
        number: which one.
        in_pairs: whether three tips take two legs each, legs 0 and 1, 2 and 3, 4 and 5.
    """
    random = np.random.default_rng(number)
    most = most_poses(in_pairs)
    if number:
        first = start_system(0, in_pairs)
        legs = _random_legs(random, in_pairs)
        tracker = PathTracker.between(first.legs, legs, closeness=1e-7)
        ends = tracker.ends(first.points)
        return StartSystem(legs, ends.points[ends.arrived])
    legs, point = _legs_through_a_pose(random, in_pairs)
    points = point[None]
    for _ in range(MOST_LOOPS):
        points = _with_others(points, _around(legs, points, random, in_pairs))
        if len(points) >= most:
            break
    return StartSystem(legs, points)


def most_poses(in_pairs: bool) -> int:
    """The largest number of complex poses of a platform on six legs, if it is finite."""
    if in_pairs:
        return MOST_POSES_OF_PAIRS
    return MOST_POSES


def distinct(points: Complex) -> Complex:
    """The points (n, 8) without those that are equal to an earlier one."""
    return _with_others(points[:1], points[1:])


def _with_others(points: Complex, others: Complex) -> Complex:
    """The points (n, 8) and those of others that are new."""
    result = list(points)
    for other in others:
        nearness = np.abs(np.conj(result) @ other)
        if nearness.max(initial=0.0) < 1.0 - SAME:
            result.append(other)
    return np.array(result)


def _around(
    legs: Legs,
    points: Complex,
    random: np.random.Generator,
    in_pairs: bool,
) -> Complex:
    """The points after a closed way through two random geometries."""
    first, second = _random_legs(random, in_pairs), _random_legs(random, in_pairs)
    corners = [legs, first, second, legs]
    for start, target in pairwise(corners):
        ends = PathTracker.between(start, target).ends(points)
        points = ends.points[ends.arrived]
    return points


def _legs_through_a_pose(
    random: np.random.Generator,
    in_pairs: bool,
) -> tuple[Legs, Complex]:
    """Random legs, and a pose (8,) at which they close."""
    e = _numbers(random, 4)
    g = _numbers(random, 4)
    g = g - e * (g @ e) / (e @ e)
    point = np.concatenate([e, g])
    legs = _random_legs(random, in_pairs)
    legs = legs._replace(squares=np.zeros(6, dtype=complex))
    values = np.einsum("i,kij,j->k", point, quadrics(legs), point)
    fitting = legs._replace(squares=values[:6] / (e @ e))
    return fitting, point / np.linalg.norm(point)


def _random_legs(random: np.random.Generator, in_pairs: bool) -> Legs:
    feet = _numbers(random, 6, 3)
    tips = _numbers(random, 6, 3)
    if in_pairs:
        tips = np.repeat(tips[:3], 2, axis=0)
    return Legs(feet, tips, 2.0 * _numbers(random, 6))


def _numbers(
    random: np.random.Generator,
    *shape: int,
) -> Complex:
    real = random.normal(size=shape)
    imaginary = random.normal(size=shape)
    return np.asarray(
        _SIZE * (real + 1j * imaginary),
        dtype=complex,
    )
