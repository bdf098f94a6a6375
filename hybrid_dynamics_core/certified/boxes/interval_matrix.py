"""Matrices of intervals as middles and radii, and their inverses, in outward rounding."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...algebra.numerics import are_regular
from ...ground.arrays import Array
from ..interval import Interval
from ..rounding import SHARE, TERMS, bound


class IntervalMatrix(NamedTuple):
    """N matrices, entry by entry within a radius of a middle.

    Attributes:
        middle: middles (N, rows, columns).
        radius: radii (N, rows, columns).
    """

    middle: Array
    radius: Array

    @classmethod
    def of(
        cls,
        entries: Sequence[Interval],
        columns: int,
        count: int,
    ) -> IntervalMatrix:
        """A matrix from its entries, row by row, each a number or an array (count,)."""
        middles = [np.broadcast_to(entry.middle, count) for entry in entries]
        radii = [np.broadcast_to(entry.radius, count) for entry in entries]
        shape = (count, -1, columns)
        return cls(
            np.stack(middles, axis=-1).reshape(shape),
            np.stack(radii, -1).reshape(shape),
        )

    def preconditioner(self) -> Array:
        """Matrices (N, n, n) near the inverses of the middles; NaN where there is none.

        There is none for more rows than `SHARE` bounds the rounding of.
        """
        inverse = np.full_like(self.middle, np.nan)
        if self.middle.shape[2] > TERMS:
            return inverse
        with np.errstate(all="ignore"):
            usable = are_regular(self.middle)
        usable &= np.isfinite(self.radius).all(axis=(1, 2))
        inverse[usable] = np.linalg.inv(self.middle[usable])
        return inverse

    def defect(self, inverse: Array) -> Array:
        """Upper bounds (N, n, n) of |I - C A| for matrices C (N, n, n)."""
        identity = np.eye(self.middle.shape[2])
        sizes = np.abs(inverse)
        rounding = SHARE * (sizes @ np.abs(self.middle) + identity)
        return bound(np.abs(identity - inverse @ self.middle) + sizes @ self.radius + rounding)

    def inverse(self) -> IntervalMatrix:
        """The inverses; without bound where a matrix may be singular.

        With G >= |I - C A| the inverse differs from C by at most G |C| + G^2 |C| + ...
        """
        near = self.preconditioner()
        with np.errstate(all="ignore"):
            defect = self.defect(near)
            contraction = bound(defect.sum(axis=2)).max(axis=1)
            first = bound(defect @ np.abs(near))
            share = contraction / (1.0 - contraction)
            largest = first.max(axis=1, keepdims=True)
            others = share[:, None, None] * largest
            radius = bound(first + others)
        regular = contraction < 0.5
        radius = np.where(
            regular[:, None, None],
            radius,
            np.inf,
        )
        return IntervalMatrix(np.nan_to_num(near), radius)

    def entries(self) -> list[Interval]:
        """The entries row by row, arrays (N,)."""
        count = len(self.middle)
        middles = self.middle.reshape(count, -1).T
        radii = self.radius.reshape(count, -1).T
        return [Interval.around(m, r) for m, r in zip(middles, radii, strict=True)]
