"""Workspace of a frame by samples, with distances to singularities and limits."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..closed_state.state import ClosedState, ClosureStatus
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arguments import integer
from ..ground.progress import Progress
from .closed_kinematics import ClosedKinematics
from .sampling import Ranges, halton_samples, sampled_ranges, samples_about

COUNT: Final = 100_000
_BATCH: Final = 5_000  # samples closed at once
# The search for extremes samples around the best samples in rounds. The first neighbourhood is
# _WIDTH, a share of the ranges. Each next one is _SHRINK times the previous one.
_ROUNDS: Final = 26
_WIDTH: Final = 0.1
_SHRINK: Final = 0.68
_TRIALS: Final = 60


class SampleStatus(IntEnum):
    """Status of a sample; the first three values are those of `ClosureStatus`."""

    OK = ClosureStatus.OK
    OPEN = ClosureStatus.UNREACHABLE  # some loop does not close
    SINGULAR = ClosureStatus.SINGULAR
    BEYOND = 3  # closed, but a joint is beyond its limits or a cylinder beyond its stroke


@dataclass(frozen=True, eq=False)
class Margins:
    """N samples of active coordinates, with their distances to singularities and limits.

    Attributes:
        u: (N, n) active coordinates [rad or m].
        status: (N,) SampleStatus.
        position: (N, 3) of the frame, base axes [m]; NaN where a loop is open.
        singularity: (N,) distance of the nearest loop to its singularity, as in `ClosedState`; 1 at
            best.
        loop: (N,) index of that loop in `robot.loops`; -1 without loops.
        limit: (N,) least distance of a joint to its limits, as a share of half its range: 1 in the
            middle, 0 at the limit, negative beyond; infinite if no joint has two limits.
        joint: (N,) index of that joint in `robot.coordinates`; -1 if there is none.
    """

    u: Array
    status: NDArray[np.int64]
    position: Array
    singularity: Array
    loop: NDArray[np.int64]
    limit: Array
    joint: NDArray[np.int64]

    def first(self, count: int) -> Margins:
        """The first `count` samples."""
        columns = [getattr(self, name)[:count] for name in _COLUMNS]
        return Margins(*columns)

    @property
    def reachable(self) -> NDArray[np.bool_]:
        """Mask (N,) of samples that close with all joints within limits."""
        return np.asarray(self.status == SampleStatus.OK)


_COLUMNS: Final = tuple(Margins.__annotations__)


@dataclass(frozen=True, eq=False)
class Workspace:
    """The workspace of a frame, by samples.

    Attributes:
        frame: name of the frame.
        ranges: (n, 2) sampled ranges of the active coordinates [rad or m]; equal ends for constant
            ones.
        assumed: names of coordinates without limits, whose range was chosen here.
        samples: `count` evenly distributed samples, then half as many that are denser at the ends
            of the ranges, then those of the search for extremes.
        count: number of evenly distributed samples.
        spread: number of samples before those of the search.
    """

    frame: str
    ranges: Array
    assumed: tuple[str, ...]
    samples: Margins
    count: int
    spread: int

    @property
    def even(self) -> Margins:
        """The evenly distributed samples."""
        return self.samples.first(self.count)

    @property
    def extents(self) -> Array:
        """(3, 2) bounding box of reachable samples, base axes [m]; NaN if there are none.

        The workspace itself is larger by about 1e-3 of its size, and by 1e-2 where it ends at a
        toggle point.
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
        """The share of evenly distributed samples with a status."""
        return float((self.even.status == status).mean())

    def share_below(self, singularity: float) -> float:
        """The share of evenly distributed reachable samples below a distance to singularities."""
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
    held: Mapping[str, float] | None = None,
    shown: bool | None = None,
) -> Workspace:
    """The workspace of a frame by samples, with distances to singularities and limits.

    Further samples are taken near the ends of ranges and near the extremes. The `status` of a
    sample says whether it closes. Runs of more than a second show their progress on a terminal.

    Args:
        robot: the robot.
        count: number of samples that are evenly distributed over the active coordinates within
            `limits`.
        frame: name in `frames`; the end effector if None.
        ranges: narrower ranges by name [rad, m].
        held: constant coordinates by name [rad, m].
        shown: whether to show progress; None: on terminals, for long runs.

    Returns:
        The samples.

    Raises:
        InputError: count is below 1, nothing moves, a range is empty or outside of the limits, or
            a constant coordinate is not active, not finite, or has a range too.
    """
    count = integer("count", count)
    if not robot.active:
        raise InputError(f"{robot.name} has no joint that moves, so it has no workspace")
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
    """Close a batch of samples, and compute their margins; samples that do not close are no error.

    Args:
        robot: the robot.
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
    """Concatenate margins."""
    columns = {}
    for name in _COLUMNS:
        column = [getattr(part, name) for part in parts]
        columns[name] = np.concatenate(column)
    return Margins(**columns)


def limited_joints(robot: ClosedKinematics) -> dict[str, tuple[float, float]]:
    """Limits of all joints that have two [rad, m], narrowed by the strokes of their cylinders.

    The joints may be active or passive.
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
    """Indices of reachable samples with extreme x, y, z, and with the smallest singularity."""
    rows = np.flatnonzero(samples.reachable)
    if not len(rows):
        return rows
    position, singularity = samples.position[rows], samples.singularity[rows]
    goals = np.column_stack([position, -position, singularity])
    return np.unique(rows[np.argmin(goals, axis=0)])
