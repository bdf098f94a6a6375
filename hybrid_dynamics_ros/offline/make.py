"""Bags out of trajectories: from a file, or a motion of the model itself, with noise on request."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import Robot
from hybrid_dynamics_ros.cdr import MOST_SEC, Template
from hybrid_dynamics_ros.offline.errors import BagError
from hybrid_dynamics_ros.offline.interfaces import JOINT_STATE
from hybrid_dynamics_ros.offline.mcap_chunk import Block
from hybrid_dynamics_ros.offline.mcap_write import new_bag
from hybrid_dynamics_ros.offline.smooth import split
from hybrid_dynamics_ros.offline.source import Topic
from hybrid_dynamics_ros.offline.trajectory_file import Trajectory
from hybrid_dynamics_ros.samples import FloatArray

_AT_ONCE: Final = 8192
PARTS: Final = ("position", "velocity", "effort")
START_NS: Final = 1_577_836_800 * 10**9  # 1 January 2020: the same bag every time


def simulated(robot: Robot, seconds: float, rate: float = 1000.0, seed: int = 0) -> Trajectory:
    """A motion of sums of sines within the limits, about the reference, with the efforts that it takes."""
    rng, n = np.random.default_rng(seed), len(robot.active)
    time = np.arange(round(seconds * rate)) / rate
    reach = np.minimum(np.abs(robot.limits - robot.reference[:, None]).min(axis=1), 0.5)
    reach = np.where(np.isfinite(reach), reach, 0.5)
    waves = [(rng.uniform(0.3, 4.0, n), rng.uniform(0.0, 6.3, n)) for _ in range(5)]
    for _ in range(20):
        width = 0.6 * reach / len(waves)
        position = np.tile(robot.reference, (len(time), 1))
        velocity, acceleration = np.zeros_like(position), np.zeros_like(position)
        for w, phase in waves:
            angle = w * time[:, None] + phase
            position = position + width * np.sin(angle)
            velocity = velocity + width * w * np.cos(angle)
            acceleration = acceleration - width * w**2 * np.sin(angle)
        state = robot.close(position, velocity, check=False)
        if not np.any(state.status) and float(np.min(state.singularity)) > 0.05:
            efforts = robot.inverse_dynamics(state, acceleration)
            return Trajectory(robot.active, time, position, velocity, efforts)
        reach = 0.7 * reach
    raise BagError(f"{robot.name}: found no motion about the reference that keeps away from singularities")


def write_trajectory(path: Path, trajectory: Trajectory, topic: str, notes: Mapping[str, str]) -> int:
    """Write a bag of JointState messages, the first of 1 January 2020; how many.

    Raises:
        BagError: the trajectory lasts beyond the stamps that messages can have.
    """
    _require_stamps(trajectory.time)
    counts = [0 if part is None else len(trajectory.names) for part in (trajectory.velocity, trajectory.effort)]
    template = Template().header().strings(trajectory.names).sequence("position", len(trajectory.names))
    template.sequence("velocity", counts[0]).sequence("effort", counts[1])
    stamps: NDArray[np.int64] = START_NS + np.round((trajectory.time - trajectory.time[0]) * 1e9).astype(np.int64)
    with new_bag(path, [Topic(topic, JOINT_STATE)], notes) as bag:
        for rows in split(len(stamps), _AT_ONCE):
            values = {part: getattr(trajectory, part)[rows] for part in PARTS if getattr(trajectory, part) is not None}
            values |= {"sec": stamps[rows] // 10**9, "nanosec": stamps[rows] % 10**9}
            bag.write([Block.filled(1, stamps[rows], template, values)])
    return len(stamps)


def _require_stamps(time: FloatArray) -> None:
    lasts, most = float(time[-1] - time[0]), MOST_SEC - START_NS // 10**9
    if lasts >= most:
        raise BagError(
            f"the trajectory lasts {lasts:.10g} s, and stamps of ROS reach {most} s beyond the start of the bag; "
            "expected times in seconds"
        )
