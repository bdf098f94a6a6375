"""Measured runs from bags: joint states, and pressures of the cylinders beside them."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.estimation import SensorError

from ...messages.interfaces import deserialize
from ...messages.joint_samples import FloatArray
from ...messages.pressures import PRESSURES, sample_of_pressures
from ..errors import BagError
from ..measured_file import Measurements
from ..recorded_pressures import pressure_topic
from ..storage.bag_reader import BagReader
from .collect import collect
from .recording import EvaluatedRecording

MOST: Final = 200_000  # samples that are weighed

Readings = dict[str, list[tuple[int, float, float]]]  # stamp [ns], cap, rod [Pa] by cylinder


def measurements_of_bag(
    path: Path, robot: Robot, name: str, topic: str | None = None
) -> tuple[Measurements, list[str]]:
    """Raw columns of a bag, and texts on parts that could not be read.

    Pressures are interpolated to the stamps of the joint states.

    Args:
        path: the bag.
        robot: the robot.
        name: its name or file.
        topic: topic of the joint states; None: the node's own, or the only one.

    Raises:
        BagError: the bag has no usable samples.
        SensorError: its clock goes back.
    """
    recording = collect(path, name, topic, "spline", None, MOST)
    for begin, end in recording.gaps:
        if end <= begin:
            raise SensorError(
                f"{path}: the clock goes from {begin:g} s back to {end:g} s; weigh a part before or"
                " after it, with --from and --to"
            )
    pressures, losses = _pressures_at(path, robot, recording)
    positions: dict[str, FloatArray] = {}
    efforts: dict[str, FloatArray] = {}
    for k, joint in enumerate(robot.active):
        positions[joint] = recording.state.u[:, k]
        values = recording.recorded[:, k]
        if joint in robot.drives and joint not in pressures and np.isfinite(values).all():
            efforts[joint] = values
    measurements = Measurements(recording.time, positions, efforts, pressures)
    return measurements, [*recording.losses, *losses]


def _pressures_at(
    path: Path, robot: Robot, recording: EvaluatedRecording
) -> tuple[dict[str, tuple[FloatArray, FloatArray]], list[str]]:
    """Pressures of each cylinder at the samples, and texts on unusable messages."""
    readings: Readings = {name: [] for name in robot.cylinders}
    with BagReader(path) as source:
        topic = pressure_topic(source)
        for _, messages in source.read(frozenset([topic])) if topic else ():
            for row in range(len(messages)):
                _add(readings, messages.message(row))
        losses = source.losses.describe()
    pressures: dict[str, tuple[FloatArray, FloatArray]] = {}
    for name, values in readings.items():
        if values:
            table = np.array(sorted(values))
            since = (table[:, 0] - recording.start_ns) * 1e-9
            if since[0] > recording.time[0] + 0.1 or since[-1] < recording.time[-1] - 0.1:
                raise BagError(f"{path}: {name}: pressures end before the joint states do")
            cap = np.interp(recording.time, since, table[:, 1])
            rod = np.interp(recording.time, since, table[:, 2])
            pressures[name] = (cap, rod)
    return pressures, losses


def _add(readings: Readings, data: bytes) -> None:
    """Add the pressures of a message."""
    sample = sample_of_pressures(deserialize(data, PRESSURES))
    rows = zip(sample.names, sample.cap_pressure, sample.rod_pressure, strict=False)
    for name, cap, rod in rows:
        if name in readings and np.isfinite([cap, rod]).all():
            readings[name].append((sample.stamp_ns, float(cap), float(rod)))
