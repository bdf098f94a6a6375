"""Checks of raw sensors: a clock that jumps, a stuck sensor, pressures in another unit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from ..closed_state.state import ClosedState
from ..description.actuators import HydraulicCylinder
from ..dynamics.pressure_check import pressure_problem
from ..errors import InputError
from ..ground.arrays import Array
from ..robot.robot import Robot

LONG = 5.0  # median intervals between samples, beyond which some are lost
LOST = 0.1  # [s] for which samples may be lost
SLOWEST = 5.0  # [s] between samples, beyond which the clock rather counts milliseconds
STUCK = 1.0  # [s] without any change that are no chance
LEAST = 20  # samples without any change that are no chance
REPEATED = 0.2  # share of samples that repeat the one before, above which a sensor is coarse
ALTERNATING = -0.3  # correlation of neighbouring second differences; -2/3 for white noise
ABRUPT = 5.0  # times the usual change of a rate, which no motion exceeds
USUAL = 0.98  # quantile of the changes of a rate that is usual
CHANGE = 0.05  # share of the largest force: no chamber keeps its pressure while it changes more
INFLUENCE = 1e-6  # share of an effort by which a coordinate has to change it


class SensorError(InputError):
    """A sensor gives what it cannot have measured."""


def check_clock(time: Array) -> Array:
    """The times (N,) [s], if they rise and no long part is missing.

    Raises:
        SensorError: the clock goes back, stands still or jumps ahead.
        InputError: a time is not finite, or there are too few.
    """
    if time.ndim != 1 or not np.isfinite(time).all():
        raise InputError(f"time has shape {time.shape}; expected (N,) finite numbers")
    steps = np.diff(time)
    if not len(steps):
        raise InputError("time: a motion has more than one sample")
    back = np.flatnonzero(steps <= 0.0)
    if len(back):
        k = int(back[0])
        raise SensorError(
            f"time: the clock goes from {time[k]:g} s to {time[k + 1]:g} s at sample {k + 1};"
            " expected times that rise"
        )
    usual = float(np.median(steps))
    if usual > SLOWEST:
        raise SensorError(
            f"time: samples are {usual:.3g} s apart, which shows no motion; if the clock counts in"
            " milliseconds, divide it by 1000"
        )
    ahead = np.flatnonzero(steps > LONG * usual + LOST)
    if len(ahead):
        k = int(ahead[0])
        raise SensorError(
            f"time: the clock jumps by {steps[k]:.3g} s at sample {k + 1} (t = {time[k]:g} s), and"
            f" samples are {usual:.3g} s apart; weigh the part before or after it"
        )
    return time


def check_pressures(cylinder: HydraulicCylinder, cap: Array, rod: Array) -> None:
    """Raise SensorError for pressures (N,) [Pa] that a cylinder cannot have."""
    for side, values in (("cap", cap), ("rod", rod)):
        problem = pressure_problem(cylinder, float(values.min()), float(values.max()))
        if problem:
            raise SensorError(
                f"{cylinder.joint}.{side}_pressure has {problem}; is its unit the one that the"
                " header names?"
            )


def check_moving(
    robot: Robot, time: Array, columns: Mapping[str, Array], state: ClosedState
) -> None:
    """Raise SensorError for a coordinate that stays the same to the last bit.

    Where other sensors are noisy, one without any noise is stuck. One that stops abruptly is stuck
    too. Coordinates that change no effort, as slewing on level ground, may be constant.

    Args:
        robot: the robot.
        time: (N,) [s].
        columns: recorded coordinates (N,) by name [rad, m].
        state: closed states, a batch of N.
    """
    for name, start, end in _repeats(time, columns):
        if _matters(robot, state, name):
            raise stuck(name, time, columns[name], start, end)


def check_changing(
    time: Array, pressures: Mapping[str, Array], idle: float, required: Array
) -> None:
    """Raise SensorError for a pressure of a cylinder that stays the same to the last bit.

    Args:
        time: (N,) [s].
        pressures: (N,) [Pa] of both sides, by name.
        idle: the pressure [Pa] at which a chamber may stay.
        required: (N,) force that the model needs [N].
    """
    size = float(np.abs(required).max())
    suspects = [name for name, _, _ in _repeats(time, pressures)]
    for name, values in pressures.items():
        start, end = longest_repeat(values)
        if not is_long(time, start, end) or values[start] in {0.0, idle}:
            continue
        change = float(np.ptp(required[start : end + 1]))
        if name in suspects or change > CHANGE * size:
            raise stuck(name, time, values, start, end)


def _repeats(time: Array, columns: Mapping[str, Array]) -> Iterator[tuple[str, int, int]]:
    """Columns that stay the same for long, as no joint at rest does, with first and last sample.

    Either another column is noisy meanwhile, or the column itself stops abruptly.
    """
    for name, values in columns.items():
        start, end = longest_repeat(values)
        if not is_long(time, start, end) or is_coarse(values, start, end):
            continue
        others = [other[start : end + 1] for key, other in columns.items() if key != name]
        if is_abrupt(values, start, end) or any(is_noisy(other) for other in others):
            yield name, start, end


def is_coarse(values: Array, start: int, end: int) -> bool:
    """Whether values (N,) repeat often outside of a stretch too, as those of a coarse sensor do."""
    outside = np.concatenate([np.diff(values[: start + 1]), np.diff(values[end:])])
    return len(outside) > LEAST and bool(np.mean(outside == 0.0) > REPEATED)


def is_abrupt(values: Array, start: int, end: int) -> bool:
    """Whether values (N,) stop or go on more abruptly than a motion does."""
    second = np.abs(np.diff(values, 2))
    ends = [k for k in (start - 1, end - 1) if 0 < k < len(second) - 1]
    near: list[int] = []
    for k in ends:
        near += [k - 1, k, k + 1]
    others = np.delete(second, near)
    if not ends or len(others) < LEAST:
        return False
    largest = ABRUPT * float(np.quantile(others, USUAL))
    return largest > 0.0 and bool(second[ends].max() > largest)


def is_noisy(values: Array) -> bool:
    """Whether neighbours in values (N,) scatter: second differences of white noise alternate."""
    if np.mean(np.diff(values) == 0.0) > REPEATED:
        return False
    second = np.diff(values, 2)
    squares = float(second @ second)
    products = float(second[1:] @ second[:-1])
    return squares > 0.0 and products < ALTERNATING * squares


def stuck(name: str, time: Array, values: Array, start: int, end: int) -> SensorError:
    """The error for a sensor whose values (N,) stay the same from one sample to another."""
    return SensorError(
        f"{name} is {values[start]:.6g} to the last bit from {time[start]:g} s to {time[end]:g} s,"
        " while others move: the sensor seems stuck; weigh a part where it works"
    )


def is_long(time: Array, start: int, end: int) -> bool:
    """Whether a repeat is too long for chance."""
    return end - start >= LEAST and time[end] - time[start] >= STUCK


def longest_repeat(values: Array) -> tuple[int, int]:
    """First and last sample of the longest stretch of equal values (N,)."""
    changes = np.flatnonzero(np.diff(values) != 0.0)
    edges = np.concatenate([[-1], changes, [len(values) - 1]])
    k = int(np.argmax(np.diff(edges)))
    return int(edges[k]) + 1, int(edges[k + 1])


def _matters(robot: Robot, state: ClosedState, name: str) -> bool:
    """Whether a coordinate changes the weight that the drives hold."""
    middle = state.rows(len(state.u) // 2)
    at_rest = robot.close(middle.u, near=middle)
    still = np.zeros_like(at_rest.u)
    d_u, _, _ = robot.inverse_dynamics_derivatives(at_rest, still)
    row = at_rest.R[robot.coordinates.index(name)]
    square = float(row @ row)
    if not square:
        return False
    efforts = robot.inverse_dynamics(at_rest, still)
    change = d_u @ row / square  # for the shortest change of u that changes the coordinate by 1
    largest = max(np.abs(efforts).max(), 1e-9)
    return bool(np.abs(change).max() > INFLUENCE * largest)
