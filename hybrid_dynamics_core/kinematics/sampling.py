"""Which active coordinates are sampled for a workspace."""

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

# of the end effector's distance from the base: how far a slide without limits is taken to go
SLIDE: Final = 0.1
LEAST_REACH: Final = 1e-3  # [m] that distance is never taken to be less

Ranges = Mapping[str, tuple[float, float]]


def sampled_ranges(
    robot: ClosedKinematics,
    ranges: Ranges | None,
    held: Mapping[str, float] | None = None,
) -> tuple[Array, tuple[str, ...]]:
    """Ranges to sample, within the limits.

    Without limits an angle goes one turn about the reference. A slide goes `SLIDE` of the end
    effector's distance from the base to either side.

    Args:
        robot: whose active coordinates are sampled.
        ranges: narrower ranges by name [rad, m]; the limits where there is none.
        held: values of coordinates that stay the same, by name [rad, m].

    Returns:
        Ranges (n, 2) [rad, m], of which those of held coordinates begin and end at their value.
        And the coordinates without limits, whose range was chosen here.

    Raises:
        InputError: a range is empty, infinite or outside of the limits; or a coordinate is not
            active, or its value is not finite.
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
    """The limits, and chosen ranges of coordinates that have none; those given stay as they are."""
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
    """Samples (count + denser, n) of ranges: even ones, then such that are denser at the ends.

    Reach changes fastest at the ends.

    Args:
        box: ranges (n, 2) [rad, m].
        count: samples that fill the ranges evenly.
        denser: samples that are denser at the ends.
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
    """Samples (M count, n) about each of the centres (M, n), within ranges.

    Samples that leave the ranges are brought back: every other one onto the edge, which may bound
    the workspace, the others mirrored at it, to look for bounds inside, such as toggle points.

    Args:
        centres: active coordinates (M, n) [rad, m].
        box: ranges (n, 2) [rad, m].
        width: of the neighbourhood, as a share of the ranges.
        count: samples about each centre.
        seed: of the random numbers.
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
