"""A robot's closed state beside Pinocchio's model of the same file.

`difference` compares mass matrix, weight and inverse dynamics, and what the file's ties miss.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from pinocchio_files import PinocchioFile, Tie

_STEP = 1e-30  # of a complex step


class Motion:
    """Positions, velocities and accelerations of a robot's state in Pinocchio.

    Attributes:
        q: (nq,) configuration.
        rates: (nv, n_s) velocity from the rates of the robot's coordinates.
        drift: (nv,) acceleration without those of the coordinates.
    """

    def __init__(self, robot: Any, file: PinocchioFile, state: Any) -> None:
        self.robot = robot
        self.model = file.model
        self.columns = {name: k for k, name in enumerate(robot.coordinates)}
        self.s = state.s
        self.ds = state.ds
        self.q = pin.neutral(self.model)
        self.rates = np.zeros((self.model.nv, len(state.s)))
        self.drift = np.zeros(self.model.nv)
        self.poses = {}
        for joint in robot.description.freely_turning:
            self.poses[joint.name] = robot.joint_pose(state, joint.name)
        for number in range(1, self.model.njoints):
            self.place(self.model.names[number], self.model.joints[number])

    def place(self, name: str, joint: Any) -> None:
        """Set the coordinates of one joint."""
        if joint.nv == 1:
            self.place_one(name, joint)
        elif joint.nv == 6:
            self.place_free(name, joint)
        elif joint.shortname() == "JointModelSpherical":
            turns = [self.columns[f"{name}_{letter}"] for letter in "XYZ"]
            self.place_turns(joint.idx_q, joint.idx_v, turns)
        else:
            raise NotComparedError(f"{joint.shortname()} is not compared")

    def place_one(self, name: str, joint: Any) -> None:
        """A joint of one freedom, whose angle may be a pair of cosine and sine."""
        if name not in self.columns:
            raise NotComparedError(f"there is no coordinate {name}")
        column = self.columns[name]
        value = self.s[column]
        first = joint.idx_q
        if joint.nq == 2:
            self.q[first] = np.cos(value)
            self.q[first + 1] = np.sin(value)
        else:
            self.q[first] = value
        self.rates[joint.idx_v, column] = 1.0

    def place_free(self, name: str, joint: Any) -> None:
        """A free joint: its velocity is the child's twist in its own axes."""
        slides = [self.columns[f"{name}_{letter}"] for letter in "xyz"]
        turns = [self.columns[f"{name}_r{letter}"] for letter in "xyz"]
        pose = self.poses[name]
        to_child = pose.rotation.T
        linear = slice(joint.idx_v, joint.idx_v + 3)
        self.q[joint.idx_q : joint.idx_q + 3] = pose.position
        omega = self.place_turns(joint.idx_q + 3, joint.idx_v + 3, turns)
        self.rates[linear, slides] = to_child
        velocity = to_child @ self.ds[slides]
        self.drift[linear] = -np.cross(omega, velocity)

    def place_turns(self, position: int, velocity: int, turns: list[int]) -> Any:
        """Turns about x, y and z in a row as a quaternion; their angular velocity."""
        angles = self.s[turns]
        rates = self.ds[turns]
        rotation = about(0, angles[0]) @ about(1, angles[1]) @ about(2, angles[2])
        quaternion = pin.Quaternion(np.real(rotation))
        self.q[position : position + 4] = quaternion.coeffs()
        angular = slice(velocity, velocity + 3)
        to_omega = np.real(velocity_map(angles))
        stepped = velocity_map(angles + 1j * _STEP * rates)
        change = np.imag(stepped) / _STEP
        self.rates[angular, turns] = to_omega
        self.drift[angular] = change @ rates
        return to_omega @ rates


class NotComparedError(Exception):
    """Pinocchio means something else by the file, or has no word for it."""


def difference(robot: Any, file: PinocchioFile, state: Any) -> tuple[float, float]:
    """Largest relative difference of mass matrix, weight and inverse dynamics, and largest gap."""
    motion = Motion(robot, file, state)
    given = np.ones(len(state.u))
    velocity = motion.rates @ state.ds
    acceleration = motion.rates @ robot.accelerations(state, given) + motion.drift
    differences = (
        difference_of_mass(motion, file, state),
        difference_of_weight(motion, file, state),
        difference_of_efforts(motion, file, state, given),
    )
    gaps = [0.0]
    for tie in file.ties:
        gaps.extend(gaps_of(file, tie, motion.q, velocity, acceleration))
    for _, coefficients, constant in file.couplings():
        gaps.append(gap_of_sum(motion, coefficients, constant))
    return max(differences), max(gaps)


