"""Estimation of rates if only some joints or some messages have velocities.

If every message has velocities of all joints, or of none, one state of the estimator is enough.
Otherwise joints with the same history form a group with its own states. A joint that alternates
between both kinds has two states, one for each kind of sample. An estimator that accepts
alternating kinds needs no groups, as long as all joints of a message are of one kind.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeGuard

import numpy as np
from numpy.typing import NDArray

from ..messages.joint_samples import FloatArray
from .filter.filter import StampEvent, restart_between
from .filter.rate_estimator import Estimate, EstimatorState, MotionEstimator, RateRows

Mask = NDArray[np.bool_]


class Group(NamedTuple):
    """Joints with the same history.

    Attributes:
        joints: indices of the joints, ascending.
        of_velocities: the estimator's state after the newest sample with velocities, or None.
        of_positions: the estimator's state for samples without velocities, or None if not needed.
        bare_ns: stamp of the newest sample without velocities [ns].
    """

    joints: tuple[int, ...]
    of_velocities: EstimatorState | None
    of_positions: EstimatorState | None
    bare_ns: int


class Groups(NamedTuple):
    """All joints, in groups.

    Attributes:
        stamp_ns: stamp of the newest sample [ns].
        groups: groups, sorted by their first joint.
    """

    stamp_ns: int
    groups: tuple[Group, ...]


State = EstimatorState | Groups  # for all joints, or in groups


def stamp_of(state: State) -> int:
    """Stamp of the newest sample [ns]."""
    return state.stamp_ns if isinstance(state, Groups) else state.filter.stamp_ns


@dataclass(frozen=True)
class GroupedEstimator:
    """An estimator for joints whose velocities may be absent in some messages.

    Attributes:
        estimator: the underlying estimator.
    """

    estimator: MotionEstimator

    def step(
        self, state: State | None, stamp_ns: int, position: FloatArray, velocity: FloatArray | None
    ) -> tuple[State, Estimate]:
        """State and estimate after one more sample.

        Args:
            state: previous state, or None at the start; it is not changed.
            stamp_ns: stamp [ns].
            position: (n,) [rad or m].
            velocity: (n,) [rad/s or m/s], NaN where absent; None if absent for all joints.

        Raises:
            RejectedError: estimated rates are not finite.
        """
        if velocity is None or not math.isnan(sum(velocity.tolist())):
            measures_all = velocity is not None
            if self._goes_on(state, is_measured=measures_all):
                return self.estimator.step(state, stamp_ns, position, velocity)
            is_measured = np.full(len(position), measures_all)
        else:
            is_measured = ~np.isnan(velocity)
        event = None if state is None else self._restart(stamp_of(state), stamp_ns)
        if event is not None:
            return self._anew(event, stamp_ns, position, velocity)
        groups = _divided(_groups_of(state, len(position)), is_measured)
        return self._step_groups(groups, stamp_ns, position, velocity)

    def _anew(
        self, event: StampEvent, stamp_ns: int, position: FloatArray, velocity: FloatArray | None
    ) -> tuple[State, Estimate]:
        """State and estimate of the first sample after a restart."""
        state, estimate = self.step(None, stamp_ns, position, velocity)
        return state, estimate._replace(event=event)

    def run(
        self,
        state: State | None,
        stamps: NDArray[np.int64],
        position: FloatArray,
        velocity: FloatArray,
    ) -> RateRows:
        """Results of `step` for N consecutive samples.

        Args:
            state: previous state, or None at the start; it is not changed.
            stamps: (N,) [ns].
            position: (N, n) [rad or m].
            velocity: (N, n) [rad/s or m/s], NaN where absent.

        Raises:
            RejectedError: estimated rates are not finite.
        """
        count, n = position.shape
        rates = RateRows(
            velocity=np.zeros((count, n)),
            has_velocity=np.zeros(count, dtype=bool),
            acceleration=np.full((count, n), np.nan),
            has_acceleration=np.zeros(count, dtype=bool),
            events=Counter(),
            state=state,
        )
        is_measured = ~np.isnan(velocity)
        row = 0
        for end in _ends_of_runs(is_measured):
            while row < end:
                rows = slice(row, end)
                if not self._is_plain(rates.state, is_measured[row]):
                    rows = slice(row, row + 1)
                self._run(rates, rows, stamps[rows], position[rows], velocity[rows])
                row = rows.stop
        return rates

    def _run(
        self,
        rates: RateRows,
        rows: slice,
        stamps: NDArray[np.int64],
        position: FloatArray,
        velocity: FloatArray,
    ) -> None:
        """Set the rates of rows of one kind for all joints, or of one row.

        Args:
            rates: rates of all samples; its `state` is advanced over the rows.
            rows: the rows.
            stamps: (k,) of the rows [ns].
            position: (k, n) of the rows [rad or m].
            velocity: (k, n) of the rows [rad/s or m/s], NaN where absent.
        """
        is_measured = ~np.isnan(velocity)
        if self._is_plain(rates.state, is_measured[0]):
            part = self.estimator.run(rates.state, stamps, position, velocity, is_measured[:, 0])
            rates.velocity[rows], rates.has_velocity[rows] = part.velocity, part.has_velocity
            rates.acceleration[rows] = part.acceleration
            rates.has_acceleration[rows] = part.has_acceleration
            rates.events += part.events
            rates.state = part.state
            return
        given = velocity[0] if is_measured.any() else None
        rates.state, estimate = self.step(rates.state, int(stamps[0]), position[0], given)
        rates.events[estimate.event] += 1
        if estimate.velocity is not None:
            rates.velocity[rows] = estimate.velocity
            rates.has_velocity[rows] = True
        if estimate.acceleration is not None:
            rates.acceleration[rows] = estimate.acceleration
            rates.has_acceleration[rows] = True

    def _is_plain(self, state: State | None, is_measured: Mask) -> bool:
        """Whether one state suffices for a sample, by the mask (n,) of joints with velocity."""
        measures_all = bool(is_measured.all())
        if not measures_all and is_measured.any():
            return False
        return self._goes_on(state, is_measured=measures_all)

    def _goes_on(
        self, state: State | None, *, is_measured: bool
    ) -> TypeGuard[EstimatorState | None]:
        """Whether one state continues with a sample in which all joints have velocities, or none.

        It does if the samples before were of the same kind, or if the estimator accepts alternating
        kinds.
        """
        if state is None:
            return True
        if isinstance(state, Groups):
            return False
        return self.estimator.takes_turns or state.from_velocities == is_measured

    def _restart(self, before_ns: int, stamp_ns: int) -> StampEvent | None:
        """The event that restarts all groups at a stamp, or None."""
        return restart_between(before_ns, stamp_ns, self.estimator.max_gap)

    def _is_old(self, before_ns: int, stamp_ns: int) -> bool:
        return self._restart(before_ns, stamp_ns) is not None

    def _step_groups(
        self,
        groups: Sequence[Group],
        stamp_ns: int,
        position: FloatArray,
        velocity: FloatArray | None,
    ) -> tuple[State, Estimate]:
        """Advance groups, in each of which all joints have velocities, or none."""
        after: list[Group] = []
        estimates: list[Estimate] = []
        for group in groups:
            joints = list(group.joints)
            rates = None if velocity is None else velocity[joints]
            if rates is not None and np.isnan(rates[0]):
                rates = None
            stepped, estimate = self._step_group(group, stamp_ns, position[joints], rates)
            after.append(stepped)
            estimates.append(estimate)
        return _simplified(stamp_ns, after), _gathered(groups, estimates)

    def _step_group(
        self, group: Group, stamp_ns: int, position: FloatArray, velocity: FloatArray | None
    ) -> tuple[Group, Estimate]:
        """Advance one group by a sample in which all its joints have velocities, or none."""
        step = self.estimator.step
        of_velocities, of_positions = group.of_velocities, group.of_positions
        if velocity is None:
            of_positions, estimate = step(of_positions, stamp_ns, position, None)
            if of_velocities is not None and self._is_old(of_velocities.filter.stamp_ns, stamp_ns):
                of_velocities = None
            return Group(group.joints, of_velocities, of_positions, stamp_ns), estimate
        of_velocities, estimate = step(of_velocities, stamp_ns, position, velocity)
        if of_positions is not None and self._is_old(group.bare_ns, stamp_ns):
            of_positions = None  # not needed after samples with velocities
        if of_positions is not None:
            of_positions, _ = step(of_positions, stamp_ns, position, None)
        return Group(group.joints, of_velocities, of_positions, group.bare_ns), estimate


def _groups_of(state: State | None, joint_count: int) -> tuple[Group, ...]:
    """All joints in their groups."""
    if isinstance(state, Groups):
        return state.groups
    joints = tuple(range(joint_count))
    if state is None:
        return (Group(joints, None, None, 0),)
    if state.from_velocities:
        return (Group(joints, state, None, 0),)
    return (Group(joints, None, state, stamp_of(state)),)


def _divided(groups: Sequence[Group], is_measured: Mask) -> list[Group]:
    """The groups, divided into joints with and without velocities."""
    divided: list[Group] = []
    for group in groups:
        having = [k for k, joint in enumerate(group.joints) if is_measured[joint]]
        lacking = [k for k, joint in enumerate(group.joints) if not is_measured[joint]]
        divided += [_part(group, places) for places in (having, lacking) if places]
    return sorted(divided, key=lambda group: group.joints)


def _part(group: Group, places: list[int]) -> Group:
    """Some joints of a group."""
    if len(places) == len(group.joints):
        return group
    joints = tuple(group.joints[k] for k in places)
    states = [_state_part(state, places) for state in (group.of_velocities, group.of_positions)]
    return Group(joints, states[0], states[1], group.bare_ns)


def _state_part(state: EstimatorState | None, places: list[int]) -> EstimatorState | None:
    """The state of some joints, since operations are elementwise."""
    if state is None:
        return None
    before = state.filter
    sample = np.ascontiguousarray(before.sample[..., places])
    derivatives = np.ascontiguousarray(before.derivatives[..., places])
    return state._replace(filter=before._replace(sample=sample, derivatives=derivatives))


def _simplified(stamp_ns: int, groups: Sequence[Group]) -> State:
    """A single state in place of one group with all joints, if possible."""
    first = groups[0]
    if len(groups) == 1 and first.of_positions is None and first.of_velocities is not None:
        return first.of_velocities
    if len(groups) == 1 and first.of_velocities is None and first.of_positions is not None:
        return first.of_positions
    return Groups(stamp_ns, tuple(groups))


def _gathered(groups: Sequence[Group], estimates: Sequence[Estimate]) -> Estimate:
    """The estimate of all joints; rates are known only if those of all groups are."""
    order = np.argsort(np.concatenate([group.joints for group in groups]))
    velocities = [estimate.velocity for estimate in estimates]
    accelerations = [estimate.acceleration for estimate in estimates]
    velocity, acceleration = _concatenated(velocities), _concatenated(accelerations)
    return Estimate(
        None if velocity is None else velocity[order],
        None if acceleration is None else acceleration[order],
        estimates[0].event,
    )


def _concatenated(parts: Sequence[FloatArray | None]) -> FloatArray | None:
    """Concatenate parts; None if one is unknown."""
    there = [part for part in parts if part is not None]
    return np.concatenate(there) if len(there) == len(parts) else None


def _ends_of_runs(is_measured: Mask) -> list[int]:
    """Ends of runs of rows with velocities of the same joints."""
    changes = np.flatnonzero((is_measured[1:] != is_measured[:-1]).any(axis=1)) + 1
    return [*changes.tolist(), len(is_measured)]
