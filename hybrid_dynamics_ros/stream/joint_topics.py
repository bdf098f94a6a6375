"""Topics of joints: states of all joints, required efforts, and measured efforts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from hybrid_dynamics_core import Robot

from ..messages.cdr import MessageTemplate
from ..messages.interfaces import JOINT_STATE
from ..messages.joint_samples import FloatArray
from ..messages.joint_state_layout import joint_state_template
from .floating.first_charts import efforts_in_first
from .output_topic import Message, OutputTopic, Rows
from .results import MotionResult

_MOST_TEMPLATES: Final = 64  # cached layouts of joint states
_NO_EXTRAS: Final = np.zeros((3, 0))


class JointStates(OutputTopic):
    """States of all joints: position, velocity, and effort of the drive, zero without a drive."""

    name, kind = "joint_states", JOINT_STATE

    def __init__(self, robot: Robot) -> None:
        self._driven = len(robot.description.motors)
        self._has_turns = bool(robot.description.freely_turning)
        self._drives_are_active = set(robot.drives) == set(robot.description.motors)
        self._drive_places = [robot.coordinates.index(name) for name in robot.drives]
        self._names = robot.coordinates
        self._templates: dict[Any, MessageTemplate] = {}  # by extra joints and known fields

    def message(self, result: MotionResult) -> Message:
        """The message, with velocities and efforts if known."""
        velocity, efforts = result.velocity, self._efforts(result)
        parts = [result.position, velocity, efforts]
        names, extras = _extras_of(result)
        if names:
            for k, part in enumerate(parts):
                parts[k] = None if part is None else np.concatenate([part, extras[..., k, :]], -1)
        template = self._template(names, velocity is not None, efforts is not None)
        return template, [part for part in parts if part is not None]

    def _template(self, names: tuple[str, ...], velocity: bool, effort: bool) -> MessageTemplate:
        """The layout of messages with extra joints, and with velocities and efforts."""
        template = self._templates.get((names, velocity, effort))
        if template is None:
            if len(self._templates) >= _MOST_TEMPLATES:
                self._templates.clear()
            every = (*self._names, *names)
            template = joint_state_template(every, velocity=velocity, effort=effort)
            self._templates[names, velocity, effort] = template
        return template

    def groups(self, result: MotionResult) -> Sequence[Rows]:
        """Rows with the same layout: extra joints, and whether efforts are known."""
        groups: list[Rows] = []
        for rows in _by_extras(result):
            groups += [rows[part] for part in self._by_efforts(result.rows(rows))]
        return groups

    def _by_efforts(self, result: MotionResult) -> Sequence[Rows]:
        """Rows whose drives can give the efforts, and all other rows."""
        every = super().groups(result)
        if self._drives_are_active or result.efforts is None or result.drive_forces is not None:
            return every
        singles = [result.rows(row[None]) for row in every[0]]
        can_give = np.array([single.drive_forces is not None for single in singles])
        return [np.flatnonzero(can_give), np.flatnonzero(~can_give)]

    def _efforts(self, result: MotionResult) -> FloatArray | None:
        """Efforts along all coordinates; None if unknown."""
        if self._drives_are_active:
            tau = result.efforts
            if tau is None:
                return None
            if self._has_turns:
                tau = efforts_in_first(result.robot, result.state, tau)
            efforts = np.zeros(result.position.shape)
            efforts[..., : self._driven] = tau[..., : self._driven]
            return efforts
        forces = result.drive_forces
        if forces is None:
            return None
        efforts = np.zeros(result.position.shape)
        for place, force in zip(self._drive_places, forces.values(), strict=True):
            efforts[..., place] = force
        return efforts


def _extras_of(result: MotionResult) -> tuple[tuple[str, ...], FloatArray]:
    """Names (k,) and values (3, k), or (N, 3, k) for rows, of the extra joints."""
    extras = result.extras
    if not extras:
        return (), _NO_EXTRAS
    if not isinstance(extras, list):
        return extras.names, extras.values
    if extras[0] is None:
        return (), _NO_EXTRAS
    return extras[0].names, np.array([extra.values for extra in extras])


def _by_extras(result: MotionResult) -> Sequence[Rows]:
    """Rows with the same extra joints."""
    every = np.arange(len(result.position))
    if result.extras is None:
        return [every]
    names = [() if extra is None else extra.names for extra in result.extras]
    kinds = list(dict.fromkeys(names))
    numbers = np.array([kinds.index(one) for one in names])
    return [np.flatnonzero(numbers == k) for k in range(len(kinds))]


class RequiredEfforts(OutputTopic):
    """Required efforts of the driven joints; no message until accelerations are known."""

    name, kind = "required_efforts", JOINT_STATE

    def __init__(self, robot: Robot) -> None:
        motors = robot.description.motors
        self._driven = len(motors)  # idle coordinates come last
        self._has_turns = bool(robot.description.freely_turning)
        self._template = joint_state_template(motors, velocity=True, effort=True)

    def message(self, result: MotionResult) -> Message | None:
        """Position, velocity and effort."""
        u, du, _ = result.active
        efforts = result.efforts
        if efforts is None or du is None:
            return None
        if self._has_turns and result.velocity is not None:
            u, du = result.position, result.velocity
            efforts = efforts_in_first(result.robot, result.state, efforts)
        values = [part[..., : self._driven] for part in (u, du, efforts)]
        return self._template, values


class MeasuredEfforts(OutputTopic):
    """Forces of cylinders from measured pressures, NaN for other drives.

    There is no message without pressures.
    """

    name, kind = "measured_efforts", JOINT_STATE

    def __init__(self, robot: Robot) -> None:
        drives = robot.drives
        self._places = [robot.coordinates.index(name) for name in drives]
        self._templates = [
            joint_state_template(drives, velocity=has_velocity, effort=True)
            for has_velocity in (False, True)
        ]

    def message(self, result: MotionResult) -> Message | None:
        """Position, velocity if known, and effort."""
        forces = result.measured_forces
        if forces is None:
            return None
        values = [result.position[..., self._places]]
        if result.velocity is not None:
            values.append(result.velocity[..., self._places])
        return self._templates[len(values) - 1], [*values, forces]

    def groups(self, result: MotionResult) -> Sequence[Rows]:
        """Rows with pressures."""
        forces = result.measured_forces
        if forces is None:
            return []
        return [np.flatnonzero(~np.isnan(forces).all(axis=1))]
