"""Robust statistics of differences between recorded and computed efforts."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np

from hybrid_dynamics_core.identification import noise_limit, robust_deviation

from ...messages.joint_samples import FloatArray
from .recording import EvaluatedRecording

_ROUNDING: Final = 1e-12  # share of the largest value that is rounding


@dataclass(frozen=True)
class EffortError:
    """Statistics of recorded minus computed efforts of one joint [N m or N].

    Attributes:
        joint: its name.
        median: median of absolute differences.
        near: 95 % quantile of absolute differences.
        limit: bound about the median that noise exceeds in one of 20 recordings.
        far: number of samples further from the median than the limit.
        count: number of samples.
        rms: root mean square over all samples of the recording; outliers dominate it.
    """

    joint: str
    median: float
    near: float
    limit: float
    far: int
    count: int
    rms: float

    @property
    def facts(self) -> dict[str, Any]:
        """The error as plain data."""
        facts = asdict(self)
        del facts["joint"]
        return facts


def effort_errors(recording: EvaluatedRecording) -> list[EffortError]:
    """The statistics for each active joint with efforts, from the kept samples."""
    errors = []
    difference = recording.recorded - recording.efforts
    for k, column in enumerate(difference.T):
        values = column[np.isfinite(column)]
        if len(values):
            rms = float(recording.errors.rms[k])
            errors.append(_effort_error(recording.robot.active[k], values, rms))
    return errors


def _effort_error(joint: str, values: FloatArray, rms: float) -> EffortError:
    """Statistics of differences (N,)."""
    sizes = np.abs(values)
    median, near = np.percentile(sizes, [50.0, 95.0]).tolist()
    centred = values - np.median(values)  # a constant offset is no outlier
    limit = noise_limit(len(values)) * float(robust_deviation(centred[:, None])[0])
    is_far = np.abs(centred) > limit + _ROUNDING * sizes.max()
    far = int(is_far.sum())
    return EffortError(joint, median, near, limit, far, len(values), rms)
