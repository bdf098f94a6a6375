"""Where a frame can be, and how near to singular places and limits the robot is there."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..closed_state.state import ClosedState, ClosureStatus
from ..ground.arrays import Array
from ..ground.check_arguments import integer
from ..ground.progress import Progress
from .closed_kinematics import ClosedKinematics
from .sampling import Ranges, halton_samples, sampled_ranges, samples_about

COUNT: Final = 100_000
_BATCH: Final = 5_000  # samples that are closed at once
# The search for the extremes goes on in rounds, about the best samples so far. Its first
# neighbourhood is that share of the ranges, and each next one that share of the one before.
_ROUNDS: Final = 26
_WIDTH: Final = 0.1
_SHRINK: Final = 0.68
_TRIALS: Final = 60


class SampleStatus(IntEnum):
    """What became of a sample; the first three are those of `ClosureStatus`."""

    OK = ClosureStatus.OK
    OPEN = ClosureStatus.UNREACHABLE  # some loop does not close
    SINGULAR = ClosureStatus.SINGULAR
    BEYOND = 3  # closed, but a joint is beyond its limits or a cylinder beyond its stroke


@dataclass(frozen=True, eq=False)
class Margins:
    """N samples of the active coordinates, and how near to singular places and limits they are.

    Attributes:
        u: (N, n) active coordinates [rad or m].
        status: (N,) SampleStatus.
        position: (N, 3) of the frame, base axes [m]; NaN where a loop is open.
        singularity: (N,) distance of the nearest loop to its singularity as in `ClosedState`, 1 at
            best.
        loop: (N,) index of that loop in `robot.loops`, -1 where there is none.
        limit: (N,) how far the joint nearest to one of its limits is from it, as a share of half
            its range: 1 in the middle, 0 at the limit, negative beyond; infinite where no joint has
            two limits.
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
        columns = [getattr(self, name)[:count] for name in _COLUMNS]
        return Margins(*columns)

    @property
    def reachable(self) -> NDArray[np.bool_]:
        """(N,) whether the loops close with all joints within their limits."""
        return np.asarray(self.status == SampleStatus.OK)


_COLUMNS: Final = tuple(Margins.__annotations__)


@dataclass(frozen=True, eq=False)
class Workspace:
    """The workspace of a frame, by samples.

    Attributes:
        frame: whose positions they are.
        ranges: (n, 2) of the active coordinates that were sampled [rad or m]; both ends alike where
            one was held.
        assumed: active coordinates without limits, whose range was chosen here.
        samples: `count` samples that fill the ranges evenly, then half as many that are denser
            towards their ends, then those of the search for the extremes.
        count: how many fill the ranges evenly.
        spread: how many there are before those of the search.
    """

    frame: str
    ranges: Array
    assumed: tuple[str, ...]
    samples: Margins
    count: int
    spread: int

    @property
    def even(self) -> Margins:
        """The samples that fill the ranges evenly."""
        return self.samples.first(self.count)

    @property
    def extents(self) -> Array:
        """(3, 2) smallest and largest x, y and z of reachable samples, base axes [m]; NaN if none.

        The workspace itself is a little larger: by about 1e-3 of its size, and 1e-2 where it ends
        at a toggle point.
        """
        extremes = self.extremes
        if extremes is None:
            return np.full((3, 2), np.nan)
        axes = np.arange(3)[:, None]
        return self.samples.position[extremes, axes]

    @property
    def extremes(self) -> NDArray[np.int64] | None:
        """(3, 2) indices of the reachable samples with smallest and largest x, y and z."""
        rows = np.flatnonzero(self.samples.reachable)
        if not len(rows):
            return None
        positions = self.samples.position[rows]
        first, last = positions.argmin(axis=0), positions.argmax(axis=0)
        ends = np.stack([first, last], axis=1)
        return np.asarray(rows[ends], dtype=np.int64)

    def share(self, status: SampleStatus = SampleStatus.OK) -> float:
        """The share of the evenly distributed samples of which this became."""
        return float((self.even.status == status).mean())

    def share_below(self, singularity: float) -> float:
        """The share of even reachable samples nearer to a singularity than this; NaN if none."""
        near = self.even.singularity[self.even.reachable]
        if not len(near):
            return math.nan
        return float((near < singularity).mean())

    @property
    def nearest(self) -> int | None:
        """Index of the reachable sample nearest to a singularity."""
        reachable = self.samples.reachable
        if not reachable.any():
            return None
        singularity = np.where(reachable, self.samples.singularity, np.inf)
        return int(np.argmin(singularity))


