"""All poses of a planar platform on three legs of given lengths.

With complex numbers for points of the plane, a pose is p and z = exp(i theta), and a leg is

    (p + b z - a) (conj(p) + conj(b) / z - conj(a)) = d^2

Differences of the legs are linear in p and conj(p). Elimination leaves a polynomial of degree six
in z. Its roots on the unit circle are the poses. They are all, since elimination loses none.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..complex_ball import Ball, Polynomial
from ..platforms.study import Complex
from .roots import discs, on_unit_circle

DEGREE = 6


class PlanarLegs(NamedTuple):
    """Three legs of each of N planar platforms.

    Attributes:
        feet: anchor points on the base (N, 3) [m].
        tips: anchor points on the platform (N, 3) [m].
        squares: squared lengths (N, 3) [m^2].
    """

    feet: Ball
    tips: Ball
    squares: Ball


class PlanarPoses(NamedTuple):
    """Poses of N planar platforms.

    Attributes:
        turns: exp(i theta) of six solutions (N, 6); on the unit circle where `real`.
        places: origins of the platform (N, 6) [m].
        real: whether each solution was proved to be a pose (N, 6).
        complete: whether the poses were proved to be all (N,).
    """

    turns: Complex
    places: Complex
    real: NDArray[np.bool_]
    complete: NDArray[np.bool_]


class _Elimination(NamedTuple):
    """p determinant = along; the roots of `condition` are the solutions."""

    determinant: Polynomial
    along: Polynomial
    condition: Polynomial


def planar_poses(legs: PlanarLegs) -> PlanarPoses:
    """All poses of platforms on three legs."""
    eliminated = _eliminated(legs)
    coefficients = eliminated.condition.coefficients
    middle = np.stack(
        [c.middle for c in coefficients],
        axis=1,
    )
    radius = np.stack(
        [c.radius for c in coefficients],
        axis=1,
    )
    roots = discs(Ball(middle, radius))
    on, off = on_unit_circle(roots)
    turns = roots.centres
    z = Ball(turns, roots.radii)
    determinant = _columns(eliminated.determinant).at(z)
    along = _columns(eliminated.along).at(z)
    shifted = along.divided_by(determinant)
    regular = determinant.least > 0.0
    real = on & regular
    complete = roots.separate & (real | off).all(axis=1)
    unit = np.where(
        real,
        turns / np.abs(turns),
        turns,
    )
    places = shifted.middle - legs.tips.middle[:, :1] * unit + legs.feet.middle[:, :1]
    return PlanarPoses(unit, places, real, complete)


def _eliminated(legs: PlanarLegs) -> _Elimination:
    """Eliminate the place of the first tip, measured from the first foot."""
    first_square = _part(legs.squares, 0)
    u, v, w = [], [], []
    for leg in (1, 2):
        foot = _part(legs.feet, leg)
        alpha = foot.minus(_part(legs.feet, 0))
        tip = _part(legs.tips, leg)
        beta = tip.minus(_part(legs.tips, 0))
        alpha_bar = alpha.conjugate()
        beta_bar = beta.conjugate()
        constant = _part(legs.squares, leg).minus(first_square)
        constant = constant.minus(alpha.times(alpha_bar))
        constant = constant.minus(beta.times(beta_bar))
        u.append(Polynomial(-1, (beta_bar, _negative(alpha_bar))))
        v.append(Polynomial(0, (_negative(alpha), beta)))
        middle = (
            alpha.times(beta_bar),
            constant,
            alpha_bar.times(beta),
        )
        w.append(Polynomial(-1, middle))
    determinant = u[0].times(v[1]).minus(u[1].times(v[0]))
    along = w[0].times(v[1]).minus(w[1].times(v[0]))
    across = u[0].times(w[1]).minus(u[1].times(w[0]))
    square = Polynomial(0, (first_square,))
    condition = along.times(across).minus(determinant.times(determinant).times(square))
    return _Elimination(determinant, along, condition)


def _part(values: Ball, leg: int) -> Ball:
    return Ball(
        values.middle[:, leg],
        values.radius[:, leg],
    )


def _negative(values: Ball) -> Ball:
    return Ball(-values.middle, values.radius)


def _columns(polynomial: Polynomial) -> Polynomial:
    """The polynomial with coefficients as columns (N, 1), to be taken at points (N, n)."""
    columns = []
    for middle, radius in polynomial.coefficients:
        columns.append(Ball(middle[:, None], radius[:, None]))
    return Polynomial(polynomial.lowest, tuple(columns))
