"""Bags out of trajectories: from a file, or a motion of the model itself, with noise on request."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import Robot

from ..messages.cdr import MOST_SEC, MessageTemplate
from ..messages.interfaces import JOINT_STATE
from ..messages.joint_samples import FloatArray
from .errors import BagError
from .smooth import split
from .storage.bag_writer import new_bag
from .storage.mcap_chunk import RecordBlock
from .storage.storage import Topic
from .trajectory_file import Trajectory

_AT_ONCE: Final = 8192
_REACH: Final = 1.0  # [rad or m] to each side of the reference, where a joint's limits are wider
_SWEPT: Final = 0.9  # share of the range that the motion takes
_RATES: Final = (0.3, 6.0)  # [rad/s] of the sines
_WAVES: Final = 5
_TRIES: Final = 25
_REGULAR: Final = 0.05  # distance to a singularity that the motion keeps
PARTS: Final = ("position", "velocity", "effort")
START_NS: Final = 1_577_836_800 * 10**9  # 1 January 2020: the same bag every time


def simulated(robot: Robot, seconds: float, rate: float = 1000.0, seed: int = 0) -> Trajectory:
    """A motion of sums of sines through as much of the limits as keeps away from singularities, with its efforts.

    Wide and fast motion is what shows inertias: each active joint sweeps its range, or _REACH to
    each side of the reference where that is less; all ranges shrink towards the reference until
    every state closes.
    """
    time = np.arange(round(seconds * rate)) / rate
    lower = np.maximum(robot.limits[:, 0], robot.reference - _REACH)
    upper = np.minimum(robot.limits[:, 1], robot.reference + _REACH)
    middle, half = 0.5 * (lower + upper) - robot.reference, 0.5 * _SWEPT * (upper - lower)
    wave = _waves(np.random.default_rng(seed), time, len(robot.active))
    for k in range(_TRIES):
        share = 0.8**k
        position, velocity, acceleration = (share * half * part for part in wave)
        position = robot.reference + share * middle + position
        state = robot.close(position, velocity, check=False)
        if not np.any(state.status) and float(np.min(state.singularity)) > _REGULAR:
            efforts = robot.inverse_dynamics(state, acceleration)
            return Trajectory(robot.active, time, position, velocity, efforts)
    raise BagError(
        f"{robot.name}: found no motion about the reference that keeps away from singularities"
    )


def _waves(
    rng: np.random.Generator, time: FloatArray, n: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Sums of sines (N, n) of size 1, and their first and second derivatives."""
    w, phase = rng.uniform(*_RATES, (_WAVES, n)), rng.uniform(0.0, 2.0 * np.pi, (_WAVES, n))
    parts = np.zeros((3, len(time), n))
    for wave, begin in zip(w, phase, strict=True):
        angle = wave * time[:, None] + begin
        parts += np.stack([np.sin(angle), wave * np.cos(angle), -(wave**2) * np.sin(angle)])
    position, velocity, acceleration = parts / np.maximum(np.abs(parts[0]).max(axis=0), 1.0)
    return position, velocity, acceleration


def write_trajectory(
    path: Path, trajectory: Trajectory, topic: str, notes: Mapping[str, str]
) -> int:
    """Write a bag of JointState messages, the first of 1 January 2020; how many.

    Raises:
        BagError: the trajectory lasts beyond the stamps that messages can have.
    """
    _require_stamps(trajectory.time)
    counts = [
        0 if part is None else len(trajectory.names)
        for part in (trajectory.velocity, trajectory.effort)
    ]
    template = (
        MessageTemplate()
        .header()
        .strings(trajectory.names)
        .sequence("position", len(trajectory.names))
    )
    template.sequence("velocity", counts[0]).sequence("effort", counts[1])
    stamps: NDArray[np.int64] = START_NS + np.round(
        (trajectory.time - trajectory.time[0]) * 1e9
    ).astype(np.int64)
    with new_bag(path, [Topic(topic, JOINT_STATE)], notes) as bag:
        for rows in split(len(stamps), _AT_ONCE):
            values = {
                part: getattr(trajectory, part)[rows]
                for part in PARTS
                if getattr(trajectory, part) is not None
            }
            values |= {"sec": stamps[rows] // 10**9, "nanosec": stamps[rows] % 10**9}
            bag.write([RecordBlock.filled(1, stamps[rows], template, values)])
    return len(stamps)


def _require_stamps(time: FloatArray) -> None:
    lasts, most = float(time[-1] - time[0]), MOST_SEC - START_NS // 10**9
    if lasts >= most:
        raise BagError(
            f"the trajectory lasts {lasts:.10g} s, and stamps of ROS reach {most} s beyond the"
            " start of the bag; expected times in seconds"
        )
