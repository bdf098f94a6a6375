"""Outward rounding of results that are computed to the nearest double."""

from __future__ import annotations

import numpy as np

from ..ground.arrays import Array

# Sums of at most 90 real or 30 complex products are off by less than this share of the sum of
# absolute values, in any order, with or without fused operations (Higham 2002, chapter 3).
SHARE = 2.0**-46
TERMS = 90
TINY = 1e-290  # more than all that underflows in such a sum


def down(x: Array) -> Array:
    """A lower bound of a value that was rounded to the nearest double."""
    return np.nextafter(x, -np.inf)


def up(x: Array) -> Array:
    """An upper bound of a value that was rounded to the nearest double."""
    return np.nextafter(x, np.inf)


def bound(x: Array) -> Array:
    """An upper bound of a sum of non-negative terms that was computed in doubles."""
    raised: Array = x * (1.0 + SHARE) + TINY
    return raised
