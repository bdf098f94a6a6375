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
TURN: Final = float(np.pi)  # [rad] either way, where nothing stops a revolute joint


@dataclass(frozen=True)
class Range:
    """From where to where a quantity can be moved [unit]; `limits`: those of the robot's file."""

    name: str
    unit: str
    low: float
    high: float
    limits: tuple[float, float] = (-math.inf, math.inf)

    def take(self, wished: float, slack: float) -> float:
        """A wish within the range; what is beyond an end by no more than `slack`, or by rounding, is that end.

        Raises InputError with the end, and with what the number would be in degrees where that lies
        within.
        """
        if self.low - 1.01 * slack <= wished <= self.high + 1.01 * slack:
            near_low, near_high = wished - self.low < slack, self.high - wished < slack
            return self.low if near_low else self.high if near_high else wished
        end, limit = (
            (self.low, self.limits[0]) if wished < self.low else (self.high, self.limits[1])
        )
        what = "its limit" if math.isclose(end, limit, abs_tol=1e-12) else "the end of its slider,"
        raise InputError(
            f"{self.name} = {wished:.6g} {self.unit} is beyond {what} {end:.6g} {self.unit}; "
            f"it goes from {self.low:.6g} to {self.high:.6g} {self.unit}{self._in_degrees(wished)}"
        )

    def _in_degrees(self, wished: float) -> str:
        if self.unit != "rad":
            return ""
        low, high = (math.degrees(end) for end in (self.low, self.high))
        told = f" ({low:.4g} to {high:.4g} deg)"
        if low <= wished <= high:
            told += f". The box takes rad: {wished:.6g} deg are {math.radians(wished):.5g} rad"
        return told


def slider_ranges(robot: Robot, start: ClosedState, size: float) -> Array:
    """(n, 2) range of each active coordinate [rad or m]: `robot.limits`, else as far as the loops close from `start`.

    size: of the robot [m], which is how far an endless prismatic joint goes; a revolute one goes
    half a turn.
    """
    ranges = np.array(robot.limits)
    for k, name in enumerate(robot.active):
        reach = TURN if robot.joint_types[name] == "revolute" else size
        for side, way in ((0, -reach), (1, reach)):
            if not np.isfinite(ranges[k, side]):
                ranges[k, side] = _end(robot, start, k, way)
    low, high = np.minimum(ranges[:, 0], start.u), np.maximum(ranges[:, 1], start.u)
    return np.stack([low, high], axis=1)


def _end(robot: Robot, start: ClosedState, k: int, way: float) -> float:
    """The last value on the way at which all loops close."""
    path = np.tile(start.u, (STEPS, 1))
    path[:, k] += way * np.arange(1, STEPS + 1) / STEPS
    try:
        robot.close_path(path, near=start)
    except StateError as error:
        closed = 0 if error.index is None else error.index
        return float(path[closed - 1, k] if closed else start.u[k])
    return float(path[-1, k])


def on_round_steps(low: float, high: float) -> tuple[float, float, float]:
    """A range brought onto round steps, at least 1000 of them: lower end, upper end, step, as a slider shows them."""
    power = int(np.floor(np.log10(max(high - low, 1e-9) / FINE) + 1e-9))
    step, digits = 10.0**power, max(-power, 0)
    first, last = np.round(low / step), np.round(high / step)
    return (
        round(float(first * step), digits),
        round(float(last * step), digits),
        round(float(step), digits),
    )


def on_step(value: float, step: float) -> float:
    """The nearest multiple of a power of ten, as a slider's number box has room for."""
    return round(value, decimals(step))


def decimals(value: float) -> int:
    """Decimals of a number as it is written shortest."""
    return max(-int(Decimal(repr(value)).normalize().as_tuple().exponent), 0)


def round_value(value: float) -> float:
    """1, 2 or 5 times a power of ten, near a value above zero."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(power * min((1.0, 2.0, 5.0, 10.0), key=lambda k: abs(np.log(k * power / value))))


def round_above(value: float) -> float:
    """1, 2 or 5 times a power of ten, the smallest that is not below a value above zero."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(
        next(k * power for k in (1.0, 2.0, 5.0, 10.0) if k * power >= value * (1.0 - 1e-9))
    )
