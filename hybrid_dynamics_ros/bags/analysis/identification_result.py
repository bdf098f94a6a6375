"""The result of identification from a recording: parameters, their confidence and their worth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core.identification import Identification, noise_limit

from ...messages.joint_samples import FloatArray

_ROUNDING: Final = 1e-9  # share of the largest base parameter, up to which one is zero
# Ratio of residuals, estimates to file. Noise in the estimates alone makes some percent at most.
_MAX_RESIDUAL_RATIO: Final = 1.1
_NEGLIGIBLE: Final = 1e-3  # share of the efforts below which a residual does not matter
_MIN_EFFORT: Final = 0.1  # share of the largest effort that every joint counts with at least
_TINY: Final = 1e-300

Mask = NDArray[np.bool_]
Names = tuple[str, ...]


@dataclass(frozen=True)
class ExcludedSample:
    """A sample that counts neither for training nor for testing.

    Attributes:
        time: since the start of the bag [s].
        joint: the joint that is furthest off.
        off: by how much [N m or N]; of a sample outlier [rad or m, or per second].
        what: whether that is an `effort`, a `position` or a `velocity`.
        late: by how much later the stamp of a sample outlier is than the motion says [s]; NaN where
            that is not known.
    """

    time: float
    joint: str
    off: float
    what: str
    late: float = float("nan")


@dataclass(frozen=True, eq=False)
class IdentificationResult:
    """Base parameters from a recording, and how they do on a part of it that is held out.

    Attributes:
        identification: estimates (b,) with confidence.
        joints: the active ones whose efforts are recorded, (n,).
        training_count: how many samples the estimates are from.
        test_count: how many samples are held out.
        residual: standard deviation of the held-out efforts less those of the estimates (n,)
            [N m or N].
        file_residual: the same with the parameters of the robot file (n,) [N m or N].
        effort_deviation: standard deviation of the held-out efforts (n,) [N m or N].
        excluded: samples that count in neither part, in the order of their times.
        file_values: base parameters as the robot file has them (b,).
    """

    identification: Identification
    joints: tuple[str, ...]
    training_count: int
    test_count: int
    residual: FloatArray
    file_residual: FloatArray
    effort_deviation: FloatArray
    excluded: tuple[ExcludedSample, ...]
    file_values: FloatArray

    @property
    def residual_ratio(self) -> FloatArray:
        """The residual of the estimates in times of that of the robot file (n,)."""
        return self.residual / np.maximum(self.file_residual, _TINY)

    @property
    def worse_than_file(self) -> Names:
        """Joints whose held-out efforts the estimates explain worse than the robot file.

        A residual below a thousandth of the efforts does not count.
        """
        efforts = np.maximum(self.effort_deviation, _MIN_EFFORT * self.effort_deviation.max())
        limit = np.maximum(_MAX_RESIDUAL_RATIO * self.file_residual, _NEGLIGIBLE * efforts)
        return _select(self.joints, self.residual > limit)

    @property
    def explained(self) -> FloatArray:
        """Share of the variance of the held-out efforts that the estimates explain (n,).

        NaN where the efforts do not vary.
        """
        varies = self.effort_deviation > 0.0
        unexplained = (self.residual / np.where(varies, self.effort_deviation, 1.0)) ** 2
        return np.where(varies, 1.0 - unexplained, np.nan)

    @property
    def nonzero_in_file(self) -> Names:
        """Base parameters that are not zero in the robot file."""
        largest = max(float(np.abs(self.file_values).max(initial=0.0)), _TINY)
        is_nonzero = np.abs(self.file_values) > _ROUNDING * largest
        return _select(tuple(self.identification.table()), is_nonzero)

    @property
    def determined(self) -> Names:
        """Base parameters that differ from 0, at 95 % for all of them together.

        One interval in twenty misses, and where the motion excites too little many miss at once.
        So the estimate is as far from 0 as the largest of as many Gaussian values hardly ever is.
        None of them is `unphysical`. Where the estimates are `worse_than_file` none is determined:
        their intervals hold for a model that does not fit.
        """
        if self.worse_than_file:
            return ()
        return _select(self.identification.base.names, self._is_significant & self._is_physical)

    @property
    def unphysical(self) -> Names:
        """Base parameters that would be determined if bodies could have them.

        Their noise cannot be white. Where the motion hardly excites a combination, small errors of
        stamps and accelerations look like it. They know nothing of positive masses.
        """
        if self.worse_than_file:
            return ()
        return _select(self.identification.base.names, self._is_significant & ~self._is_physical)

    @property
    def undetermined(self) -> Names:
        """Base parameters that are not zero in the robot file and not determined."""
        return tuple(name for name in self.nonzero_in_file if name not in self.determined)

    @property
    def physical(self) -> FloatArray:
        """Base parameters of bodies with positive masses, nearest to the efforts (b,)."""
        return np.asarray(self.identification.base.values(self.identification.values))

    @property
    def _is_significant(self) -> Mask:
        return np.asarray(np.abs(self.identification.estimate) > self._tolerance)

    @property
    def _is_physical(self) -> Mask:
        difference = np.abs(self.identification.estimate - self.physical)
        return np.asarray(difference <= self._tolerance)

    @property
    def _tolerance(self) -> FloatArray:
        """How far the estimates may be off, at 95 % for all of them together (b,)."""
        limit = noise_limit(len(self.identification.estimate))
        return np.asarray(limit * self.identification.deviation)


def _select(names: Names, chosen: Mask) -> Names:
    """The chosen ones of some names."""
    return tuple(name for name, is_chosen in zip(names, chosen, strict=True) if is_chosen)
