"""All poses of a platform on six legs of given lengths, by a homotopy with certified ends.

A generic platform has forty complex poses. Forty certified ends at different points are therefore
all of them, whatever the geometry (docs/certified.md has the argument).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...ground.arrays import Array
from ...ground.wording import counted, singular_or_plural
from ..interval import Interval
from ..rounding import bound
from .certificates import Balls, System, all_distinct, certify, chosen, decided, finite
from .paths import PathTracker, polished
from .start_system import StartSystem, distinct, most_poses, start_system
from .study import QUADRICS, SIZE, Complex, Legs, pose, quadrics

_SHORT_SUM = 2.0**-49  # share of rounding in sums of at most 12 products
_TOLERANCES = (1e-6, 1e-7, 1e-8)  # of the tracker, attempt by attempt


class LegIntervals(NamedTuple):
    """Six legs between two bodies, as intervals.

    Attributes:
        feet: anchor points on the base (6, 3) [m].
        tips: anchor points on the platform (6, 3) [m].
        squares: squared lengths (6,) [m^2].
    """

    feet: Interval
    tips: Interval
    squares: Interval


class PlatformPoses(NamedTuple):
    """Real poses, each certified to exist and to be alone near its place.

    Attributes:
        rotations: rotation of the platform in each pose (k, 3, 3).
        origins: its origin in each pose (k, 3) [m].
        complete: whether these were proved to be all.
        reason: why, in a clause.
    """

    rotations: Array
    origins: Array
    complete: bool
    reason: str


class _Problem(NamedTuple):
    """The quadrics of scaled legs, and how to scale poses back.

    Attributes:
        legs: the legs about their centres, of size one.
        system: their quadrics, with bounds of all errors.
        foot: centre of the feet (3,) [m].
        tip: centre of the tips (3,) [m].
        scale: length of one unit [m].
    """

    legs: Legs
    system: System
    foot: Array
    tip: Array
    scale: float


def platform_poses(legs: LegIntervals) -> PlatformPoses:
    """All poses of a platform on six legs, as far as they are reached and certified."""
    if pairs(legs.tips) is None and pairs(legs.feet) is not None:
        return _inverted(_platform_poses(LegIntervals(legs.tips, legs.feet, legs.squares)))
    return _platform_poses(legs)


def pairs(points: Interval) -> tuple[int, ...] | None:
    """An order (6,) in which equal points follow each other in pairs; None if there is none."""
    if np.any(points.lower != points.upper):
        return None
    _, groups = np.unique(
        points.lower,
        axis=0,
        return_inverse=True,
    )
    if not np.array_equal(
        np.bincount(groups.ravel()),
        [2, 2, 2],
    ):
        return None
    return tuple(np.argsort(groups.ravel(), kind="stable").tolist())


def _inverted(poses: PlatformPoses) -> PlatformPoses:
    """Poses of the platform from those of the base relative to it."""
    turned = np.swapaxes(poses.rotations, 1, 2)
    origins = -(turned @ poses.origins[:, :, None])[..., 0]
    return poses._replace(rotations=turned, origins=origins)


def _ordered(
    legs: LegIntervals,
    order: tuple[int, ...] | None,
) -> LegIntervals:
    if order is None:
        return legs
    rows = list(order)
    parts = [Interval(part.lower[rows], part.upper[rows]) for part in legs]
    return LegIntervals(*parts)


def _platform_poses(legs: LegIntervals) -> PlatformPoses:
    """Poses of a platform; pairs of equal tips are used if there are three."""
    order = pairs(legs.tips)
    in_pairs = order is not None
    most = most_poses(in_pairs)
    problem = _scaled(_ordered(legs, order))
    points = np.zeros((0, SIZE), dtype=complex)
    balls = certify(problem.system, points)
    for number, tolerance in enumerate(_TOLERANCES):
        start = start_system(number, in_pairs)
        before = len(points)
        points = np.concatenate([points, _ends(problem, start, tolerance)])
        if len(points):
            points = distinct(points)
        balls = certify(problem.system, points)
        balls = chosen(balls, balls.certified & finite(balls))
        points = balls.centres
        if len(points) >= most or len(points) == before:
            break
    return _result(problem, balls, most)


def _ends(problem: _Problem, start: StartSystem, tolerance: float) -> Complex:
    """Ends (n, 8) of the paths that arrived, made exact."""
    tracker = PathTracker.between(start.legs, problem.legs, tolerance)
    ends = tracker.ends(start.points)
    arrived = ends.points[ends.arrived]
    if len(arrived):
        arrived = polished(problem.system.matrices, arrived)
    usable = np.isfinite(arrived).all(axis=1)
    exact: Complex = arrived[usable]
    return exact


def _result(problem: _Problem, balls: Balls, most: int) -> PlatformPoses:
    real = chosen(balls, balls.real)
    rotations, origins = _poses(problem, real.centres.real)
    complete, reason = verdict(balls, most)
    return PlatformPoses(rotations, origins, complete, reason)


def verdict(balls: Balls, most: int) -> tuple[bool, str]:
    """Whether certified solutions are all, and why, in a clause.

    Args:
        balls: the solutions, all certified.
        most: the largest number of solutions that there can be.
    """
    count = len(balls.centres)
    every = f"{count} of {most} complex solutions are certified"
    number = int(balls.real.sum())
    of_these = f"{number} of them {singular_or_plural(number, 'is', 'are')} real"
    if count < most:
        other = "the other paths end at infinity or at singular places"
        return False, f"{every}, and {of_these}; {other}"
    if not (all_distinct(balls) and decided(balls).all()):
        return False, f"{every}, but some are too near each other to be separated"
    all_of_them = f"all {counted(count, 'complex solution')} are certified"
    return True, f"{all_of_them}, {of_these}, and no such platform has more"


def _poses(
    problem: _Problem,
    points: Array,
) -> tuple[Array, Array]:
    """Rotations and origins of real points (k, 8), in metres."""
    rotations = np.zeros((len(points), 3, 3))
    origins = np.zeros((len(points), 3))
    for k, point in enumerate(points):
        rotation, moved = pose(point)
        centre = problem.foot + problem.scale * moved
        rotations[k] = rotation
        origins[k] = centre - rotation @ problem.tip
    return rotations, origins


def _scaled(legs: LegIntervals) -> _Problem:
    foot = legs.feet.middle.mean(axis=0)
    tip = legs.tips.middle.mean(axis=0)
    feet = legs.feet - Interval(foot)
    tips = legs.tips - Interval(tip)
    squares = legs.squares
    largest = max(
        feet.magnitude.max(),
        tips.magnitude.max(),
        np.sqrt(squares.magnitude.max()),
    )
    scale = float(2.0 ** np.ceil(np.log2(largest)))  # a power of two changes no digits
    inverse = 1.0 / scale
    feet, tips, squares = feet * inverse, tips * inverse, squares * inverse**2
    middle = Legs(feet.middle, tips.middle, squares.middle)
    radii = np.zeros(QUADRICS)
    radii[:6] = entry_radii(feet, tips, squares)
    return _Problem(
        middle,
        System(quadrics(middle).real, radii),
        foot,
        tip,
        scale,
    )


def entry_radii(feet: Interval, tips: Interval, squares: Interval) -> Array:
    """Bounds (legs,) of the errors of all entries of the quadrics of legs."""
    foot_sizes = np.linalg.norm(feet.magnitude, axis=1)
    sizes = foot_sizes + np.linalg.norm(tips.magnitude, axis=1)
    uncertainty = feet.radius.sum(axis=1) + tips.radius.sum(axis=1)
    entries = sizes**2 + squares.magnitude + sizes
    changes = 4.0 * (sizes + uncertainty + 1.0) * uncertainty + squares.radius
    return bound(_SHORT_SUM * entries + changes)
