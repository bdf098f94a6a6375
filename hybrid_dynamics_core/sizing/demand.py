"""What a drive has to do in a duty cycle: its travel, rates and forces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from ..closed_state.state import ClosedState
from ..description.effects import Payload
from ..description.model import JointType
from ..dynamics.loads import Loads
from ..errors import InputError, StateError
from ..ground.arrays import Array
from ..ground.suggestions import no_such_name
from ..robot.robot import Robot
from .duty import DutyCycle
from .pins import pin_distance


@dataclass(frozen=True, eq=False)
class Demand:
    """What a drive has to do, row by row of a duty cycle.

    Forces leave out the rotor that the description has at this joint: a motor of a catalogue brings
    its own.

    Attributes:
        drive: name of its joint.
        kind: type of that joint.
        position: coordinate (N,) [rad or m].
        rate: (N,) [rad/s or m/s].
        acceleration: (N,) [rad/s^2 or m/s^2].
        force: (N,) along the coordinate [N m or N].
        weights: (N,) share of each row in means.
        length: (N,) distance of the pins of a cylinder [m]; None if the joint has no two pins.
    """

    drive: str
    kind: JointType
    position: Array
    rate: Array
    acceleration: Array
    force: Array
    weights: Array
    length: Array | None

    @property
    def travel(self) -> float:
        """Way between the ends that are reached [rad or m]."""
        return float(np.ptp(self.position))

    @property
    def speed(self) -> float:
        """Largest rate [rad/s or m/s]."""
        return largest(self.rate)

    @property
    def peak(self) -> float:
        """Largest force [N m or N]."""
        return largest(self.force)

    @property
    def rms(self) -> float:
        """Root mean square of the force [N m or N]."""
        return root_mean_square(self.force, self.weights)

    @property
    def power(self) -> float:
        """Largest power, given or taken [W]."""
        return largest(self.force * self.rate)


def largest(values: Array) -> float:
    """The largest size of values (N,)."""
    return float(np.abs(values).max())


def root_mean_square(values: Array, weights: Array) -> float:
    """Root of the weighted mean of squares (N,)."""
    mean = weights @ values**2
    return float(np.sqrt(mean))


def demand_of(robot: Robot, duty: DutyCycle, drive: str) -> Demand:
    """What a drive has to do in a duty cycle.

    Args:
        robot: the robot.
        duty: its duty cycle.
        drive: name of one of `robot.drives`.

    Raises:
        InputError: there is no such drive.
        StateError: the robot does not reach a row; the message says where it stands.
    """
    if drive not in robot.drives:
        raise InputError(no_such_name("drive", drive, robot.drives))
    state, ddu = closed_duty(robot, duty)
    efforts = _efforts(robot, duty, drive, state, ddu)
    forces = robot.drive_forces(state, efforts)
    accelerations = robot.accelerations(state, ddu)
    k = robot.coordinates.index(drive)
    return Demand(
        drive=drive,
        kind=robot.joint_types[drive],
        position=state.s[:, k],
        rate=state.ds[:, k],
        acceleration=accelerations[:, k],
        force=forces[drive],
        weights=duty.weights,
        length=pin_distance(robot, drive, state),
    )


def closed_duty(robot: Robot, duty: DutyCycle) -> tuple[ClosedState, Array]:
    """The closed states (N) of a duty cycle, and its active accelerations (N, n).

    A motion is followed from row to row; rows without a time are closed each from the reference.

    Raises:
        StateError: the robot does not reach a row.
    """
    is_motion = duty.time is not None
    try:
        if duty.names != robot.active:
            return _closed_given(robot, duty, is_motion)
        close = robot.close_path if is_motion else robot.close
        return close(duty.values, duty.rates), duty.accelerations
    except StateError as error:
        _raise_at(duty, error.index or 0, error)


def _closed_given(robot: Robot, duty: DutyCycle, is_motion: bool) -> tuple[ClosedState, Array]:
    """The same from other independent coordinates."""
    states: list[ClosedState] = []
    near = None
    for k in range(len(duty.values)):
        try:
            state = robot.close_given(
                _by_name(duty, duty.values[k]),
                _by_name(duty, duty.rates[k]),
                _by_name(duty, duty.accelerations[k]),
                near=near,
            )
        except StateError as error:
            _raise_at(duty, k, error)
        states.append(state)
        if is_motion:
            near = state
    joined = ClosedState.joined(states)
    count = len(robot.active)
    return joined, np.asarray(joined.dds)[:, :count]


def _by_name(duty: DutyCycle, row: Array) -> dict[str, float]:
    return dict(zip(duty.names, row.tolist(), strict=True))


def _raise_at(duty: DutyCycle, row: int, error: StateError) -> NoReturn:
    """Raise an error again, with the place of its row."""
    problem = str(error).removeprefix(f"row {error.index}: ")
    error.index = row
    error.args = (f"{duty.places[row]}: {problem}",)
    raise error


def _efforts(robot: Robot, duty: DutyCycle, drive: str, state: ClosedState, ddu: Array) -> Array:
    """Efforts (N, n) of the active joints, without the rotor of a drive."""
    armature = robot.loads.effects.armature.copy()
    armature[robot.coordinates.index(drive)] = 0.0
    unloaded = robot.loads.with_effects(armature=armature)
    efforts = np.zeros_like(ddu)
    bodies = np.unique(duty.payload, axis=0)
    for mass, *com in bodies.tolist():
        same = (duty.payload == [mass, *com]).all(axis=1)
        rows = np.flatnonzero(same)
        payload = Payload(mass, com)
        loads = _loaded(unloaded, payload, duty.wrench[rows])
        some = state.rows(rows)
        efforts[rows] = robot.inverse_dynamics(some, ddu[rows], loads)
    return efforts


def _loaded(loads: Loads, payload: Payload, wrench: Array) -> Loads:
    """Loads with a payload and wrenches (N, 6) on the end effector."""
    if payload.mass:
        loads = loads.with_payload(payload)
    if wrench.any():
        loads = loads.with_wrench(wrench)
    return loads
