"""Bags from trajectories: those of a file, or of a simulated motion, with optional noise."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import Robot

from ..messages.cdr import MOST_SEC, NS
from ..messages.interfaces import JOINT_STATE
from ..messages.joint_samples import FloatArray
from ..messages.joint_state_layout import joint_state_template
from .errors import BagError
from .samples import slices
from .storage.bag_writer import new_bag
from .storage.mcap_chunk import RecordBlock
from .storage.storage import Topic
from .trajectory_file import Trajectory

PARTS: Final = ("position", "velocity", "effort")
START_NS: Final = 1_577_836_800 * NS  # 1 January 2020, for reproducible bags
_BATCH: Final = 8192  # messages per chunk
_MAX_REACH: Final = 1.0  # [rad or m] to each side of the reference
_SWEPT_SHARE: Final = 0.9  # share of the range that the motion covers
_ANGULAR_RATES: Final = (0.3, 6.0)  # [rad/s] least and largest frequency of the sines
_WAVE_COUNT: Final = 5
_MAX_SHRINKS: Final = 25
_SHRINK: Final = 0.8
_MIN_SINGULARITY: Final = 0.05  # least distance to singularities


def simulated(robot: Robot, seconds: float, rate: float = 1000.0, seed: int = 0) -> Trajectory:
    """A motion of sums of sines with its efforts, which excites all inertias.

    Each active joint covers its range, but at most 1 rad or m to each side of the reference. All
    ranges shrink towards the reference until every state closes away from singularities.

    Args:
        robot: the robot.
        seconds: duration [s].
        rate: samples per second [Hz].
        seed: seed of the random numbers.

    Raises:
        BagError: every motion about the reference comes near a singularity.
    """
    time = np.arange(round(seconds * rate)) / rate
    lower = np.maximum(robot.limits[:, 0], robot.reference - _MAX_REACH)
    upper = np.minimum(robot.limits[:, 1], robot.reference + _MAX_REACH)
    middle = 0.5 * (lower + upper) - robot.reference
    amplitude = 0.5 * _SWEPT_SHARE * (upper - lower)
    waves = _sine_sums(np.random.default_rng(seed), time, len(robot.active))
    for k in range(_MAX_SHRINKS):
        share = _SHRINK**k
        swing, velocity, acceleration = (share * amplitude * wave for wave in waves)
        position = robot.reference + share * middle + swing
        state = robot.close(position, velocity, check=False)
        if not np.any(state.status) and float(np.min(state.singularity)) > _MIN_SINGULARITY:
            efforts = robot.inverse_dynamics(state, acceleration)
            return Trajectory(robot.active, time, position, velocity, efforts)
    raise BagError(
        f"{robot.name}: found no motion about the reference that keeps away from singularities"
    )


def _sine_sums(
    rng: np.random.Generator, time: FloatArray, n: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Sums of sines (N, n) with amplitude 1, and their first and second derivatives."""
    shape = (_WAVE_COUNT, n)
    rates = rng.uniform(*_ANGULAR_RATES, shape)
    phases = rng.uniform(0.0, 2.0 * np.pi, shape)
    sums = np.zeros((3, len(time), n))
    for w, phase in zip(rates, phases, strict=True):
        angle = w * time[:, None] + phase
        sine = np.sin(angle)
        sums[0] += sine
        sums[1] += w * np.cos(angle)
        sums[2] += -(w**2) * sine
    size = np.maximum(np.abs(sums[0]).max(axis=0), 1.0)
    position, velocity, acceleration = sums / size
    return position, velocity, acceleration


def write_trajectory(
    path: Path, trajectory: Trajectory, topic: str, notes: Mapping[str, str]
) -> int:
    """Write a bag of JointState messages from 1 January 2020 on; returns their number.

    Args:
        path: folder of the bag.
        trajectory: the trajectory.
        topic: name of the topic.
        notes: custom data for the metadata.

    Raises:
        BagError: the trajectory exceeds the range of stamps.
    """
    _require_stamps(trajectory.time)
    template = joint_state_template(
        trajectory.names,
        velocity=trajectory.velocity is not None,
        effort=trajectory.effort is not None,
    )
    columns = {part: getattr(trajectory, part) for part in PARTS}
    columns = {part: values for part, values in columns.items() if values is not None}
    nanoseconds = np.round((trajectory.time - trajectory.time[0]) * 1e9)
    stamps: NDArray[np.int64] = START_NS + nanoseconds.astype(np.int64)
    with new_bag(path, [Topic(topic, JOINT_STATE)], notes) as bag:
        for rows in slices(len(stamps), _BATCH):
            values = {part: column[rows] for part, column in columns.items()}
            values["sec"] = stamps[rows] // NS
            values["nanosec"] = stamps[rows] % NS
            block = RecordBlock.filled(bag.channels[topic], stamps[rows], template, values)
            bag.write([block])
    return len(stamps)


def _require_stamps(time: FloatArray) -> None:
    duration = float(time[-1] - time[0])
    longest = MOST_SEC - START_NS // NS
    if duration >= longest:
        raise BagError(
            f"the trajectory lasts {duration:.10g} s, and stamps of ROS reach {longest} s beyond"
            " the start of the bag; expected times in seconds"
        )
