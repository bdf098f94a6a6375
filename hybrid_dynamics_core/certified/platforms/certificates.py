"""Certificates of solutions of quadrics: seven in Study's coordinates, or three in a quaternion.

Around a point y, quadrics are exact in h: F(y + h) = F(y) + J h + Q(h, h). With C near J^-1,
Krawczyk's operator h -> h - C F(y + h) maps the ball |h| <= r into itself and contracts if

    beta + kappa r + gamma r^2 < r   and   kappa + 2 gamma r < 1

where beta, kappa and gamma bound C F(y), I - C J and C Q. The ball then holds one solution. All
bounds are in outward rounding, and hold for every geometry within its radius.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...ground.arrays import Array
from ..rounding import SHARE, bound
from .study import Complex

Flags = NDArray[np.bool_]


class System(NamedTuple):
    """Quadrics in one coordinate more, which are given up to rounding.

    Attributes:
        matrices: symmetric matrices (k, k + 1, k + 1).
        radii: largest error of an entry of each matrix (k,).
    """

    matrices: Array
    radii: Array


class Balls(NamedTuple):
    """Balls in the norm of the largest component, each with one solution.

    A solution lies on the hyperplane conj(y) . x = 1 about its centre y.

    Attributes:
        centres: unit vectors (n, k + 1).
        radii: radius of each ball (n,).
        certified: whether the ball was proved to hold one solution, and only one (n,).
        real: whether that solution was proved to be real (n,).
    """

    centres: Complex
    radii: Array
    certified: Flags
    real: Flags


def certify(system: System, points: Complex) -> Balls:
    """Certify solutions near unit vectors (n, 8); nearly real ones are made real."""
    points, real = _made_real(points)
    matrices = np.einsum("ijk,nk->nij", system.matrices, points)
    across = points.conj()
    jacobians = np.concatenate(
        [2.0 * matrices, across[:, None]],
        axis=1,
    )
    inverses = np.linalg.pinv(jacobians)
    sizes = np.abs(points)
    strengths = np.abs(system.matrices) + system.radii[:, None, None]
    products = np.einsum("ijk,nk->nij", strengths, sizes)
    unknown = sizes.sum(axis=1)[:, None, None] * system.radii[:, None]
    products = SHARE * products + unknown
    doubtful = np.concatenate(
        [2.0 * products, SHARE * sizes[:, None]],
        axis=1,
    )
    beta = _residual(system, points, inverses, products)
    kappa = _defect(inverses, jacobians, doubtful)
    sums = np.append(
        strengths.sum(axis=(1, 2)),
        0.0,
    )
    gamma = _largest(np.abs(inverses) @ sums)
    radii = 2.0 * beta + 1e-15
    reached = bound(beta + kappa * radii + gamma * radii**2)
    slope = bound(kappa + 2.0 * gamma * radii)
    certified = (reached < radii) & (slope < 1.0)
    return Balls(points, radii, certified, real & certified)


def chosen(balls: Balls, flags: Flags) -> Balls:
    """Some of the balls."""
    return Balls(
        balls.centres[flags], balls.radii[flags], balls.certified[flags], balls.real[flags]
    )


def all_distinct(balls: Balls) -> bool:
    """Whether no two balls can hold the same point of the projective space."""
    count = len(balls.centres)
    first, second = np.triu_indices(count, k=1)
    apart = _apart(balls.centres[first], balls.centres[second])
    both = balls.radii[first] + balls.radii[second]
    return bool(np.all(apart > _minor_change(both)))


def decided(balls: Balls) -> Flags:
    """Whether each solution was proved to be real, or proved not to be (n,)."""
    apart = _apart(balls.centres, balls.centres.conj())
    return balls.real | (apart > _minor_change(2.0 * balls.radii))


def finite(balls: Balls) -> Flags:
    """Whether e . e is proved to differ from zero, so that each solution is a pose (n,)."""
    turns = balls.centres[:, :4]
    value = np.abs((turns * turns).sum(axis=1))
    radii = balls.radii
    uncertainty = bound(2.0 * np.abs(turns).sum(axis=1) * radii + 4.0 * radii**2 + 8.0 * SHARE)
    return np.asarray(value > uncertainty)


def _made_real(points: Complex) -> tuple[Complex, Flags]:
    """The points with nearly real ones made real, and which ones these are."""
    largest = np.abs(points).argmax(axis=1)[:, None]
    phase = np.take_along_axis(points, largest, axis=1)
    turned = points * (phase.conj() / np.abs(phase))
    real = np.abs(turned.imag).max(axis=1) < 1e-9
    sizes = np.linalg.norm(turned.real, axis=1)
    units = turned.real / sizes[:, None]
    result = np.where(real[:, None], units, turned)
    return result, real


def _residual(
    system: System,
    points: Complex,
    inverses: Complex,
    doubtful: Array,
) -> Array:
    """Bounds (n,) of C F(y)."""
    sizes = np.abs(points)
    products = np.einsum("ijk,nk->nij", system.matrices, points)
    values = (products @ points[:, :, None])[..., 0]
    beside = (points.conj() * points).sum(axis=1) - 1.0
    vectors = np.concatenate(
        [values, beside[:, None]],
        axis=1,
    )
    errors = (doubtful @ sizes[:, :, None])[..., 0]
    errors = np.concatenate(
        [errors, np.full((len(points), 1), 4.0 * SHARE)],
        axis=1,
    )
    total = errors + SHARE * np.abs(vectors)
    strengths = np.abs(inverses)
    steps = np.abs((inverses @ vectors[..., None])[..., 0])
    uncertainty = (strengths @ total[..., None])[..., 0]
    return _largest(steps + uncertainty)


def _defect(inverses: Complex, jacobians: Complex, doubtful: Array) -> Array:
    """Bounds (n,) of I - C J."""
    strengths = np.abs(inverses)
    errors = strengths @ (doubtful + SHARE * np.abs(jacobians))
    defects = np.abs(np.eye(jacobians.shape[2]) - inverses @ jacobians)
    return _largest((defects + errors + SHARE).sum(axis=2))


def _largest(values: Array) -> Array:
    """Upper bounds (n,) of the largest of values (n, 8)."""
    largest: Array = bound(values).max(axis=1)
    return largest


def _apart(one: Complex, other: Complex) -> Array:
    """Largest minor of pairs of points (n, 8): zero if they are the same in projective space."""
    products = one[:, :, None] * other[:, None, :]
    minors = np.abs(products - np.swapaxes(products, 1, 2))
    largest: Array = minors.max(
        axis=(1, 2),
        initial=0.0,
    )
    return largest


def _minor_change(radii: Array) -> Array:
    """Largest change of a minor of unit vectors by two radii with this sum."""
    return bound(2.1 * radii + radii**2 + SHARE)
