"""Forces beside inertia and gravity, as frozen data: friction, drives, springs, payloads."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..ground.arrays import frozen
from ..ground.check_arguments import real_number
from ..ground.check_arrays import real_array
from .rigid_body import TRIANGLE_SLACK, impossibility, symmetric_inertia

SMOOTHING = 1e-3  # [rad/s or m/s] over which Coulomb friction changes sign by default

_ZERO_VECTOR = frozen(np.zeros(3))
_ZERO_MATRIX = frozen(np.zeros((3, 3)))


@dataclass(frozen=True)
class JointEffect:
    """Friction, rotor and spring of a joint; `hybrid_dynamics_core.JointEffects` has the formula.

    Attributes:
        viscous, coulomb: friction.
        smoothing: [rad/s or m/s] over which Coulomb friction changes sign.
        rotor_inertia: [kg m^2] of the motor's rotor.
        gear_ratio: rotor rate over joint rate [1, or rad/m].
        stiffness, rest, preload: of a spring.
    """

    viscous: float = 0.0
    coulomb: float = 0.0
    smoothing: float = SMOOTHING
    rotor_inertia: float = 0.0
    gear_ratio: float = 1.0
    stiffness: float = 0.0
    rest: float = 0.0
    preload: float = 0.0

    @property
    def armature(self) -> float:
        """The rotor's inertia reflected through the gear [kg m^2 or kg]."""
        return self.rotor_inertia * self.gear_ratio**2


@dataclass(frozen=True, eq=False)
class Payload:
    """A body fixed to a frame.

    Attributes:
        mass: [kg].
        com: (3,) [m] centre of mass, in the frame.
        inertia: (3, 3) [kg m^2] about the centre of mass, in frame axes.
        strict: whether an inertia that no rigid body has is refused.

    Raises:
        InputError: no rigid body has these numbers.
    """

    mass: float
    com: ArrayLike = field(default_factory=lambda: _ZERO_VECTOR)
    inertia: ArrayLike = field(default_factory=lambda: _ZERO_MATRIX)
    strict: bool = True

    def __post_init__(self) -> None:
        mass = real_number("mass", self.mass)
        com = frozen(real_array("com", self.com))
        inertia = frozen(real_array("inertia", self.inertia))
        if com.shape != (3,) or inertia.shape != (3, 3):
            raise InputError(
                f"a payload has com (3,) and inertia (3, 3), not {com.shape} and {inertia.shape}"
            )
        numbers = (mass, *com, *inertia.ravel())
        if mass < 0.0 or not np.isfinite(numbers).all():
            raise InputError(
                f"a payload has a mass of zero or more and finite numbers, not {self.mass} kg"
            )
        try:
            inertia, _ = symmetric_inertia(inertia)
        except ValueError as error:
            raise InputError(f"payload: {error}") from error
        problem = impossibility(inertia, TRIANGLE_SLACK)
        if self.strict and problem:
            raise InputError(f"payload: {problem}")
        object.__setattr__(self, "com", com)
        object.__setattr__(self, "inertia", inertia)
