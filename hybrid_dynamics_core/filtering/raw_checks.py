"""What raw readings tell by themselves: other units, stuck sensors, clocks out of order."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from ..estimation.sensors import (
    LEAST,
    SLOWEST,
    SensorError,
    is_abrupt,
    is_coarse,
    is_long,
    is_noisy,
    longest_repeat,
)
from ..ground.arrays import Array
from ..ground.wording import counted
from .sensors import Kind, Sensor

TURN = 1.01 * math.tau  # [rad] angles that sensors give are within a turn
FASTEST = 40.0  # [rad/s] that a gyro shows
LEAST_GRAVITY, MOST_GRAVITY = 0.5, 2.0  # of gravity, between which a specific force is at first
IN_G = (0.5 / 9.81, 2.0 / 9.81)  # the same for readings in multiples of standard gravity
OUTSIDE = 0.25  # share of a range by which a reading may be outside of it
BREAK = 1.0  # [s] without readings that is reported
LONG = 20.0  # median intervals without readings that are reported

Columns = Mapping[str, tuple[Array, Array]]  # stamps (N,) [s] and readings (N, k) by sensor


def check_values(
    sensor: Sensor,
    values: Array,
) -> None:
    """Raise SensorError for readings (N, k) that seem to be in another unit.

    Args:
        sensor: the sensor.
        values: its readings, in its unit.
    """
    checks = {
        Kind.ACCELEROMETER: _check_force,
        Kind.GYRO: _check_rate,
        Kind.INCLINOMETER: _check_angle,
        Kind.ENCODER: _check_within,
        Kind.STROKE: _check_within,
    }
    if len(values) and sensor.kind in checks:
        checks[sensor.kind](sensor, values)


def _check_force(
    sensor: Sensor,
    values: Array,
) -> None:
    gravity = float(np.linalg.norm(sensor.robot.loads.gravity))
    if not gravity:
        return
    usual = float(np.median(np.linalg.norm(values, axis=1)))
    share = usual / gravity
    if LEAST_GRAVITY <= share <= MOST_GRAVITY:
        return
    hint = ""
    if IN_G[0] <= share <= IN_G[1]:
        hint = "; it seems to be in g"
    raise SensorError(
        f"{sensor.name} reads {usual:.4g} m/s^2 (median size), and gravity is {gravity:.4g};"
        f" expected m/s^2{hint}"
    )


def _check_rate(
    sensor: Sensor,
    values: Array,
) -> None:
    largest = float(np.abs(values).max())
    if largest > FASTEST:
        raise SensorError(
            f"{sensor.name} reads up to {largest:.4g} rad/s; expected rad/s; is it in degrees?"
        )


def _check_angle(
    sensor: Sensor,
    values: Array,
) -> None:
    largest = float(np.abs(values).max())
    if largest > TURN:
        raise SensorError(
            f"{sensor.name} reads up to {largest:.4g} rad, more than a turn; is it in degrees?"
        )


def _check_within(
    sensor: Sensor,
    values: Array,
) -> None:
    """Check that readings of a joint are near its range."""
    low, high = sensor.robot.description.joints[sensor.place].limits
    if not math.isfinite(high - low):
        if sensor.is_angle:
            _check_angle(sensor, values)
        return
    margin = OUTSIDE * (high - low)
    least, most = float(values.min()), float(values.max())
    if low - margin <= least and most <= high + margin:
        return
    is_turn = sensor.kind is Kind.ENCODER
    unit, other = ("rad", "degrees") if is_turn else ("m", "mm")
    raise SensorError(
        f"{sensor.name} reads {least:.4g} to {most:.4g} {unit}, and {sensor.place} has limits"
        f" {low:.4g} to {high:.4g}; is it in {other}?"
    )


def check_stuck(
    sensors: Sequence[Sensor],
    columns: Columns,
) -> None:
    """Raise SensorError for a sensor that repeats its reading as none does that works.

    An inertial sensor has noise at rest too. A sensor of a joint may be constant while the joint
    rests, but not if it has noise at other times, stops abruptly, or others of its kind have noise
    meanwhile.
    """
    noisy = [name for name, (_, values) in columns.items() if _any_noisy(values)]
    for sensor in sensors:
        stamps, values = columns[sensor.name]
        if not len(values):
            continue
        start, end = longest_repeat(_as_one(values))
        if not is_long(stamps, start, end):
            continue
        if sensor.kind in (Kind.GYRO, Kind.ACCELEROMETER):
            is_stuck = any(name != sensor.name for name in noisy)
        else:
            column = values[:, 0]
            alike = [other for other in sensors if other.kind is sensor.kind]
            others = [other for other in alike if other is not sensor]
            is_stuck = not is_coarse(column, start, end) and (
                is_abrupt(column, start, end)
                or _noisy_outside(column, start, end)
                or _any_noisy_within(others, columns, stamps[start], stamps[end])
            )
        if is_stuck:
            raise SensorError(
                f"{sensor.name} repeats {values[start].tolist()} to the last bit from"
                f" {stamps[start]:g} s to {stamps[end]:g} s: the sensor seems stuck"
            )


def _noisy_outside(values: Array, start: int, end: int) -> bool:
    """Whether values (N,) have noise before or after a stretch."""
    parts = (values[:start], values[end + 1 :])
    return any(len(part) > LEAST and is_noisy(part) for part in parts)


def _any_noisy_within(
    sensors: Sequence[Sensor], columns: Columns, start: float, end: float
) -> bool:
    """Whether readings of a sensor have noise from one time to another [s]."""
    for sensor in sensors:
        stamps, values = columns[sensor.name]
        if _any_noisy(values[(stamps >= start) & (stamps <= end)]):
            return True
    return False


def _as_one(values: Array) -> Array:
    """Numbers (N,) that change from row to row exactly where a row of (N, k) does."""
    changes = np.abs(np.diff(values, axis=0)).sum(axis=1)
    return np.concatenate([[0.0], np.cumsum(changes != 0.0)])


def _any_noisy(values: Array) -> bool:
    if len(values) < 3:
        return False
    return any(is_noisy(column) for column in values.T)


def in_order(columns: Columns) -> tuple[dict[str, tuple[Array, Array]], list[str]]:
    """Readings sorted by stamps, without repeats, and sentences on what was changed.

    Raises:
        SensorError: one sensor has two different readings with one stamp, or a clock that seems to
            count milliseconds.
    """
    sorted_columns: dict[str, tuple[Array, Array]] = {}
    notes: list[str] = []
    for name, (stamps, values) in columns.items():
        back = int((np.diff(stamps) < 0.0).sum())
        if back:
            notes.append(f"{name}: the clock goes back {counted(back, 'time')}; sorted by stamps")
        order = np.argsort(stamps, kind="stable")
        stamps, values = stamps[order], values[order]  # noqa: PLW2901
        repeats = np.flatnonzero(np.diff(stamps) == 0.0)
        differing = repeats[(values[repeats] != values[repeats + 1]).any(axis=1)]
        if len(differing):
            stamp = stamps[differing[0]]
            raise SensorError(f"{name}: two different readings have the stamp {stamp:g} s")
        if len(repeats):
            notes.append(f"{name}: {counted(len(repeats), 'reading')} repeated; used once")
        sorted_columns[name] = (np.delete(stamps, repeats), np.delete(values, repeats, axis=0))
        _check_pace(name, sorted_columns[name][0])
        notes += _breaks(name, sorted_columns[name][0])
    return sorted_columns, notes


def _check_pace(
    name: str,
    stamps: Array,
) -> None:
    steps = np.diff(stamps)
    if not len(steps):
        return
    usual = float(np.median(steps))
    if usual > SLOWEST:
        raise SensorError(
            f"{name}: readings are {usual:.3g} s apart, which shows no motion; if the clock counts"
            " in milliseconds, divide it by 1000"
        )


def _breaks(
    name: str,
    stamps: Array,
) -> list[str]:
    """Sentences on long parts without readings."""
    steps = np.diff(stamps)
    if not len(steps):
        return []
    limit = max(BREAK, LONG * float(np.median(steps)))
    begins = np.flatnonzero(steps > limit)
    pairs = zip(stamps[begins], stamps[begins + 1], strict=True)
    return [f"{name}: no reading from {start:g} s to {end:g} s" for start, end in pairs]
