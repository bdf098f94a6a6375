"""Ranges of sliders: limits of coordinates, or ends of the range in which the loops close."""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Decimal
from typing import Final

import numpy as np

from ..closed_state.state import ClosedState
from ..errors import InputError, StateError
from ..ground.arrays import Array
from ..robot.robot import Robot

FINE: Final = 1000  # least number of steps of a slider
STEPS: Final = 60  # steps of a search for the end of a range
HALF_TURN: Final = float(np.pi)  # [rad] to either side, for revolute joints without limits
ROUND: Final = (1.0, 2.0, 5.0, 10.0)  # round numbers, times a power of ten


@dataclass(frozen=True)
class Range:
    """Range of a quantity.

    Attributes:
        name: name of the quantity.
        unit: unit of the numbers.
        low: the lower end.
        high: the upper end.
        limits: limits of the description.
    """

    name: str
    unit: str
    low: float
    high: float
    limits: tuple[float, float] = (-math.inf, math.inf)

    def take(self, wanted: float, slack: float) -> float:
        """Check a value, and snap it to an end of the range if it is near.

        Args:
            wanted: the requested value.
            slack: a value beyond an end by at most this, or by rounding, becomes the end.

        Returns:
            The value.

        Raises:
            InputError: the value is out of range; the message suggests degrees if they would fit.
        """
        if self.low - 1.01 * slack <= wanted <= self.high + 1.01 * slack:
            return self._snapped(wanted, slack)
        raise InputError(
            f"{self.name} = {wanted:.6g} {self.unit} is beyond {self._end(wanted)} {self.unit}; "
            f"it goes from {self.low:.6g} to {self.high:.6g} {self.unit}{self._in_degrees(wanted)}"
        )

    def _snapped(self, value: float, slack: float) -> float:
        """The end near a value, otherwise the value."""
        if value - self.low < slack:
            return self.low
        if self.high - value < slack:
            return self.high
        return value

    def _end(self, wanted: float) -> str:
        """Text on the end that a value is beyond."""
        end, limit = self.high, self.limits[1]
        if wanted < self.low:
            end, limit = self.low, self.limits[0]
        is_limit = math.isclose(end, limit, abs_tol=1e-12)
        what = "its limit" if is_limit else "the end of its slider,"
        return f"{what} {end:.6g}"

    def _in_degrees(self, wanted: float) -> str:
        if self.unit != "rad":
            return ""
        low, high = math.degrees(self.low), math.degrees(self.high)
        text = f" ({low:.4g} to {high:.4g} deg)"
        if low <= wanted <= high:
            text += f". The box takes rad: {wanted:.6g} deg are {math.radians(wanted):.5g} rad"
        return text


def slider_ranges(robot: Robot, start: ClosedState, size: float) -> Array:
    """The range of each active coordinate: its limits, otherwise as far as the loops close.

    Args:
        robot: the robot.
        start: the state from which ends are searched.
        size: size of the robot [m], which is the range of an unlimited prismatic joint. A revolute
            one has half a turn.

    Returns:
        (n, 2) [rad or m].
    """
    ranges = np.array(robot.limits)
    for k, name in enumerate(robot.active):
        reach = HALF_TURN if robot.joint_types[name] == "revolute" else size
        for side, way in ((0, -reach), (1, reach)):
            if not np.isfinite(ranges[k, side]):
                ranges[k, side] = _closing_end(robot, start, k, way)
    low = np.minimum(ranges[:, 0], start.u)
    high = np.maximum(ranges[:, 1], start.u)
    return np.stack([low, high], axis=1)


def _closing_end(
    robot: Robot,
    start: ClosedState,
    k: int,
    way: float,
) -> float:
    """The last value of a coordinate, in a direction, at which all loops close."""
    path = np.tile(start.u, (STEPS, 1))
    path[:, k] += way * np.arange(1, STEPS + 1) / STEPS
    try:
        robot.close_path(path, near=start)
    except StateError as error:
        if not error.index:
            return float(start.u[k])
        return float(path[error.index - 1, k])
    return float(path[-1, k])


def on_round_steps(low: float, high: float) -> tuple[float, float, float]:
    """A range in at least 1000 round steps, for a slider.

    Returns:
        Lower end, upper end, step.
    """
    finest = max(high - low, 1e-9) / FINE
    power = int(np.floor(np.log10(finest) + 1e-9))
    step = 10.0**power
    digits = max(-power, 0)
    first = float(np.round(low / step) * step)
    last = float(np.round(high / step) * step)
    step = float(step)
    return round(first, digits), round(last, digits), round(step, digits)


def on_step(value: float, step: float) -> float:
    """The nearest multiple of a power of ten that fits into a slider's number box."""
    return round(value, decimals(step))


def decimals(value: float) -> int:
    """Number of decimals in the shortest text of a number."""
    exponent = Decimal(repr(value)).normalize().as_tuple().exponent
    return max(-int(exponent), 0)


def round_value(value: float) -> float:
    """The nearest round number (1, 2 or 5 times a power of ten) to a positive value."""
    power = 10.0 ** np.floor(np.log10(value))

    def distance(factor: float) -> float:
        return float(abs(np.log(factor * power / value)))

    return float(power * min(ROUND, key=distance))


def round_above(value: float) -> float:
    """The smallest round number not below a positive value."""
    power = 10.0 ** np.floor(np.log10(value))
    least = value * (1.0 - 1e-9)
    candidates = [factor * power for factor in ROUND]
    return float(next(each for each in candidates if each >= least))
