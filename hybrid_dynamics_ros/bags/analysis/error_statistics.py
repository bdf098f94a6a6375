"""Statistics of recorded minus computed efforts, over all samples of a recording."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...messages.joint_samples import FloatArray


@dataclass(eq=False)
class ErrorStatistics:
    """Sums over all samples with both efforts, by active joint (n,) [N m or N].

    Attributes:
        count: number of samples.
        total: sum of the errors, recorded minus computed.
        squares: sum of their squares.
        largest: largest absolute error.
        largest_ns: stamp of the largest error [ns].
        recorded_total: sum of the recorded efforts.
        recorded_squares: sum of their squares.
    """

    count: NDArray[np.int64]
    total: FloatArray
    squares: FloatArray
    largest: FloatArray
    largest_ns: NDArray[np.int64]
    recorded_total: FloatArray
    recorded_squares: FloatArray

    @staticmethod
    def empty(n: int) -> ErrorStatistics:
        """Statistics of n joints before the first sample."""
        zeros = np.zeros(n)
        integers = np.zeros(n, dtype=np.int64)
        return ErrorStatistics(integers, zeros, zeros, zeros, integers, zeros, zeros)

    @np.errstate(over="ignore", invalid="ignore")  # numbers of damaged bags may overflow
    def add(self, recorded: FloatArray, computed: FloatArray, stamp_ns: NDArray[np.int64]) -> None:
        """Add samples.

        Args:
            recorded: efforts (N, n) [N m or N].
            computed: efforts (N, n) [N m or N].
            stamp_ns: stamps (N,) [ns].
        """
        if not len(recorded):
            return
        good = np.isfinite(recorded) & np.isfinite(computed)
        error = np.where(good, recorded - computed, 0.0)
        effort = np.where(good, recorded, 0.0)
        self.count = self.count + good.sum(axis=0)
        self.total = self.total + error.sum(axis=0)
        self.squares = self.squares + (error**2).sum(axis=0)
        size = np.abs(error)
        largest = size.max(axis=0)
        largest_ns = stamp_ns[size.argmax(axis=0)]
        self.largest_ns = np.where(largest > self.largest, largest_ns, self.largest_ns)
        self.largest = np.maximum(self.largest, largest)
        self.recorded_total = self.recorded_total + effort.sum(axis=0)
        self.recorded_squares = self.recorded_squares + (effort**2).sum(axis=0)

    @property
    def mean(self) -> FloatArray:
        """Mean error (n,) [N m or N]."""
        return self.total / np.maximum(self.count, 1)

    @property
    def rms(self) -> FloatArray:
        """Root of the mean squared error (n,) [N m or N]."""
        return np.sqrt(self.squares / np.maximum(self.count, 1))

    @property
    def explained(self) -> FloatArray:
        """Share of the variance of the recorded efforts that the model explains (n,); 1 at best."""
        count = np.maximum(self.count, 1)
        variance = self.recorded_squares / count - (self.recorded_total / count) ** 2
        unexplained = self.squares / count - self.mean**2
        varies = variance > 0.0
        return np.where(varies, 1.0 - unexplained / np.where(varies, variance, 1.0), np.nan)
