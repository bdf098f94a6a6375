"""The trajectory of the paper's numerical example."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from ..messages.joint_samples import FloatArray

ROBOT: Final = "forging_chu2020"
SOURCE: Final = "Chu et al. (2020), Appl. Sci. 10, 2567"
JOINTS: Final = ("q1", "q12", "q22", "q4")
DURATION: Final = 10.0  # [s]

# Chu (2020), Section 3: q = start + rate t; q1 and q4 are in degrees there.
_START: Final = (0.0, 0.1, 0.15, 0.0)  # [rad, m, m, rad]
# Rates, in rad/s, m/s, m/s and rad/s.
_RATE: Final = (float(np.deg2rad(10.0)), 0.01, 0.005, float(np.deg2rad(5.0)))


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Motion of the active joints: one row for each sample, columns in the order of `JOINTS`.

    Attributes:
        time: (N,) [s] from 0.
        position: (N, 4) [rad or m].
        velocity: (N, 4) [rad/s or m/s].
    """

    time: FloatArray
    position: FloatArray
    velocity: FloatArray


def paper_trajectory(frequency: int) -> Trajectory:
    """The trajectory at constant rates, both ends included.

    Args:
        frequency: sampling rate [Hz].
    """
    time = np.arange(round(DURATION * frequency) + 1) / frequency
    position = np.array(_START) + np.outer(time, _RATE)
    return Trajectory(time, position, np.tile(_RATE, (time.size, 1)))
