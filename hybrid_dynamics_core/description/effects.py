"""What a description may say of forces beside inertia and gravity: friction, drives, springs, payloads."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..ground.arrays import Array, frozen
from .geometry import TRIANGLE_SLACK, check_inertia

SMOOTHING = (
    1e-3  # [rad/s or m/s] over which Coulomb friction changes sign, unless the file says otherwise
)
Path_ = tuple[str | int, ...]
Number = Callable[[Any, Path_], float]
Inertia = Callable[[Any, float, Path_], Array]


@dataclass(frozen=True)
class JointEffect:
    """What acts along one joint; `hybrid_dynamics_core.JointEffects` gives formula and units."""

    viscous: float = 0.0
    coulomb: float = 0.0
    smoothing: float = SMOOTHING
    rotor_inertia: float = 0.0  # [kg m^2] of the motor's rotor
    gear_ratio: float = 1.0  # rotor rate over joint rate [1, or rad/m]
    stiffness: float = 0.0
    rest: float = 0.0
    preload: float = 0.0

    @property
    def armature(self) -> float:
        """The rotor's inertia as the joint feels it [kg m^2 or kg]."""
        return self.rotor_inertia * self.gear_ratio**2


@dataclass(frozen=True, eq=False)
class Payload:
    """A body fixed to a frame: mass [kg], centre of mass (3,) [m], inertia about it (3, 3) [kg m^2], in frame axes.

    Raises InputError where no rigid body has such an inertia.
    """

    mass: float
    com: ArrayLike = field(default_factory=lambda: frozen(np.zeros(3)))
    inertia: ArrayLike = field(default_factory=lambda: frozen(np.zeros((3, 3))))

    def __post_init__(self) -> None:
        com, inertia = frozen(self.com), frozen(self.inertia)
        if com.shape != (3,) or inertia.shape != (3, 3):
            raise InputError(
                f"a payload has com (3,) and inertia (3, 3), not {com.shape} and {inertia.shape}"
            )
        if not (
            np.isfinite(self.mass)
            and self.mass >= 0.0
            and np.isfinite(com).all()
            and np.isfinite(inertia).all()
        ):
            raise InputError(
                f"a payload has a mass of zero or more and finite numbers, not {self.mass} kg"
            )
        try:
            check_inertia(inertia, TRIANGLE_SLACK)
        except ValueError as error:
            raise InputError(f"payload: {error}") from error
        object.__setattr__(self, "com", com)
        object.__setattr__(self, "inertia", inertia)


def read_effects(joints: Mapping[str, Any], number: Number) -> Mapping[str, JointEffect]:
    """Effects by joint, of the joints whose entries (checked by the schema) give any."""
    found: dict[str, JointEffect] = {}
    for name, entry in joints.items():
        values: dict[str, float] = {}
        for part in ("friction", "drive", "spring"):
            for key, value in (entry.get(part) or {}).items():
                values[key] = number(value, ("joints", name, part, key))
        if values:
            found[name] = JointEffect(**values)
    return MappingProxyType(found)


def check_effects(
    effects: Mapping[str, JointEffect], error: Callable[[Path_, str], Exception]
) -> None:
    """Raise the error at the first value that cannot be."""
    for name, effect in effects.items():
        for part, keys in (("friction", ("viscous", "coulomb")), ("drive", ("rotor_inertia",))):
            for key in keys:
                value = getattr(effect, key)
                if value < 0.0:
                    raise error(
                        ("joints", name, part, key), f"is {value:g}; expected zero or positive"
                    )
        if effect.smoothing <= 0.0:
            problem = (
                f"is {effect.smoothing:g}; expected a rate above zero, over which friction changes"
                " sign"
            )
            raise error(("joints", name, "friction", "smoothing"), problem)


def read_payloads(
    entries: Mapping[str, Any],
    number: Number,
    inertia: Inertia,
    error: Callable[[Path_, str], Exception],
) -> Mapping[str, tuple[str, Payload]]:
    """Frame and body by name."""
    found: dict[str, tuple[str, Payload]] = {}
    for name, entry in entries.items():
        path: Path_ = ("payloads", name)
        mass = number(entry["mass"], (*path, "mass"))
        com = [number(v, (*path, "com", k)) for k, v in enumerate(entry.get("com", [0, 0, 0]))]
        tensor = inertia(entry.get("inertia", {"xx": 0}), mass, (*path, "inertia"))
        try:
            found[name] = (entry["on"], Payload(mass, com, tensor))
        except InputError as problem:
            raise error(path, str(problem)) from problem
    return MappingProxyType(found)
