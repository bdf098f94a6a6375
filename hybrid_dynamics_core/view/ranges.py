"""How far each active coordinate can be moved: its limits, or where the loops cease to close."""

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

FINE: Final = 1000  # steps of a slider, at least
STEPS: Final = 60  # to the end of a range that is looked for
HALF_TURN: Final = float(np.pi)  # [rad] either way, where nothing stops a revolute joint
ROUND: Final = (1.0, 2.0, 5.0, 10.0)  # times a power of ten


@dataclass(frozen=True)
class Range:
    """From where to where a quantity can be moved.

    Attributes:
        name: of the quantity.
        unit: of the numbers.
        low: the lower end.
        high: the upper end.
        limits: those of the robot's file.
    """

    name: str
    unit: str
    low: float
    high: float
    limits: tuple[float, float] = (-math.inf, math.inf)

    def take(self, wanted: float, slack: float) -> float:
        """A value within the range.

        Args:
            wanted: by a person.
            slack: what is beyond an end by no more than this, or by rounding, is that end.

        Returns:
            The value.

        Raises:
            InputError: with the end, and with what the number would be in degrees where that lies
                within.
        """
        if self.low - 1.01 * slack <= wanted <= self.high + 1.01 * slack:
            return self._snapped(wanted, slack)
        raise InputError(
            f"{self.name} = {wanted:.6g} {self.unit} is beyond {self._end(wanted)} {self.unit}; "
            f"it goes from {self.low:.6g} to {self.high:.6g} {self.unit}{self._in_degrees(wanted)}"
        )

    def _snapped(self, value: float, slack: float) -> float:
        """The end that a value is near to, else the value."""
        if value - self.low < slack:
            return self.low
        if self.high - value < slack:
            return self.high
        return value

    def _end(self, wanted: float) -> str:
        """The end that a value is beyond, in words."""
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
    """The range of each active coordinate: its limits, else as far as the loops close.

    Args:
        robot: that is moved.
        start: the state from which ends are looked for.
        size: of the robot [m]: how far an endless prismatic joint goes. A revolute one goes half a
            turn.

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
    """The last value of a coordinate on the way at which all loops close."""
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
    """A range on round steps, at least 1000 of them, as a slider shows it.

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
    """The nearest multiple of a power of ten, as a slider's number box has room for."""
    return round(value, decimals(step))


def decimals(value: float) -> int:
    """Decimals of a number as it is written shortest."""
    exponent = Decimal(repr(value)).normalize().as_tuple().exponent
    return max(-int(exponent), 0)


def round_value(value: float) -> float:
    """1, 2 or 5 times a power of ten, near a value above zero."""
    power = 10.0 ** np.floor(np.log10(value))

    def distance(factor: float) -> float:
        return float(abs(np.log(factor * power / value)))

    return float(power * min(ROUND, key=distance))


def round_above(value: float) -> float:
    """1, 2 or 5 times a power of ten, the smallest that is not below a value above zero."""
    power = 10.0 ** np.floor(np.log10(value))
    least = value * (1.0 - 1e-9)
    candidates = [factor * power for factor in ROUND]
    return float(next(each for each in candidates if each >= least))
