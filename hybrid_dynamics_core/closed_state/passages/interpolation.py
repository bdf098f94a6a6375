"""Polynomials through values at some places, by Lagrange's formula."""

from __future__ import annotations

import numpy as np

from ...ground.arrays import Array


def weights(places: Array, x: float) -> Array:
    """Weights (m,) of the values at m places, in the polynomial's value at x."""
    gaps = places[:, None] - places
    np.fill_diagonal(gaps, 1.0)
    distances = np.tile(x - places, (len(places), 1))
    np.fill_diagonal(distances, 1.0)
    return np.asarray(np.prod(distances / gaps, axis=1))


def slope_weights(places: Array, x: float) -> Array:
    """Weights (m,) of the values in the polynomial's derivative at x, which is none of the places.

    The derivative of a product is itself times the sum of the inverse factors.
    """
    inverse = 1.0 / (x - places)
    others = inverse.sum() - inverse
    return np.asarray(weights(places, x) * others)


def root(
    places: Array,
    values: Array,
    x: float,
) -> float:
    """The root of the polynomial through values (m,) near x, by Newton's method."""
    for _ in range(8):
        value = float(weights(places, x) @ values)
        slope = float(slope_weights(places, x) @ values)
        if not slope:
            break
        x -= value / slope
    return x
