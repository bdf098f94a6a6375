"""Which sensor contradicts the others: the one without which they agree."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..errors import InputError
from ..ground.arrays import Array
from .motion_model import MotionModel
from .sensors import Sensor
from .start import Reading, unit_of
from .stream import StateFilter

CONTRADICTED = 0.2  # share of rejected readings, above which a sensor is refused
LEAST = 10  # rejected readings that are no chance
MOST = 800  # readings that are compared
AFTER = 0.5  # [s] after the contradiction that are compared
NEAR = 0.15  # relative error of a ratio of units
RATIOS = {  # readings over what was expected, and what the unit then is
    180.0 / math.pi: "in degrees",
    1.0 / 9.80665: "in g",
    1000.0: "in mm",
    -1.0: "in the opposite direction",
}


class Trial(NamedTuple):
    """What the others show without one sensor.

    Attributes:
        rejected: number of their readings beyond the gate.
        given: (M, k) readings of the sensor.
        expected: (M, k) what they should have been.
    """

    rejected: int
    given: Array
    expected: Array


def contradiction(
    sensors: Sequence[Sensor],
    readings: Sequence[Reading],
    motion: MotionModel,
    until: float,
) -> str:
    """Says which sensor contradicts the others, and what may be wrong with it.

    Args:
        sensors: all sensors with readings.
        readings: their readings, by stamp.
        motion: how the machine may move.
        until: time at which the contradiction shows [s].
    """
    chosen = [reading for reading in readings if reading.time <= until + AFTER][-MOST:]
    trials: dict[str, Trial] = {}
    for sensor in sensors:
        others = [other for other in sensors if other is not sensor]
        trial = _without(sensor, others, chosen, motion)
        if trial is not None:
            trials[sensor.name] = trial
    needed = [sensor.name for sensor in sensors if sensor.name not in trials]
    for name in needed:
        if _repeats(name, chosen):
            return f"{name} contradicts the other sensors; it seems stuck"
    if not trials:
        return "sensors contradict each other, and without one of them the state is not determined"
    least = min(trial.rejected for trial in trials.values())
    suspects = [sensor for sensor in sensors if sensor.name in trials]
    suspects = [sensor for sensor in suspects if trials[sensor.name].rejected == least]
    # several may do: one with an error of a usual kind, else the one that is farthest off
    usual = [sensor for sensor in suspects if _usual_error(trials[sensor.name])]
    worst = max(usual or suspects, key=lambda sensor: _misfit(sensor, trials[sensor.name]))
    trial = trials[worst.name]
    guess = _usual_error(trial) or "check its mounting pose, direction, noise and unit"
    unit = unit_of(worst)
    text = f"{worst.name} contradicts the other sensors; expected {unit}; {guess}"
    if needed and not _usual_error(trial):
        text += f". Or it is {' or '.join(needed)}, without which the state is not determined"
    return text


def _repeats(
    name: str,
    readings: Sequence[Reading],
) -> bool:
    """Whether the newest readings of a sensor are the same to the last bit."""
    newest = [reading.values for reading in readings if reading.sensor == name][-LEAST:]
    return len(newest) == LEAST and all(np.array_equal(newest[0], other) for other in newest)


def _without(
    sensor: Sensor,
    others: Sequence[Sensor],
    readings: Sequence[Reading],
    motion: MotionModel,
) -> Trial | None:
    """What the other sensors show; None if they do not determine the state."""
    rejected = 0
    given: list[Array] = []
    expected: list[Array] = []
    try:
        watched = StateFilter(sensor.robot, others, motion, latest=0.0, searches=0)
        for reading in readings:
            if reading.sensor != sensor.name:
                shown = watched.add(*reading)
                rejected += sum(not each.is_used for each in shown)
            elif watched.has_started:
                estimate = watched.estimate_at(reading.time)
                given.append(reading.values)
                expected.append(sensor.observe(estimate.state, estimate.ddu).readings)
    except InputError:
        return None
    if not given:
        return None
    return Trial(rejected, np.array(given), np.array(expected))


def _misfit(
    sensor: Sensor,
    trial: Trial,
) -> float:
    """Mean squared deviation of readings from what was expected, in those of their noise."""
    differences = trial.given - trial.expected
    scale = sensor.quality.noise**2 + sensor.quality.bias**2
    return float(np.mean(differences**2)) / scale


def _usual_error(trial: Trial) -> str:
    """What is wrong with a sensor, where its readings show a usual error; empty otherwise."""
    steps = np.diff(trial.given, axis=0)
    if len(steps) and np.mean((steps == 0.0).all(axis=1)) > 1.0 - CONTRADICTED:
        return "it seems stuck"
    product = float(np.sum(trial.given * trial.expected))
    if not product:
        return ""
    # by regression of either on the other, since either may be the noisier one
    ratios = (product / float(np.sum(trial.expected**2)), float(np.sum(trial.given**2)) / product)
    for factor, words in RATIOS.items():
        if any(abs(ratio / factor - 1.0) < NEAR for ratio in ratios):
            return f"it seems to be {words}"
    return ""
