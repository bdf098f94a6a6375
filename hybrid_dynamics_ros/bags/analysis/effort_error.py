"""How far recorded and computed efforts are apart, for most samples and for those far off."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np

from hybrid_dynamics_core.identification import noise_limit, robust_deviation

from ...messages.joint_samples import FloatArray
from .recording import EvaluatedRecording

_ROUNDING: Final = 1e-12  # share of the largest: without noise only rounding is about the median


@dataclass(frozen=True)
class EffortError:
    """Recorded less computed efforts of one joint, in the unit of its effort.

    Attributes:
        joint: its name.
        median: half of the samples are within it.
        near: 95 % of the samples are within it.
        limit: what noise about the median stays within, for all samples of 19 in 20 recordings.
        far: how many samples are further from the median than the limit.
        count: how many samples there are.
        rms: over all samples of the recording. A few that are far off make most of it.
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
    """The errors of the samples that a recording has, for each active joint with efforts."""
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
    centred = values - np.median(values)  # an offset of all samples is no reason to count them
    limit = noise_limit(len(values)) * float(robust_deviation(centred[:, None])[0])
    is_far = np.abs(centred) > limit + _ROUNDING * sizes.max()
    far = int(is_far.sum())
    return EffortError(joint, median, near, limit, far, len(values), rms)
