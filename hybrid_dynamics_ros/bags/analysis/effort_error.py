"""How far recorded and computed efforts are apart: what most samples are within, and how many are far off."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hybrid_dynamics_core.identification import noise_limit, robust_deviation

from ...messages.joint_samples import FloatArray
from .collect import Track

_ROUNDING = 1e-12  # of the largest: without noise only rounding is left about the middle


@dataclass(frozen=True)
class EffortError:
    """Recorded less computed of one joint, in the unit of its effort.

    Attributes:
        joint: its name.
        median: half of the samples are within it; near: 95 % are.
        limit: what noise about the middle of the samples stays within in all of them, in 19 of 20
        recordings.
        far: how many samples are farther from that middle than the limit; count: of how many.
        rms: over all samples of the recording; a few that are far off make most of it.
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
        """As plain data."""
        return {
            key: getattr(self, key) for key in ("median", "near", "limit", "far", "count", "rms")
        }


def effort_errors(track: Track) -> list[EffortError]:
    """One for each active joint with recorded efforts; of the samples that the track kept."""
    left = track.recorded - track.efforts
    found = (_spread(track, k, part[np.isfinite(part)]) for k, part in enumerate(left.T))
    return [error for error in found if error.count]


def _spread(track: Track, k: int, left: FloatArray) -> EffortError:
    name, rms = track.robot.active[k], float(track.errors.rms[k])
    if not len(left):
        return EffortError(name, np.nan, np.nan, np.nan, 0, 0, rms)
    sizes = np.abs(left)
    median, near = (float(value) for value in np.percentile(sizes, [50.0, 95.0]))
    about = left - np.median(left)  # an offset of all samples is no reason to count them
    limit = noise_limit(len(sizes)) * float(robust_deviation(about[:, None])[0])
    far = int((np.abs(about) > limit + _ROUNDING * sizes.max()).sum())
    return EffortError(name, median, near, limit, far, len(sizes), rms)
