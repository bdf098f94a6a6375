"""Errors of random robots within their tolerances, each with its loops closed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from ..calibration.closed_rows import ClosedRows, OpenLoopError, closed_near
from ..calibration.quantities import rotation_vectors
from ..ground.arrays import Array
from ..ground.progress import Progress
from .linear import POSITION, ROTATION
from .varied import VariedRobot

BATCH: Final = 20_000  # rows closed at once
CERTAINTY: Final = 0.95  # of the interval of a likely error


@dataclass(frozen=True, eq=False)
class SampledErrors:
    """Errors of M random robots at N poses, base axes; NaN where the loops of a robot do not close.

    Attributes:
        u: active coordinates (N, n).
        confidence: share of the robots whose error is below the likely one.
        errors: (M, N, 6) of the position [m] and rotation vector [rad].
    """

    u: Array
    confidence: float
    errors: Array

    @property
    def sizes(self) -> Array:
        """Sizes (M, N) of the position's error [m]."""
        return _lengths(self.errors[:, :, POSITION])

    @property
    def angles(self) -> Array:
        """Angles (M, N) of the rotation's error [rad]."""
        return _lengths(self.errors[:, :, ROTATION])

    @property
    def open_share(self) -> Array:
        """Share of the robots whose loops do not close (N,)."""
        return np.asarray(np.isnan(self.sizes).mean(axis=0))

    @property
    def likely(self) -> Array:
        """Size of the position's error (N,) [m] that is not exceeded with the confidence.

        A robot that does not close counts as one with an infinite error.
        """
        return _quantile(self.sizes, self.confidence)

    @property
    def likely_interval(self) -> Array:
        """Interval (N, 2) [m] that has the true likely error with 95 %, by order statistics."""
        from scipy.stats import binom  # noqa: PLC0415  slow to import

        count, poses, _ = self.errors.shape
        outside = 0.5 * (1.0 - CERTAINTY)
        below, above = binom.ppf([outside, 1.0 - outside], count, self.confidence)
        ordered = np.sort(_with_open(self.sizes), axis=0)
        beyond = np.full((1, poses), np.inf)
        ordered = np.concatenate([ordered, beyond])
        low = ordered[max(int(below) - 1, 0)]
        high = ordered[int(above)]
        return np.stack([low, high], axis=1)

    @property
    def likely_rotation(self) -> Array:
        """As `likely`, of the angle (N,) [rad]."""
        return _quantile(self.angles, self.confidence)

    @property
    def largest(self) -> Array:
        """The largest error of the position (N,) [m] among these robots."""
        return np.asarray(_with_open(self.sizes).max(axis=0))

    @property
    def mean(self) -> Array:
        """Mean errors (N, 6) [m, rad] of the robots that close."""
        return np.asarray(np.nanmean(self.errors, axis=0))

    @property
    def covariance(self) -> Array:
        """Covariances (N, 6, 6) of the robots that close."""
        result = np.empty((len(self.u), 6, 6))
        for k in range(len(self.u)):
            is_closed = np.isfinite(self.errors[:, k, 0])
            result[k] = np.cov(self.errors[is_closed, k], rowvar=False)
        return result


def sampled_errors(
    varied: VariedRobot, rows: ClosedRows, frame: str, changes: Array, confidence: float
) -> SampledErrors:
    """Close the loops of random robots.

    Args:
        varied: the robot.
        rows: N closed states of it.
        frame: name of the frame whose errors are meant.
        changes: (M, N, m) of what varies.
        confidence: share of the robots whose error is below the likely one.
    """
    robots, poses, _ = changes.shape
    errors = np.empty((robots, poses, 6))
    size = max(BATCH // poses, 1)
    with Progress(f"tolerances of {varied.robot.name}", robots) as progress:
        for first in range(0, robots, size):
            part = changes[first : first + size]
            errors[first : first + size] = _errors(varied, rows, frame, part)
            progress.update(min(first + size, robots))
    return SampledErrors(rows.s[:, varied.given], confidence, errors)


def _errors(varied: VariedRobot, rows: ClosedRows, frame: str, changes: Array) -> Array:
    """Errors (M, N, 6) of M robots."""
    robots, poses, columns = changes.shape
    flat = changes.reshape(-1, columns)
    charts = tuple(np.tile(chart, robots) for chart in rows.charts)
    s = np.tile(rows.s, (robots, 1))
    near = ClosedRows(rows.geometry, s, charts)
    moved, is_open = _closed(varied, near, flat)
    turned, origin = moved.poses().frame(frame)
    rotation, place = rows.poses().frame(frame)
    places = np.tile(place, (robots, 1))
    back = np.swapaxes(rotation, 1, 2)
    turns = turned @ np.tile(back, (robots, 1, 1))
    error = np.empty((robots * poses, 6))
    error[:, POSITION] = origin - places
    error[:, ROTATION] = rotation_vectors(turns)
    error[is_open] = np.nan
    return error.reshape(robots, poses, 6)


def _closed(varied: VariedRobot, near: ClosedRows, changes: Array) -> tuple[ClosedRows, Array]:
    """Closed states near others, and a mask of the rows that do not close; they stay as described.

    Each row is solved by itself, so the others are the same without those that stay open.
    """
    given, u = varied.given, near.s[:, varied.given]
    is_open = np.zeros(len(changes), dtype=bool)
    while True:
        closing = np.where(is_open[:, None], 0.0, changes)
        try:
            return closed_near(varied.at(closing), near, given, u), is_open
        except OpenLoopError as error:
            is_open[error.rows] = True


def _lengths(vectors: Array) -> Array:
    """Lengths (M, N) of vectors (M, N, 3)."""
    lengths: Array = np.linalg.norm(vectors, axis=2)
    return lengths


def _with_open(sizes: Array) -> Array:
    """Sizes with infinity for robots that do not close."""
    return np.where(np.isnan(sizes), np.inf, sizes)


def _quantile(sizes: Array, share: float) -> Array:
    """The size (N,) that a share of the rows (M, N) does not exceed."""
    ordered = np.sort(_with_open(sizes), axis=0)
    rank = int(np.ceil(share * len(ordered)))
    quantile: Array = ordered[rank - 1]
    return quantile
