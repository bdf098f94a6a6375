"""What acts on a robot besides its actuators: payloads, counterweights, wrenches, friction, rotors, springs, gravity.

Frozen values, changed by making others:  loads = robot.loads.with_payload(Payload(20.0),
"end_effector").
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ..description.effects import Payload
from ..description.model import RobotDescription, effects_of
from ..errors import InputError
from ..ground.arrays import Array, Picklable, frozen

Axes = Literal["base", "frame"]
AXES = ("base", "frame")


@dataclass(frozen=True, eq=False)
class AppliedWrench:
    """A force [N] and a moment [N m] about a frame's origin: `values` (6,) or (N, 6), force first.

    `axes`: "base", directions fixed in space; "frame", directions that turn with the frame.
    """

    values: Array
    axes: Axes = "base"


@dataclass(frozen=True, eq=False)
class JointEffects:
    """What acts along the joints, each (n_s,) in the order of `robot.coordinates`.

    What drives a joint has to supply

        viscous q' + coulomb q' / sqrt(q'^2 + smoothing^2) + armature q'' + stiffness (q - rest) +
        preload.

    Coulomb's sign(q') is made smooth over rates of about `smoothing` [rad/s or m/s], above zero: at
    ten times that rate 99.5 % of `coulomb` act, at rest none, so the model creeps where a real
    joint sticks. `armature` is the rotor's inertia times the square of its gear ratio; what the
    spinning rotor does to a link that turns is left out.

    Units for revolute (prismatic) joints: viscous [N m s/rad] ([N s/m]), coulomb and preload [N m]
    ([N]), armature [kg m^2] ([kg]), stiffness [N m/rad] ([N/m]), rest [rad] ([m]).
    """

    viscous: Array
    coulomb: Array
    smoothing: Array
    armature: Array
    stiffness: Array
    rest: Array
    preload: Array

    def __post_init__(self) -> None:
        size = np.shape(self.viscous)
        for name in self.__dataclass_fields__:
            values = frozen(getattr(self, name))
            if values.shape != size or values.ndim != 1 or not np.isfinite(values).all():
                raise InputError(
                    f"{name} has shape {values.shape}; expected {size} finite numbers, one a"
                    " coordinate"
                )
            if name not in ("rest", "preload", "stiffness") and (values < 0.0).any():
                raise InputError(f"{name} has a negative entry; expected zero or positive")
            object.__setattr__(self, name, values)
        if not (self.smoothing > 0.0).all():
            raise InputError(
                "smoothing has to be above zero: it is the rate over which friction changes sign"
            )

    @property
    def has_friction(self) -> bool:
        """Whether any joint has friction."""
        return bool(self.viscous.any() or self.coulomb.any())

    @property
    def has_drives(self) -> bool:
        """Whether any joint turns a rotor."""
        return bool(self.armature.any())

    @property
    def has_springs(self) -> bool:
        """Whether any joint has a spring."""
        return bool(self.stiffness.any() or self.preload.any())


def _require_payload(given: object) -> None:
    if not isinstance(given, Payload):
        example = f"Payload({given})" if isinstance(given, (int, float)) else "Payload(10.0)"
        raise InputError(f"expected a Payload, such as {example}, got {type(given).__name__}")


_NONE: Mapping[str, AppliedWrench] = MappingProxyType({})


@dataclass(frozen=True, eq=False)
class Loads(Picklable):
    """Everything that acts on a robot besides its actuators; `robot.loads` is what its description gives.

    `gravity`: (3,) [m/s^2] in base axes; `payloads`: bodies fixed to frames, by the frame's name (a
    list each); `wrenches`: by the name of the frame on which they act.
    """

    gravity: Array
    effects: JointEffects
    payloads: Mapping[str, tuple[Payload, ...]] = field(default_factory=dict)
    wrenches: Mapping[str, AppliedWrench] = field(default_factory=lambda: _NONE)

    def with_payload(self, payload: Payload, frame: str = "end_effector") -> Loads:
        """These loads with one more body fixed to a frame (a link's name is its own frame)."""
        _require_payload(payload)
        payloads = {**self.payloads, frame: (*self.payloads.get(frame, ()), payload)}
        return replace(self, payloads=MappingProxyType(payloads))

    def without_payload(self, frame: str = "end_effector") -> Loads:
        """These loads with nothing fixed to a frame."""
        return replace(
            self, payloads=MappingProxyType({k: v for k, v in self.payloads.items() if k != frame})
        )

    def with_wrench(
        self, wrench: ArrayLike, frame: str = "end_effector", axes: Axes = "base"
    ) -> Loads:
        """These loads with a force and moment (6,) or (N, 6) about a frame's origin, in place of one there before."""
        try:
            values = frozen(wrench)
        except (TypeError, ValueError) as error:
            raise InputError(
                f"the wrench on '{frame}' is not an array of numbers: {error}"
            ) from error
        if values.ndim not in (1, 2) or values.shape[-1] != 6 or not np.isfinite(values).all():
            raise InputError(
                f"the wrench on '{frame}' has shape {values.shape}; expected 6 finite numbers,"
                " force then moment"
            )
        if axes not in AXES:
            raise InputError(f"axes is '{axes}'; expected {' or '.join(AXES)}")
        return replace(
            self, wrenches=MappingProxyType({**self.wrenches, frame: AppliedWrench(values, axes)})
        )

    def with_effects(self, **changes: ArrayLike) -> Loads:
        """These loads with other joint effects, each (n_s,), such as viscous=[...]."""
        return replace(
            self, effects=replace(self.effects, **{k: np.asarray(v) for k, v in changes.items()})
        )

    def with_gravity(self, gravity: ArrayLike) -> Loads:
        """These loads with another gravity (3,) [m/s^2], base axes."""
        values = frozen(gravity)
        if values.shape != (3,) or not np.isfinite(values).all():
            raise InputError(f"gravity has shape {values.shape}; expected 3 finite numbers")
        return replace(self, gravity=values)


def described_loads(description: RobotDescription, coordinates: tuple[str, ...]) -> Loads:
    """The loads that a description gives."""
    joints = [effects_of(description, name) for name in coordinates]
    arrays = {
        name: frozen([getattr(j, name) for j in joints])
        for name in JointEffects.__dataclass_fields__
    }
    payloads: dict[str, tuple[Payload, ...]] = {}
    for place, payload in description.payloads.values():
        payloads[place] = (*payloads.get(place, ()), payload)
    return Loads(description.gravity, JointEffects(**arrays), MappingProxyType(payloads))
