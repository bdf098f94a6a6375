"""All roots of polynomials, each in a disc of its own.

Smith's discs (1970) about n approximations hold all n roots of a polynomial of degree n. A disc
that meets no other one holds exactly one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...ground.arrays import Array
from ..complex_ball import Ball
from ..platforms.study import Complex
from ..rounding import SHARE, bound

POLISHING = 3  # steps of Weierstrass' iteration


class Discs(NamedTuple):
    """Discs that hold the roots of N polynomials of degree n.

    Attributes:
        centres: centres (N, n).
        radii: radii (N, n), infinite where the leading coefficient may vanish.
        separate: whether no two discs of a polynomial meet (N,).
    """

    centres: Complex
    radii: Array
    separate: NDArray[np.bool_]


def discs(coefficients: Ball) -> Discs:
    """Discs of all roots.

    Args:
        coefficients: coefficients (N, n + 1), the highest power last.
    """
    middle = coefficients.middle
    leading = middle[:, -1:]
    usable = np.abs(leading) > 0.0
    monic = middle / np.where(usable, leading, 1.0)
    centres = _approximations(monic)
    gaps = _gaps(centres)
    products = gaps.prod(axis=2)
    least = coefficients.least[:, -1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        sizes = _largest_values(coefficients, centres)
        degree = centres.shape[1]
        radii = bound(degree * sizes / (least * np.abs(products) * (1.0 - SHARE)))
    radii = np.where(
        (least > 0.0) & np.isfinite(radii),
        radii,
        np.inf,
    )
    both = radii[:, :, None] + radii[:, None, :]
    apart = np.abs(centres[:, :, None] - centres[:, None, :])
    _set_diagonal(apart, np.inf)
    meets = apart * (1.0 - SHARE) <= bound(both)
    separate = ~np.asarray(meets.any(axis=(1, 2)))
    return Discs(centres, radii, separate)


def on_unit_circle(roots: Discs) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Which roots of self-inversive polynomials are proved to be on the unit circle, or off it.

    With each root w, 1 / conj(w) is a root too. If the mirrored disc meets no other disc, both are
    the same root.

    Returns:
        Whether each is on the circle, and whether it is off it, both (N, n).
    """
    sizes, radii = np.abs(roots.centres), roots.radii
    slack = SHARE * (1.0 + sizes)
    off = np.abs(sizes - 1.0) > bound(radii + slack)
    with np.errstate(divide="ignore", invalid="ignore"):
        powers = sizes**2 - radii**2
        mirrored = roots.centres / powers
        mirrored_radii = bound(radii / powers + SHARE)
    apart = np.abs(mirrored[:, :, None] - roots.centres[:, None, :])
    _set_diagonal(apart, np.inf)
    both = mirrored_radii[:, :, None] + radii[:, None, :]
    alone = (apart * (1.0 - SHARE) > bound(both)).all(axis=2)
    regular = powers > 0.5
    on = ~off & alone & regular & roots.separate[:, None]
    return on, off


def _approximations(monic: Complex) -> Complex:
    """Roots by eigenvalues of the companion matrix, then Weierstrass' iteration."""
    count, size = monic.shape
    degree = size - 1
    companion = np.zeros((count, degree, degree), dtype=complex)
    companion[:, 1:, :-1] = np.eye(degree - 1)
    companion[:, :, -1] = -monic[:, :-1]
    roots: Complex = np.linalg.eigvals(companion).astype(complex)
    for _ in range(POLISHING):
        values = _values(monic, roots)
        products = _gaps(roots).prod(axis=2)
        with np.errstate(divide="ignore", invalid="ignore"):
            steps = values / products
        roots = roots - np.where(
            np.isfinite(steps),
            steps,
            0.0,
        )
    return roots


def _gaps(roots: Complex) -> Complex:
    """Differences (N, n, n) of roots, with ones on the diagonal."""
    gaps: Complex = roots[:, :, None] - roots[:, None, :]
    _set_diagonal(gaps, 1.0)
    return gaps


def _set_diagonal(
    matrices: NDArray[np.inexact],
    value: float,
) -> None:
    """Set the diagonals of matrices (N, n, n)."""
    places = np.arange(matrices.shape[1])
    matrices[:, places, places] = value


def _values(coefficients: Complex, points: Complex) -> Complex:
    """Values (N, n) at points, by Horner's rule."""
    total = np.zeros_like(points)
    for column in coefficients.T[::-1]:
        total = total * points + column[:, None]
    return total


def _largest_values(coefficients: Ball, points: Complex) -> Array:
    """Upper bounds (N, n) of absolute values at points."""
    values = np.abs(_values(coefficients.middle, points))
    sizes = np.abs(points).astype(complex)
    magnitudes = _values(coefficients.magnitude.astype(complex), sizes).real
    radii = _values(coefficients.radius.astype(complex), sizes).real
    return bound(values + SHARE * magnitudes + radii)