def find_workspace(
    robot: ClosedKinematics,
    count: int = COUNT,
    frame: str | None = None,
    ranges: Ranges | None = None,
    shown: bool | None = None,
    held: Mapping[str, float] | None = None,
) -> Workspace:
    """Where a frame can be.

    Args:
        robot: whose workspace it is.
        count: samples that fill the ranges evenly.
        frame: name of a frame or link; the end effector if None.
        ranges: ranges narrower than the limits, by name [rad, m].
        shown: whether to show progress; on a terminal, if it takes long, if None.
        held: values of coordinates that stay the same, by name [rad, m].

    Raises:
        InputError: count is below 1, or ranges or held coordinates cannot be used.
    """
    count = integer("count", count)
    box, assumed = sampled_ranges(robot, ranges, held)
    u = halton_samples(box, count, denser=count // 2)
    starts = range(0, len(u), _BATCH)
    parts: list[Margins] = []
    with Progress(f"workspace of {robot.name}", len(starts) + _ROUNDS, shown) as progress:
        for start in starts:
            parts.append(margins_at(robot, u[start : start + _BATCH], frame))
            progress.update(len(parts))
        samples = join_margins(parts)
        for k in range(_ROUNDS):
            best = _best_samples(samples)
            if not len(best):
                break
            width = _WIDTH * _SHRINK**k
            trials = samples_about(samples.u[best], box, width, _TRIALS, seed=k)
            samples = join_margins([samples, margins_at(robot, trials, frame)])
            progress.update(len(parts) + k + 1)
    name = frame or robot.end_effector
    return Workspace(name, box, assumed, samples, count, spread=len(u))


def margins_at(
    robot: ClosedKinematics,
    u: Array,
    frame: str | None = None,
) -> Margins:
    """Close a batch, and say what became of every sample. A sample that does not close is no error.

    Args:
        robot: whose loops are closed.
        u: active coordinates (N, n) [rad, m].
        frame: name of a frame or link; the end effector if None.
    """
    state = robot.close(u, check=False)
    limit, joint = _limit_margins(robot, state)
    status = np.array(state.status, dtype=np.int64)
    status[(status == SampleStatus.OK) & (limit < 0.0)] = SampleStatus.BEYOND
    loop = np.full(len(u), -1, dtype=np.int64)
    if robot.loops:
        distances = np.nan_to_num(state.distances, nan=np.inf)
        loop = np.argmin(distances, axis=1).astype(np.int64)
    return Margins(
        u=u,
        status=status,
        position=robot.forward_kinematics(state, frame).position,
        singularity=np.asarray(state.singularity),
        loop=loop,
        limit=limit,
        joint=joint,
    )


def join_margins(parts: Sequence[Margins]) -> Margins:
    """One after the other."""
    columns = {}
    for name in _COLUMNS:
        column = [getattr(part, name) for part in parts]
        columns[name] = np.concatenate(column)
    return Margins(**columns)


def limited_joints(robot: ClosedKinematics) -> dict[str, tuple[float, float]]:
    """Limits of the joints that have two, narrowed by the strokes of their cylinders [rad, m].

    They may be active or passive.
    """
    joints = {}
    for name in robot.coordinates:
        lower, upper = robot.description.joints[name].limits
        if name in robot.cylinders:
            shortest, longest = robot.cylinders[name].stroke
            lower, upper = max(lower, shortest), min(upper, longest)
        if math.isfinite(lower) and math.isfinite(upper) and lower < upper:
            joints[name] = (lower, upper)
    return joints


def _limit_margins(robot: ClosedKinematics, state: ClosedState) -> tuple[Array, NDArray[np.int64]]:
    """Distance to the nearest limit (N,), and the index (N,) of its joint, as in `Margins`."""
    rows = len(state.u)
    limits = limited_joints(robot)
    if not limits:
        no_joint = np.full(rows, -1, dtype=np.int64)
        return np.full(rows, np.inf), no_joint
    columns = np.array([robot.coordinates.index(name) for name in limits])
    lower, upper = np.array(list(limits.values())).T
    values = state.s[:, columns]
    half_range = 0.5 * (upper - lower)
    margins = np.minimum(values - lower, upper - values) / half_range
    nearest = np.argmin(np.nan_to_num(margins, nan=np.inf), axis=1)
    joints = columns[nearest].astype(np.int64)
    return margins[np.arange(rows), nearest], joints


def _best_samples(samples: Margins) -> NDArray[np.int64]:
    """Reachable samples with the largest and smallest x, y, z and the smallest singularity."""
    rows = np.flatnonzero(samples.reachable)
    if not len(rows):
        return rows
    position, singularity = samples.position[rows], samples.singularity[rows]
    goals = np.column_stack([position, -position, singularity])
    return np.unique(rows[np.argmin(goals, axis=0)])
