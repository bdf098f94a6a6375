"""What may change while the robot stays the same: gravity, payloads, and the assembly modes that the loops are on.

Plain values: they travel to the processes that answer service calls.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from hybrid_dynamics_core import ClosedState, Loads, Payload, Robot

from ..messages.joint_samples import Calibration
from ..parameters import (
    GRAVITY,
    PAYLOAD_COM,
    PAYLOAD_FRAME,
    PAYLOAD_INERTIA,
    PAYLOAD_MASS,
    Parameter,
    Settings,
    sensor_rows,
)

Floats = tuple[float, ...]


@dataclass(frozen=True)
class Mass:
    """A payload: mass [kg], centre of mass (3,) [m], inertia about it xx, xy, xz, yy, yz, zz [kg m^2], frame axes."""

    mass: float
    com: Floats
    inertia: Floats


_PAYLOAD: Final[tuple[Parameter[Any], ...]] = (
    PAYLOAD_FRAME,
    PAYLOAD_MASS,
    PAYLOAD_COM,
    PAYLOAD_INERTIA,
)
_NOTHING: Final = Mass(0.0, (), ())


@dataclass(frozen=True)
class Conditions:
    """Gravity (3,) [m/s^2] or None for that of the robot file, payloads by frame, and the state whose modes are kept.

    `mode` is None while the loops are on the modes of the robot file.
    """

    gravity: Floats | None = None
    payloads: Mapping[str, Mass] = field(default_factory=dict)
    mode: ClosedState | None = None

    def with_payload(self, frame: str, body: Mass) -> Conditions:
        """With another payload at a frame; one without mass takes it away."""
        others = {name: mass for name, mass in self.payloads.items() if name != frame}
        return replace(self, payloads={**others, frame: body} if body.mass > 0.0 else others)

    def with_settings(
        self, settings: Settings, before: Settings | None, end_effector: str
    ) -> Conditions:
        """With gravity and payload of the parameters; what a call has set stays while theirs does not change."""
        changed = replace(self, gravity=settings[GRAVITY])
        if before is not None and all(settings[row] == before[row] for row in _PAYLOAD):
            return changed
        if before is not None:
            changed = changed.with_payload(before[PAYLOAD_FRAME] or end_effector, _NOTHING)
        body = Mass(settings[PAYLOAD_MASS], settings[PAYLOAD_COM], settings[PAYLOAD_INERTIA])
        return changed.with_payload(settings[PAYLOAD_FRAME] or end_effector, body)


@dataclass(frozen=True)
class NewPayload:
    """A change that a call makes: another payload at a frame."""

    frame: str
    body: Mass

    def applied(self, conditions: Conditions) -> Conditions:
        """The conditions with it."""
        return conditions.with_payload(self.frame, self.body)

    @property
    def words(self) -> str:
        """What it is, for the log."""
        return (
            f"{self.body.mass:g} kg at {self.frame}"
            if self.body.mass > 0.0
            else f"nothing at {self.frame}"
        )


@dataclass(frozen=True)
class NewMode:
    """A change that a call makes: other assembly modes, those of a closed state."""

    mode: ClosedState

    def applied(self, conditions: Conditions) -> Conditions:
        """The conditions with it."""
        return replace(conditions, mode=self.mode)

    @property
    def words(self) -> str:
        """What it is, for the log."""
        return ", ".join(f"{loop} {name}" for loop, name in self.mode.branch.items())


Change = NewPayload | NewMode


def loads_of(robot: Robot, conditions: Conditions) -> Loads:
    """Everything that acts on the robot under the conditions.

    Raises:
        InputError: there is no such frame, or no rigid body has such an inertia.
    """
    loads = robot.loads
    if conditions.gravity is not None:
        loads = loads.with_gravity(conditions.gravity)
    for frame, body in conditions.payloads.items():
        xx, xy, xz, yy, yz, zz = body.inertia
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        loads = loads.with_payload(Payload(body.mass, body.com, inertia), frame)
    return loads


def calibration_of(settings: Settings, joints: tuple[str, ...]) -> Calibration | None:
    """What the sensors need; None where they read the coordinates themselves."""
    table = [[settings[row] for row in sensor_rows(joint)] for joint in joints]
    offset, sign, scale = np.array(table, dtype=np.float64).T
    if not offset.any() and (sign * scale == 1.0).all():
        return None
    return Calibration(offset, sign * scale)
