"""The result of identification from a recording: parameters, confidence and validation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core.identification import Identification, noise_limit

from ...messages.joint_samples import FloatArray

_ROUNDING: Final = 1e-9  # share of the largest base parameter up to which one counts as zero
# Ratio of residuals, estimates to file. Noise of the estimates explains only a few percent.
_MAX_RESIDUAL_RATIO: Final = 1.1
_NEGLIGIBLE: Final = 1e-3  # share of the efforts below which a residual does not matter
_MIN_EFFORT: Final = 0.1  # least effort of a joint, as a share of the largest of all
_TINY: Final = 1e-300

Mask = NDArray[np.bool_]
Names = tuple[str, ...]


@dataclass(frozen=True)
class ExcludedSample:
    """A sample that is used neither for training nor for testing.

    Attributes:
        time: time since the start of the bag [s].
        joint: joint with the largest deviation.
        off: its deviation [N m or N]; for a sample outlier [rad or m, or per second].
        what: deviating quantity: `effort`, `position` or `velocity`.
        late: delay of the stamp of a sample outlier relative to the motion [s]; NaN if unknown.
    """

    time: float
    joint: str
    off: float
    what: str
    late: float = float("nan")


@dataclass(frozen=True, eq=False)
class IdentificationResult:
    """Base parameters from a recording, validated on a held-out part.

    Attributes:
        identification: estimates (b,) with confidence.
        joints: the n active joints with recorded efforts.
        training_count: number of training samples.
        test_count: number of held-out samples.
        residual: standard deviation of held-out efforts minus those of the estimates (n,) [N m or
            N].
        file_residual: the same with the parameters of the robot file (n,) [N m or N].
        effort_deviation: standard deviation of the held-out efforts (n,) [N m or N].
        excluded: samples that are in neither part, in the order of time.
        file_values: base parameters of the robot file (b,).
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
        """The residual of the estimates over that of the robot file (n,)."""
        return self.residual / np.maximum(self.file_residual, _TINY)

    @property
    def worse_than_file(self) -> Names:
        """Joints whose held-out efforts the estimates explain worse than the robot file does.

        Residuals below a thousandth of the efforts are ignored.
        """
        efforts = np.maximum(self.effort_deviation, _MIN_EFFORT * self.effort_deviation.max())
        limit = np.maximum(_MAX_RESIDUAL_RATIO * self.file_residual, _NEGLIGIBLE * efforts)
        return _select(self.joints, self.residual > limit)

    @property
    def explained(self) -> FloatArray:
        """Share of the variance of the held-out efforts that the estimates explain (n,).

        NaN if the efforts do not vary.
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
        """Base parameters that differ significantly from 0, at 95 % for all together.

        Single intervals would miss one time in twenty, and many at once if the excitation is poor.
        So the bound is that of the largest of all estimates. `unphysical` parameters are excluded.
        If the estimates are `worse_than_file`, none is determined, since the model does not fit.
        """
        if self.worse_than_file:
            return ()
        return _select(self.identification.base.names, self._is_significant & self._is_physical)

    @property
    def unphysical(self) -> Names:
        """Base parameters that are significant, but that no bodies can have.

        Their noise is not white. If a combination is poorly excited, small errors of stamps and
        accelerations resemble it, and may lead to negative masses.
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
        """Base parameters (b,) of bodies with positive masses that fit the efforts best."""
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
        """Tolerance of the estimates (b,), at 95 % for all together."""
        limit = noise_limit(len(self.identification.estimate))
        return np.asarray(limit * self.identification.deviation)


def _select(names: Names, chosen: Mask) -> Names:
    """The chosen ones of some names."""
    return tuple(name for name, is_chosen in zip(names, chosen, strict=True) if is_chosen)
