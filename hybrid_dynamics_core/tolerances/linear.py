"""Errors of the tool to first order, and which tolerance they come from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..ground.arrays import Array
from .bounds import Ball, likely
from .entries import Entry, Play

HALVED = 0.75  # share of a variance that is gone when its tolerance is halved
TINY = 1e-300
POSITION = slice(0, 3)
ROTATION = slice(3, 6)


@dataclass(frozen=True, eq=False)
class Contribution:
    """What one variable does to the pose, at N poses.

    Attributes:
        entry: its tolerance or play.
        sensitivity: (N, 6, d) derivatives of the origin [m], then of the rotation vector [rad], by
            the number, or by each direction of the pin; base axes.
        covariance: (N, 6, 6) its part of the covariance of the errors.
        shift: (N, 6) its part of the mean errors: of a pin that is pressed to one side.
    """

    entry: Entry
    sensitivity: Array
    covariance: Array
    shift: Array

    @property
    def is_pressed(self) -> bool:
        """Whether it is a pin that is pressed to one side, and does not vary."""
        return isinstance(self.entry, Play) and self.entry.towards is not None

    def ball(self, half: slice) -> Ball:
        """What it adds to the errors of the position, or of the rotation: `farthest`."""
        return self.sensitivity[:, half], self.entry.half


@dataclass(frozen=True, eq=False)
class LinearErrors:
    """Errors of the tool to first order, at N poses; positions [m], rotations [rad], base axes.

    Attributes:
        u: active coordinates (N, n).
        confidence: probability of an error below the likely one.
        contributions: by variable.
        covariance: (N, 6, 6) of position and rotation vector: root sum square.
        shift: (N, 6) mean errors, from pins that are pressed to one side.
        worst_errors: (N, 6) the largest error of the position, and that of the rotation, that the
            tolerances allow.
        normal_sizes: (N, 2) sizes of both errors at the confidence, by the normal law.
    """

    u: Array
    confidence: float
    contributions: Mapping[str, Contribution]
    covariance: Array
    shift: Array
    worst_errors: Array
    normal_sizes: Array

    @property
    def likely(self) -> Array:
        """Size of the position's error (N,) [m] that is not exceeded with the confidence.

        By the normal law, but not above the worst error unless numbers are likely to be outside
        of their tolerances.
        """
        return self._bounded(0, self.worst)

    @property
    def worst(self) -> Array:
        """The largest error of the position (N,) [m] that the tolerances allow."""
        return np.asarray(np.linalg.norm(self.worst_errors[:, POSITION], axis=1))

    @property
    def likely_rotation(self) -> Array:
        """As `likely`, of the angle (N,) [rad]."""
        return self._bounded(1, self.worst_rotation)

    @property
    def worst_rotation(self) -> Array:
        """The largest angle (N,) [rad] that the tolerances allow."""
        return np.asarray(np.linalg.norm(self.worst_errors[:, ROTATION], axis=1))

    @property
    def deviation(self) -> Array:
        """Standard deviations (N, 6) [m, rad] along the axes of the base."""
        variances = np.einsum("nii->ni", self.covariance)
        return np.asarray(np.sqrt(variances.clip(0.0)))

    @property
    def shares(self) -> Mapping[str, float]:
        """Share of each variable in the variance of the position, over all poses; their sum is 1.

        The largest one is to be tightened first. Zero for all if nothing varies.
        """
        parts = {name: self._variance(one.covariance) for name, one in self.contributions.items()}
        total = max(sum(parts.values()), TINY)
        return {name: part / total for name, part in parts.items()}

    @property
    def halved(self) -> Mapping[str, float]:
        """The largest likely error [m] over all poses if the tolerance of one variable is halved.

        Of a pin that is pressed to one side, half of its shift goes too.
        """
        result: dict[str, float] = {}
        for name, one in self.contributions.items():
            covariance = self.covariance - HALVED * one.covariance
            shift = self.shift - 0.5 * one.shift
            sizes = likely(covariance[:, POSITION, POSITION], shift[:, POSITION], self.confidence)
            result[name] = float(sizes.max())
        return result

    @property
    def farthest(self) -> int:
        """Index of the pose with the largest worst error of the position."""
        return int(np.argmax(self.worst))

    def _bounded(self, k: int, worst: Array) -> Array:
        """Sizes (N,) by the normal law, below the worst ones where more cannot be likely.

        An error above the worst one needs a number outside its tolerance. The probability of that
        is at most the sum of those of all numbers.
        """
        sizes = self.normal_sizes[:, k]
        outside = sum(one.entry.outside for one in self.contributions.values())
        if outside > 1.0 - self.confidence:
            return sizes
        return np.minimum(sizes, worst)

    @staticmethod
    def _variance(covariance: Array) -> float:
        """Mean variance of the position over all poses [m^2]."""
        traces = np.einsum("nii->n", covariance[:, POSITION, POSITION])
        return float(traces.mean())
