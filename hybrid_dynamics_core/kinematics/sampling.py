"""Sampling of active coordinates for a workspace."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

import numpy as np

from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arguments import real_number, require_type
from ..ground.check_arrays import real_array
from ..ground.suggestions import suggestion
from ..ground.units import coordinate_unit
from .closed_kinematics import ClosedKinematics

# range of a slide without limits, as a share of the end effector's distance from the base
SLIDE: Final = 0.1
LEAST_REACH: Final = 1e-3  # [m] least value of that distance

Ranges = Mapping[str, tuple[float, float]]


def sampled_ranges(
    robot: ClosedKinematics,
    ranges: Ranges | None,
    held: Mapping[str, float] | None = None,
) -> tuple[Array, tuple[str, ...]]:
    """Ranges to sample, within the limits.

    An angle without limits is sampled over one turn about the reference. A slide without limits is
    sampled over `SLIDE` times the end effector's distance from the base, to either side.

    Args:
        robot: the robot.
        ranges: narrower ranges by name [rad, m]; by default the limits.
        held: constant coordinates by name [rad, m].

    Returns:
        Ranges (n, 2) [rad, m], with equal ends for constant coordinates; and the names of
        coordinates without limits, whose range was chosen here.

    Raises:
        InputError: a range is empty, infinite or outside of the limits, a coordinate is not active,
            or a value is not finite.
    """
    if ranges is not None:
        require_type("ranges", ranges, Mapping, "{'q1': (0.0, 1.0)}")
    if held is not None:
        require_type("held", held, Mapping, "{'q1': 0.5}")
    ranges = ranges or {}
    held = held or {}
    box, assumed = _limited_ranges(robot, {*ranges, *held})
    for name, limits in ranges.items():
        _check_active(robot, "range", name)
        ends = real_array(f"range of {name}", limits)
        if ends.shape != (2,):
            raise InputError(f"range: {name} is {limits}; expected (lower, upper)")
        lower, upper = ends.tolist()
        _check_range(robot, name, (lower, upper))
        box[robot.active.index(name)] = ends
    for name, value in held.items():
        _check_active(robot, "held", name)
        if name in ranges:
            raise InputError(f"held: {name} has a range too; leave one out")
        if not math.isfinite(real_number(f"held: {name}", value)):
            raise InputError(f"held: {name} is {value}; expected a finite number")
        box[robot.active.index(name)] = value
    return box, tuple(assumed)


def _limited_ranges(robot: ClosedKinematics, given: set[str]) -> tuple[Array, list[str]]:
    """The limits, and the names of coordinates without limits, for which ranges are chosen."""
    box = robot.limits.copy()
    assumed = []
    tip = robot.forward_kinematics(robot.close(robot.reference)).position
    slide = SLIDE * max(float(np.linalg.norm(tip)), LEAST_REACH)
    for k, name in enumerate(robot.active):
        if name in given or np.isfinite(box[k]).all():
            continue
        assumed.append(name)
        reach = math.pi if robot.joint_types[name] == "revolute" else slide
        chosen = robot.reference[k] + np.array([-reach, reach])
        unlimited = ~np.isfinite(box[k])
        box[k, unlimited] = chosen[unlimited]
    return box, assumed


def _check_active(robot: ClosedKinematics, label: str, name: str) -> None:
    if name not in robot.active:
        hint = suggestion(name, robot.active)
        active = ", ".join(robot.active)
        raise InputError(f"{label}: '{name}' is not an active joint{hint}; they are {active}")


def _check_range(
    robot: ClosedKinematics,
    name: str,
    limits: tuple[float, float],
) -> None:
    low, high = limits
    lower, upper = robot.limits[robot.active.index(name)]
    finite = math.isfinite(low) and math.isfinite(high)
    if not (finite and lower <= low < high <= upper):
        unit = coordinate_unit(robot.joint_types[name])
        raise InputError(
            f"range: {name} from {low:.6g} to {high:.6g} {unit}; expected two rising numbers"
            f" within its limits [{lower:.6g}, {upper:.6g}] {unit}"
        )


def halton_samples(box: Array, count: int, denser: int) -> Array:
    """Samples (count + denser, n) of ranges: evenly distributed ones, then some denser at the ends.

    Extremes of the workspace are often at the ends.

    Args:
        box: ranges (n, 2) [rad, m].
        count: number of evenly distributed samples.
        denser: number of samples that are denser at the ends.
    """
    from scipy.stats import qmc  # noqa: PLC0415  slow to import

    total = count + denser
    sampler = qmc.Halton(len(box), scramble=False)
    # the first point is a corner
    points = sampler.random(total + 1)[1:]
    angles = math.pi * points[count:]
    points[count:] = 0.5 - 0.5 * np.cos(angles)
    widths = np.ptp(box, axis=1)
    samples: Array = box[:, 0] + points * widths
    return samples


def samples_about(
    centres: Array,
    box: Array,
    width: float,
    count: int,
    seed: int,
) -> Array:
    """Samples (M count, n) around centres (M, n), within ranges.

    Of samples outside the ranges, every second one is moved to the edge, where the workspace may
    end. The others are mirrored at the edge, to find bounds inside, such as toggle points.

    Args:
        centres: active coordinates (M, n) [rad, m].
        box: ranges (n, 2) [rad, m].
        width: width of the neighbourhood, as a share of the ranges.
        count: number of samples around each centre.
        seed: seed of the random numbers.
    """
    n = len(box)
    rng = np.random.default_rng(seed)
    moves = rng.uniform(-1.0, 1.0, (len(centres), count, n))
    steps = width * moves * np.ptp(box, axis=1)
    moved = centres[:, None] + steps
    samples: Array = moved.reshape(-1, n)
    low, high = box.T
    from_low = np.where(samples < low, 2.0 * low - samples, samples)
    reflected = np.where(samples > high, 2.0 * high - samples, from_low)
    samples[::2] = np.clip(samples[::2], low, high)
    samples[1::2] = reflected[1::2]
    return samples
