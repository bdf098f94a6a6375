"""Where the end effector can be, and how near to singular places, limits and stroke ends the robot is there."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..closed_state.state import ClosedState, ClosureStatus
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.progress import Progress
from ..ground.suggestions import suggestion
from ..ground.units import coordinate_unit
from .closed_kinematics import ClosedKinematics

COUNT: Final = 100_000
# of the end effector's distance from the base: how far a slide without limits is taken to go
SLIDE: Final = 0.1
_AT_ONCE: Final = 5_000  # samples in a batch
_ROUNDS, _SHRINK, _TRIALS = (
    26,
    0.68,
    60,
)  # of the search for the extremes, about the best sample so far
_WIDTH: Final = 0.1  # of the ranges: where that search begins


class SampleStatus(IntEnum):
    """What became of a sample; the first three are those of `ClosureStatus`."""

    OK = ClosureStatus.OK
    OPEN = ClosureStatus.UNREACHABLE  # some loop does not close
    SINGULAR = ClosureStatus.SINGULAR
    BEYOND = 3  # closed, but a joint is beyond its limits or a cylinder beyond its stroke


@dataclass(frozen=True, eq=False)
class Margins:
    """What is known of N samples of the active coordinates.

    Attributes:
        u: (N, n) active coordinates [rad or m].
        status: (N,) SampleStatus.
        position: (N, 3) of the frame, base axes [m]; NaN where a loop is open.
        singularity: (N,) distance of the nearest loop to its singularity as in `ClosedState`, 1 at
        best.
        loop: (N,) index of that loop in `robot.loops`, -1 where there is none.
        limit: (N,) how far the joint nearest to one of its limits is from it, as a share of half
        its range: 1 in the
            middle, 0 at the limit, negative beyond; infinite where no joint has two limits.
        joint: (N,) index of that joint in `robot.coordinates`, -1 where there is none.
    """

    u: Array
    status: NDArray[np.int64]
    position: Array
    singularity: Array
    loop: NDArray[np.int64]
    limit: Array
    joint: NDArray[np.int64]

    def first(self, count: int) -> Margins:
        """The first samples alone."""
        return Margins(*(getattr(self, name)[:count] for name in Margins.__annotations__))

    @property
    def reachable(self) -> NDArray[np.bool_]:
        """(N,) whether the loops close with all joints within their limits."""
        return np.asarray(self.status == SampleStatus.OK)


@dataclass(frozen=True, eq=False)
class Workspace:
    """The workspace of a frame, by samples.

    Attributes:
        frame: whose positions they are.
        ranges: (n, 2) of the active coordinates that were sampled [rad or m]; both ends alike where
        one was held.
        assumed: active coordinates without limits, whose range was chosen here.
        samples: `count` samples spread evenly over the ranges, then half as many that are denser
        towards their ends,
            then those of the search for the extremes.
        count: how many are spread evenly; spread: how many there are before those of the search.
    """

    frame: str
    ranges: Array
    assumed: tuple[str, ...]
    samples: Margins
    count: int
    spread: int

    @property
    def even(self) -> Margins:
        """The evenly spread samples."""
        return self.samples.first(self.count)

    @property
    def extents(self) -> Array:
        """(3, 2) smallest and largest x, y and z of reachable samples, base axes [m]; NaN where there are none.

        The workspace itself is a little larger: by about 1e-3 of its size, and 1e-2 where it ends
        at a toggle point.
        """
        at = self.extremes
        return (
            np.full((3, 2), np.nan)
            if at is None
            else self.samples.position[at, np.arange(3)[:, None]]
        )

    @property
    def extremes(self) -> NDArray[np.int64] | None:
        """(3, 2) indices of the reachable samples with smallest and largest x, y and z."""
        rows = np.flatnonzero(self.samples.reachable)
        if not len(rows):
            return None
        places = self.samples.position[rows]
        return np.asarray(
            rows[np.stack([places.argmin(axis=0), places.argmax(axis=0)], axis=1)], dtype=np.int64
        )

    def share(self, status: SampleStatus = SampleStatus.OK) -> float:
        """The share of the evenly spread samples of which this became."""
        return float((self.even.status == status).mean())

    def share_below(self, singularity: float) -> float:
        """The share of the evenly spread reachable samples that are nearer than this to a singularity; NaN of none."""
        near = self.even.singularity[self.even.reachable]
        return float((near < singularity).mean()) if len(near) else math.nan

    @property
    def nearest(self) -> int | None:
        """Index of the reachable sample nearest to a singularity."""
        if not self.samples.reachable.any():
            return None
        return int(np.argmin(np.where(self.samples.reachable, self.samples.singularity, np.inf)))


def margins_at(robot: ClosedKinematics, u: Array, frame: str | None = None) -> Margins:
    """Close a batch u (N, n) and tell what became of every sample; nothing is raised for those that do not close."""
    state = robot.close(u, check=False)
    limit, joint = _limit_margins(robot, state)
    status = np.array(state.status, dtype=np.int64)
    status[(status == SampleStatus.OK) & (limit < 0.0)] = SampleStatus.BEYOND
    loop = np.full(len(u), -1, dtype=np.int64)
    if robot.loops:
        loop = np.argmin(np.nan_to_num(state.distances, nan=np.inf), axis=1).astype(np.int64)
    position = robot.forward_kinematics(state, frame).position
    return Margins(u, status, position, np.asarray(state.singularity), loop, limit, joint)


def find_workspace(
    robot: ClosedKinematics,
    count: int = COUNT,
    frame: str | None = None,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    shown: bool | None = None,
    held: Mapping[str, float] | None = None,
) -> Workspace:
    """See `Robot.workspace`."""
    if count < 1:
        raise InputError(f"count is {count}; expected 1 sample or more")
    box, assumed = sampled_ranges(robot, ranges, held)
    from scipy.stats import qmc  # noqa: PLC0415  slow to import

    spread = count + count // 2
    points = qmc.Halton(len(robot.active), scramble=False).random(spread + 1)[
        1:
    ]  # the first one is a corner
    points[count:] = 0.5 - 0.5 * np.cos(
        math.pi * points[count:]
    )  # denser at the ends, where reach changes fastest
    u = box[:, 0] + points * np.ptp(box, axis=1)
    rounds = range(0, spread, _AT_ONCE)
    parts: list[Margins] = []
    with Progress(f"workspace of {robot.name}", len(rounds) + _ROUNDS, shown) as progress:
        for start in rounds:
            parts.append(margins_at(robot, u[start : start + _AT_ONCE], frame))
            progress.update(len(parts))
        samples = joined(parts)
        for k in range(_ROUNDS):
            around = _about_extremes(samples, box, _WIDTH * _SHRINK**k, k)
            if not len(around):
                break
            samples = joined([samples, margins_at(robot, around, frame)])
            progress.update(len(parts) + k + 1)
    return Workspace(frame or robot.end_effector, box, assumed, samples, count, spread)


def sampled_ranges(
    robot: ClosedKinematics,
    told: Mapping[str, tuple[float, float]] | None,
    held: Mapping[str, float] | None = None,
) -> tuple[Array, tuple[str, ...]]:
    """(n, 2) ranges to sample, within `limits`: those told, else the limits; and whose had to be chosen.

    Those that are `held` begin and end at their value.

    Without limits an angle goes one turn about the reference, a slide `SLIDE` of the end effector's
    distance from the base to either side. Raises InputError for ranges that are empty, infinite or
    outside of the limits.
    """
    told = told or {}
    settled = {*told, *(held or {})}
    box, assumed = robot.limits.copy(), []
    distance = float(
        np.linalg.norm(robot.forward_kinematics(robot.close(robot.reference)).position)
    )
    for k, name in enumerate(robot.active):
        if name in settled:
            continue
        reach = math.pi if robot.joint_types[name] == "revolute" else SLIDE * max(distance, 1e-3)
        chosen = robot.reference[k] + np.array([-reach, reach])
        if not np.isfinite(box[k]).all():
            assumed.append(name)
            box[k] = np.where(np.isfinite(box[k]), box[k], chosen)
    for name, (low, high) in told.items():
        if name not in robot.active:
            hint = suggestion(name, robot.active)
            raise InputError(
                f"range: '{name}' is not an active joint{hint}; they are {', '.join(robot.active)}"
            )
        lower, upper = robot.limits[robot.active.index(name)]
        if not (math.isfinite(low) and math.isfinite(high) and lower <= low < high <= upper):
            kind = coordinate_unit(robot.joint_types[name])
            raise InputError(
                f"range: {name} from {low:.6g} to {high:.6g} {kind}; expected two rising numbers"
                f" within its limits [{lower:.6g}, {upper:.6g}] {kind}"
            )
        box[robot.active.index(name)] = low, high
    for name, value in _held(robot, told, held or {}).items():
        box[robot.active.index(name)] = value
    return box, tuple(assumed)


def _held(
    robot: ClosedKinematics, told: Mapping[str, tuple[float, float]], held: Mapping[str, float]
) -> Mapping[str, float]:
    """The same where they can be held, else an InputError."""
    for name, value in held.items():
        if name not in robot.active:
            hint = suggestion(name, robot.active)
            raise InputError(
                f"held: '{name}' is not an active joint{hint}; they are {', '.join(robot.active)}"
            )
        if name in told or not math.isfinite(value):
            problem = (
                "has a range too; leave one out"
                if name in told
                else f"is {value}; expected a finite number"
            )
            raise InputError(f"held: {name} {problem}")
    return held


def joined(parts: list[Margins]) -> Margins:
    """One after the other."""
    return Margins(
        *(
            np.concatenate([getattr(part, name) for part in parts])
            for name in Margins.__annotations__
        )
    )


def limited_joints(robot: ClosedKinematics) -> dict[str, tuple[float, float]]:
    """Joints with two limits, active or passive, narrowed by the strokes of their cylinders [rad or m]."""
    found = {}
    for name in robot.coordinates:
        lower, upper = robot.description.joints[name].limits
        if name in robot.cylinders:
            stroke = robot.cylinders[name].stroke
            lower, upper = max(lower, stroke[0]), min(upper, stroke[1])
        if math.isfinite(lower) and math.isfinite(upper) and lower < upper:
            found[name] = (lower, upper)
    return found


def _limit_margins(robot: ClosedKinematics, state: ClosedState) -> tuple[Array, NDArray[np.int64]]:
    limits = limited_joints(robot)
    if not limits:
        return np.full(len(state.u), np.inf), np.full(len(state.u), -1, dtype=np.int64)
    columns = np.array([robot.coordinates.index(name) for name in limits])
    lower, upper = np.array(list(limits.values())).T
    values = state.s[:, columns]
    left = np.minimum(values - lower, upper - values) / (0.5 * (upper - lower))
    nearest = np.argmin(np.nan_to_num(left, nan=np.inf), axis=1)
    return left[np.arange(len(left)), nearest], columns[nearest].astype(np.int64)


def _about_extremes(samples: Margins, box: Array, width: float, seed: int) -> Array:
    """Samples (M, n) about the reachable ones with the largest and smallest x, y, z and the smallest singularity."""
    rows = np.flatnonzero(samples.reachable)
    if not len(rows):
        return np.empty((0, samples.u.shape[1]))
    goals = np.column_stack(
        [samples.position[rows], -samples.position[rows], samples.singularity[rows]]
    )
    best = np.unique(rows[np.argmin(goals, axis=0)])
    rng = np.random.default_rng(seed)
    steps = width * rng.uniform(-1.0, 1.0, (len(best), _TRIALS, len(box))) * np.ptp(box, axis=1)
    low, high = box.T
    around: Array = (samples.u[best][:, None] + steps).reshape(-1, len(box))
    inward = np.where(
        around > high, 2.0 * high - around, np.where(around < low, 2.0 * low - around, around)
    )
    around[::2] = np.clip(around[::2], low, high)  # limits belong to the workspace,
    around[1::2] = inward[1::2]  # toggle points do not: half go onto the edge, half back from it
    return around
