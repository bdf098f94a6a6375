"""How far each active coordinate can be moved: its limits, or where the loops cease to close."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from ..description.model import Array
from ..errors import StateError
from ..robot import Robot
from ..state import ClosedState

STEPS: Final = 60  # to the end of a range that is looked for
TURN: Final = float(np.pi)  # [rad] either way, where nothing stops a revolute joint


def slider_ranges(robot: Robot, start: ClosedState, size: float) -> Array:
    """(n, 2) range of each active coordinate [rad or m]: `robot.limits`, else as far as the loops close from `start`.

    size: of the robot [m], which is how far an endless prismatic joint goes; a revolute one goes half a turn.
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
    """A range [rad or m] narrowed to round steps, at least 500 of them: lower end, upper end, step."""
    power = int(np.floor(np.log10(max(high - low, 1e-9) / 500.0)))
    step, digits = 10.0**power, max(-power, 0)
    first, last = np.ceil(low / step - 1e-9), np.floor(high / step + 1e-9)
    return round(float(first * step), digits), round(float(last * step), digits), round(float(step), digits)


def on_step(value: float, step: float) -> float:
    """The nearest multiple of a power of ten, as a slider's number box has room for."""
    return round(value, max(round(-math.log10(step)), 0))


def round_value(value: float) -> float:
    """1, 2 or 5 times a power of ten, near a value above zero."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(power * min((1.0, 2.0, 5.0, 10.0), key=lambda k: abs(np.log(k * power / value))))
