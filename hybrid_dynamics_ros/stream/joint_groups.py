"""Rates of joints some of which have velocities, and of messages that have them in turn.

Where every message has the velocities of all joints, or none of any, one estimator serves all.
Else joints of one history are a group with an estimator's states of its own. The estimator of a
joint that changes between both kinds is asked for both: each goes on from its own samples. An
estimator that takes both kinds in turn needs no groups as long as all joints have velocities, or
none.
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
    """Joints of one history.

    Attributes:
        joints: their numbers, rising.
        of_velocities: the estimator's state after the newest sample with velocities, or None.
        of_positions: after the newest sample as one without, or None where none is needed.
        bare_ns: stamp of the newest sample without velocities [ns].
    """

    joints: tuple[int, ...]
    of_velocities: EstimatorState | None
    of_positions: EstimatorState | None
    bare_ns: int


class Groups(NamedTuple):
    """All joints, in groups.

    Attributes:
        stamp_ns: of the newest sample [ns].
        groups: by their first joint.
    """

    stamp_ns: int
    groups: tuple[Group, ...]


State = EstimatorState | Groups  # of one kind for all joints, or in groups


def stamp_of(state: State) -> int:
    """Stamp of the newest sample [ns]."""
    return state.stamp_ns if isinstance(state, Groups) else state.filter.stamp_ns


@dataclass(frozen=True)
class GroupedEstimator:
    """An estimator for joints whose velocities may be absent, one by one and now and then.

    Attributes:
        estimator: does the work.
    """

    estimator: MotionEstimator

    def step(
        self, state: State | None, stamp_ns: int, position: FloatArray, velocity: FloatArray | None
    ) -> tuple[State, Estimate]:
        """State and estimate after one more sample.

        Args:
            state: state before, or None at the start; it is not changed.
            stamp_ns: stamp [ns].
            position: (n,) [rad or m].
            velocity: (n,) [rad/s or m/s], NaN where it is absent; None: of all joints.

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
        """The first sample after an event that starts all anew."""
        state, estimate = self.step(None, stamp_ns, position, velocity)
        return state, estimate._replace(event=event)

    def run(
        self,
        state: State | None,
        stamps: NDArray[np.int64],
        position: FloatArray,
        velocity: FloatArray,
    ) -> RateRows:
        """What `step` gives for each of N samples, one after the other.

        Args:
            state: state before, or None at the start; it is not changed.
            stamps: (N,) [ns].
            position: (N, n) [rad or m].
            velocity: (N, n) [rad/s or m/s], NaN where it is absent.

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
        """Fill in the rates of some rows of one kind for all joints, or of one row.

        Args:
            rates: of all samples; its `state` is that before the rows, and then that after them.
            rows: which.
            stamps: (k,) of the rows [ns].
            position: (k, n) of the rows [rad or m].
            velocity: (k, n) of the rows [rad/s or m/s], NaN where it is absent.
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
        """Whether one estimator goes on with a sample, of whose joints (n,) is said."""
        measures_all = bool(is_measured.all())
        if not measures_all and is_measured.any():
            return False
        return self._goes_on(state, is_measured=measures_all)

    def _goes_on(
        self, state: State | None, *, is_measured: bool
    ) -> TypeGuard[EstimatorState | None]:
        """Whether one estimator goes on with a sample, all of whose joints have velocities or none.

        It does where so did the samples before, or where the estimator takes both kinds in turn.
        """
        if state is None:
            return True
        if isinstance(state, Groups):
            return False
        return self.estimator.takes_turns or state.from_velocities == is_measured

    def _restart(self, before_ns: int, stamp_ns: int) -> StampEvent | None:
        """Why all groups start anew at a stamp; None where they go on."""
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
        """State and estimate of groups all of whose joints have velocities, or none."""
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
        """A group after one more sample, all of whose joints have velocities, or none."""
        step = self.estimator.step
        of_velocities, of_positions = group.of_velocities, group.of_positions
        if velocity is None:
            of_positions, estimate = step(of_positions, stamp_ns, position, None)
            if of_velocities is not None and self._is_old(of_velocities.filter.stamp_ns, stamp_ns):
                of_velocities = None
            return Group(group.joints, of_velocities, of_positions, stamp_ns), estimate
        of_velocities, estimate = step(of_velocities, stamp_ns, position, velocity)
        if of_positions is not None and self._is_old(group.bare_ns, stamp_ns):
            of_positions = None  # samples without velocities are over
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
    """The groups, each divided into joints with velocities and those without."""
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
    """The state of some joints: all work on samples is elementwise."""
    if state is None:
        return None
    before = state.filter
    sample = np.ascontiguousarray(before.sample[..., places])
    derivatives = np.ascontiguousarray(before.derivatives[..., places])
    return state._replace(filter=before._replace(sample=sample, derivatives=derivatives))


def _simplified(stamp_ns: int, groups: Sequence[Group]) -> State:
    """The state of one estimator, where that is all there is."""
    first = groups[0]
    if len(groups) == 1 and first.of_positions is None and first.of_velocities is not None:
        return first.of_velocities
    if len(groups) == 1 and first.of_velocities is None and first.of_positions is not None:
        return first.of_positions
    return Groups(stamp_ns, tuple(groups))


def _gathered(groups: Sequence[Group], estimates: Sequence[Estimate]) -> Estimate:
    """The estimate of all joints; rates of none are known before those of all are."""
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
    """All parts in a row; None where one is not known."""
    there = [part for part in parts if part is not None]
    return np.concatenate(there) if len(there) == len(parts) else None


def _ends_of_runs(is_measured: Mask) -> list[int]:
    """Where runs of rows end that have velocities of the same joints."""
    changes = np.flatnonzero((is_measured[1:] != is_measured[:-1]).any(axis=1)) + 1
    return [*changes.tolist(), len(is_measured)]
