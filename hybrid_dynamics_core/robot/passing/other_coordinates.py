"""The same mechanism with other independent coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...closed_state.state import ClosedState
from ...closure.constraints.parallelogram import PARALLELOGRAM
from ...description.model import Closure, JointType, RobotDescription
from ...ground.arrays import Array
from .singular_places import SingularPlaces

LEAST_GAIN = 3.0  # of a passive rate over the active one that it replaces


class Mechanism(Protocol):
    """What is asked of a robot."""

    def __init__(self, description: RobotDescription) -> None: ...

    @property
    def description(self) -> RobotDescription:
        """The description."""

    @property
    def active(self) -> tuple[str, ...]:
        """Names of the active coordinates."""

    @property
    def passive(self) -> tuple[str, ...]:
        """Names of the passive coordinates."""

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of all coordinates."""

    @property
    def joint_types(self) -> Mapping[str, JointType]:
        """'revolute' or 'prismatic' by coordinate name."""

    @property
    def singular_places(self) -> SingularPlaces:
        """Change points and toggles."""


R = TypeVar("R", bound=Mechanism)


def better_coordinates(robot: Mechanism, state: ClosedState) -> tuple[str, ...] | None:
    """The active coordinates, with one replaced by the passive one that moves most.

    Near a toggle an active rate is small and passive ones are large: R has a large entry.
    Displacements count in lengths of the loops.

    Args:
        robot: the model.
        state: one closed state.

    Returns:
        Names of n coordinates; None if no passive coordinate moves much more than an active one.
    """
    n = len(robot.active)
    gains = np.abs(state.R[n:]) * _units(robot)
    gains[~_may_be_given(robot)] = 0.0
    if not gains.size or gains.max() < LEAST_GAIN:
        return None
    passive, active = np.unravel_index(int(gains.argmax()), gains.shape)
    names = list(robot.active)
    names[active] = robot.passive[passive]
    return tuple(names)


def _units(robot: Mechanism) -> Array:
    """Factors (n_z, n) that make rates of passive over active coordinates dimensionless."""
    lengths = [loop.length for loop in robot.singular_places.loop_equations if loop.has_length]
    length = float(np.mean(lengths or [1.0]))
    units: list[float] = []
    for name in robot.coordinates:
        is_angle = robot.joint_types[name] == "revolute"
        units.append(1.0 if is_angle else length)
    n = len(robot.active)
    sizes = np.array(units)
    return np.asarray(sizes[:n] / sizes[n:, None])


def _may_be_given(robot: Mechanism) -> NDArray[np.bool_]:
    """Mask (n_z,) of passive coordinates that are joints of one freedom and follow no other."""
    description = robot.description
    chained: set[str] = set()
    for joint in description.multi_dof.values():
        chained.update(joint.joints)
    taken = chained | set(description.mimics)
    return np.array([name not in taken for name in robot.passive], dtype=bool)


def with_active(robot: R, active: tuple[str, ...], state: ClosedState) -> R:
    """The same mechanism with other active coordinates.

    Its reference is a given state, and so are its assembly modes.

    Args:
        robot: the model.
        active: names of n of its coordinates.
        state: one closed state.

    Raises:
        DescriptionError: they do not determine the other coordinates there.
    """
    description: RobotDescription = robot.description
    closures: list[Closure] = []
    for closure in description.closures:
        assembly = closure.assembly
        if assembly != PARALLELOGRAM:
            assembly = None  # it names a mode of the old coordinates
        closures.append(replace(closure, assembly=assembly))
    reference = dict(zip(robot.coordinates, state.s.tolist(), strict=True))
    changed = replace(
        description,
        active=active,
        idle=(),
        active_set="exact",
        reference=reference,
        closures=tuple(closures),
    )
    return type(robot)(changed)
