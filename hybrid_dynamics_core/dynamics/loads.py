"""Loads on a robot besides its actuators.

Payloads, counterweights, wrenches, friction, rotors, springs and gravity. They are immutable;
methods return changed copies: loads = robot.loads.with_payload(Payload(20.0), "end_effector").
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
from ..ground.check_arguments import require_type
from ..ground.check_arrays import real_array

Axes = Literal["base", "frame"]
AXES = ("base", "frame")
SIGNED = ("rest", "preload", "stiffness")  # joint effects that may be negative


@dataclass(frozen=True, eq=False)
class AppliedWrench:
    """A force [N] and a moment [N m] about a frame's origin.

    Attributes:
        values: (6,) or (N, 6), force first.
        axes: "base" for directions fixed in space, "frame" for directions that turn with the frame.
    """

    values: Array
    axes: Axes = "base"


@dataclass(frozen=True, eq=False)
class JointEffects:
    """Friction, rotors and springs of joints, each (n_s,) in the order of `robot.coordinates`.

    The drive of a joint has to supply

        viscous q' + coulomb q' / sqrt(q'^2 + smoothing^2) + armature q'' + stiffness (q - rest) +
        preload.

    Coulomb's sign(q') is smoothed over rates of about `smoothing`. At ten times that rate 99.5 % of
    `coulomb` act, at rest none. So the model creeps where a real joint sticks. Gyroscopic effects
    of the rotors are not modelled. For the three angles of a ball or free joint q' stands for the
    angular velocity and q for the rotation vector; give all three the same stiffness.

    Attributes:
        viscous: [N m s/rad] of a revolute joint, [N s/m] of a prismatic one.
        coulomb: [N m] or [N].
        smoothing: [rad/s] or [m/s], above zero.
        armature: the rotor's inertia times the square of its gear ratio [kg m^2] or [kg].
        stiffness: [N m/rad] or [N/m].
        rest: [rad] or [m].
        preload: [N m] or [N].

    Raises:
        InputError: an entry is not finite or negative, or a size is wrong.
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
            values = frozen(real_array(name, getattr(self, name)))
            if values.shape != size or values.ndim != 1 or not np.isfinite(values).all():
                raise InputError(
                    f"{name} has shape {values.shape}; expected {size} finite numbers, one a"
                    " coordinate"
                )
            if name not in SIGNED and (values < 0.0).any():
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


@dataclass(frozen=True, eq=False)
class Loads(Picklable):
    """All loads on a robot besides its actuators.

    `robot.loads` is what its description gives.

    Attributes:
        gravity: (3,) [m/s^2] in base axes.
        effects: friction, rotors and springs along the joints.
        payloads: bodies fixed to frames, by the name of the frame.
        wrenches: wrenches by the name of their frame.
    """

    gravity: Array
    effects: JointEffects
    payloads: Mapping[str, tuple[Payload, ...]] = field(default_factory=dict)
    wrenches: Mapping[str, AppliedWrench] = field(default_factory=lambda: MappingProxyType({}))

    def with_payload(self, payload: Payload, frame: str = "end_effector") -> Loads:
        """These loads with one more body fixed to a frame.

        Args:
            payload: the body.
            frame: name of the frame. A link's name is its own frame.
        """
        _require_payload(payload)
        require_type("frame", frame, str, "'end_effector'")
        on_frame = (*self.payloads.get(frame, ()), payload)
        return replace(self, payloads=MappingProxyType({**self.payloads, frame: on_frame}))

    def with_wrench(
        self, wrench: ArrayLike, frame: str = "end_effector", axes: Axes = "base"
    ) -> Loads:
        """These loads with a force and moment on a frame; an earlier one there is replaced.

        Args:
            wrench: (6,) or (N, 6) about the frame's origin, force [N] first, then moment [N m].
            frame: name of the frame.
            axes: "base" for directions fixed in space, "frame" for directions that turn with it.

        Raises:
            InputError: the wrench is not 6 finite numbers, or there are no such axes.
        """
        require_type("frame", frame, str, "'end_effector'")
        values = _wrench_values(wrench, frame)
        if axes not in AXES:
            raise InputError(f"axes is '{axes}'; expected {' or '.join(AXES)}")
        applied = AppliedWrench(values, axes)
        return replace(self, wrenches=MappingProxyType({**self.wrenches, frame: applied}))

    def with_effects(self, **changes: ArrayLike) -> Loads:
        """These loads with other joint effects, each (n_s,), such as viscous=[...]."""
        arrays = {name: real_array(name, values) for name, values in changes.items()}
        return replace(self, effects=replace(self.effects, **arrays))

    def with_gravity(self, gravity: ArrayLike) -> Loads:
        """These loads with another gravity (3,) [m/s^2], base axes."""
        values = frozen(real_array("gravity", gravity))
        if values.shape != (3,) or not np.isfinite(values).all():
            raise InputError(f"gravity has shape {values.shape}; expected 3 finite numbers")
        return replace(self, gravity=values)


def described_loads(description: RobotDescription, coordinates: tuple[str, ...]) -> Loads:
    """The loads that a description gives, with joint effects in the order of `coordinates`."""
    joints = [effects_of(description, name) for name in coordinates]
    arrays: dict[str, Array] = {}
    for name in JointEffects.__dataclass_fields__:
        arrays[name] = frozen([getattr(joint, name) for joint in joints])
    payloads: dict[str, tuple[Payload, ...]] = {}
    for place, payload in description.payloads.values():
        payloads[place] = (*payloads.get(place, ()), payload)
    return Loads(description.gravity, JointEffects(**arrays), MappingProxyType(payloads))


def _require_payload(value: object) -> None:
    if isinstance(value, Payload):
        return
    example = "Payload(10.0)"
    if isinstance(value, (int, float)):
        example = f"Payload({value})"
    raise InputError(f"expected a Payload, such as {example}, got {type(value).__name__}")


def _wrench_values(wrench: ArrayLike, frame: str) -> Array:
    """Check a wrench (6,) or (N, 6) that a caller gives, and copy it."""
    values = frozen(real_array(f"the wrench on '{frame}'", wrench))
    if values.ndim not in (1, 2) or values.shape[-1] != 6 or not np.isfinite(values).all():
        raise InputError(
            f"the wrench on '{frame}' has shape {values.shape}; expected 6 finite numbers, force"
            " then moment"
        )
    return values