def difference_of_mass(motion: Motion, file: PinocchioFile, state: Any) -> float:
    """Relative difference of the mass matrix."""
    to_u = motion.rates @ state.R
    upper = np.triu(pin.crba(file.model, file.data, motion.q))
    lower = np.triu(upper, 1).T
    mass = upper + lower + np.diag(file.rotors())
    result, *_ = motion.robot.minimal_form(state)
    return relative(result, to_u.T @ mass @ to_u)


def difference_of_weight(motion: Motion, file: PinocchioFile, state: Any) -> float:
    """Relative difference of the efforts that hold the robot."""
    robot = motion.robot
    to_u = motion.rates @ state.R
    still = robot.close(state.u, near=state)
    held = robot.inverse_dynamics(still, np.zeros(len(state.u)))
    weight = pin.computeGeneralizedGravity(file.model, file.data, motion.q)
    return relative(held, to_u.T @ weight)


def difference_of_efforts(motion: Motion, file: PinocchioFile, state: Any, given: Any) -> float:
    """Relative difference of inverse dynamics for given accelerations."""
    robot, model = motion.robot, file.model
    to_u = motion.rates @ state.R
    velocity = motion.rates @ state.ds
    acceleration = motion.rates @ robot.accelerations(state, given) + motion.drift
    forces = pin.rnea(model, file.data, motion.q, velocity, acceleration)
    damping = np.array(model.damping).ravel()
    forces += file.rotors() * acceleration
    forces += damping * velocity
    efforts = robot.inverse_dynamics(state, given)
    return relative(efforts, to_u.T @ forces)


def gap_of_sum(motion: Motion, coefficients: Any, constant: float) -> float:
    """What a coupling misses in positions and rates."""
    values = constant
    rates = 0.0
    for name, coefficient in coefficients.items():
        column = motion.columns[name]
        values += coefficient * motion.s[column]
        rates += coefficient * motion.ds[column]
    return max(abs(values), abs(rates))


def gaps_of(file: PinocchioFile, tie: Tie, q: Any, velocity: Any, acceleration: Any) -> list[float]:
    """What a tie misses in position, velocity and acceleration, over its size there."""
    model, data = file.model, file.data
    pin.forwardKinematics(model, data, q, velocity, acceleration)
    one, other = (moving_frame(data, *end) for end in tie.ends)
    rows = [one.point - other.point]
    if tie.kind != "point":
        rows.append(one.x - other.x)
    if tie.kind == "frame":
        rows.append(one.y - other.y)
    scale = np.maximum(1.0, np.abs(one.point).max(axis=1))
    gaps = [np.abs(row).max(axis=1) / scale for row in rows]
    return np.ravel(gaps).tolist()


@dataclass(frozen=True)
class MovingFrame:
    """Origin and two axes of a frame in the world, with two derivatives each: (3, 3)."""

    point: Any
    x: Any
    y: Any


def moving_frame(data: Any, number: int, place: pin.SE3) -> MovingFrame:
    """A frame of a moving body."""
    body = data.oMi[number]
    turn = body.rotation
    if number:
        twist = data.v[number]
        acceleration = data.a[number]
        omega = turn @ twist.angular
        alpha = turn @ acceleration.angular
        rate = turn @ twist.linear
        change = turn @ acceleration.linear + np.cross(omega, rate)
    else:
        omega = alpha = rate = change = np.zeros(3)
    arm = turn @ place.translation
    turned = turn @ place.rotation
    point = moved(arm, omega, alpha) + np.array([body.translation, rate, change])
    axes = [moved(turned[:, k], omega, alpha) for k in range(2)]
    return MovingFrame(point, *axes)


def moved(arm: Any, omega: Any, alpha: Any) -> Any:
    """A vector fixed in a body, with two derivatives: (3, 3)."""
    rate = np.cross(omega, arm)
    towards = np.cross(omega, rate)
    along = np.cross(alpha, arm)
    return np.array([arm, rate, along + towards])


# -- rotations and numbers


def about(axis: int, angle: Any) -> Any:
    """A turn about a coordinate axis, also by a complex angle."""
    c, s = np.cos(angle), np.sin(angle)
    about_x = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    rows = np.roll(about_x, axis, 0)
    return np.roll(rows, axis, 1)


def velocity_map(angles: Any) -> Any:
    """From rates of turns about x, y and z in a row to the angular velocity in child axes."""
    y = about(1, angles[1])
    z = about(2, angles[2])
    unit = np.eye(3)
    first = z.T @ y.T @ unit[0]
    second = z.T @ unit[1]
    return np.column_stack([first, second, unit[2]])


def relative(one: Any, other: Any) -> float:
    """The largest difference over the largest number."""
    largest = float(np.abs(other).max(initial=0.0))
    size = max(1e-3, largest)
    differences = np.abs(np.asarray(one) - other)
    return float(differences.max(initial=0.0)) / size
