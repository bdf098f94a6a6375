"""What a description says of forces, read: effects along joints, payloads, hydraulic cylinders."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from ..errors import InputError
from .actuators import HydraulicCylinder
from .document import Data
from .effects import JointEffect, Payload
from .entries import Entry, section_entries
from .geometry import TRIANGLE_SLACK
from .inertia import read_inertia
from .values import ValueReader

_EFFECT_PARTS = ("friction", "drive", "spring")
_CYLINDER_NUMBERS = ("bore", "rod", "return_pressure", "supply_pressure")


def read_effects(values: ValueReader) -> Mapping[str, JointEffect]:
    """Effects by joint, of the joints whose entries give any.

    Raises:
        DescriptionError: a value that cannot be.
    """
    effects: dict[str, JointEffect] = {}
    joints = section_entries(values, "joints")
    for name, joint in joints.items():
        numbers: dict[str, float] = {}
        for part in map(joint.sub, _EFFECT_PARTS):
            for key in part:
                numbers[key] = part.number(key)
        if numbers:
            effects[name] = JointEffect(**numbers)
    for name, effect in effects.items():
        _check_effect(joints[name], effect)
    return MappingProxyType(effects)


def read_payloads(values: ValueReader) -> Mapping[str, tuple[str, Payload]]:
    """Frame and body of every payload, by name.

    Raises:
        DescriptionError: no rigid body has the numbers of a payload.
    """
    payloads: dict[str, tuple[str, Payload]] = {}
    for name, entry in section_entries(values, "payloads").items():
        mass = entry.number("mass")
        com = entry.vector("com")
        inertia = read_inertia(entry, mass, TRIANGLE_SLACK)
        try:
            payload = Payload(mass, com, inertia)
        except InputError as error:
            raise values.document.error(entry.path, str(error)) from error
        payloads[name] = (entry["on"], payload)
    return MappingProxyType(payloads)


def read_actuators(values: ValueReader) -> Mapping[str, HydraulicCylinder]:
    """Cylinders by joint.

    Raises:
        DescriptionError: an actuator without a prismatic joint, or a value that cannot be.
    """
    cylinders: dict[str, HydraulicCylinder] = {}
    joints = values.document.data["joints"]
    for name, entry in section_entries(values, "actuators").items():
        if name not in joints:
            raise values.document.error(
                entry.path, f"there is no joint '{name}'; an actuator has the name of its joint"
            )
        joint_type = joints[name]["type"]
        if joint_type != "prismatic":
            raise values.document.error(
                entry.path, f"joint '{name}' is {joint_type}; a cylinder sits on a prismatic joint"
            )
        cylinders[name] = _read_cylinder(name, entry)
    return MappingProxyType(cylinders)


def _check_effect(joint: Entry, effect: JointEffect) -> None:
    friction = joint.sub("friction")
    _require_not_negative(friction, "viscous", effect.viscous)
    _require_not_negative(friction, "coulomb", effect.coulomb)
    _require_not_negative(joint.sub("drive"), "rotor_inertia", effect.rotor_inertia)
    if effect.smoothing <= 0.0:
        raise friction.error(
            "smoothing",
            f"is {effect.smoothing:g}; expected a rate above zero, over which friction changes"
            " sign",
        )


def _require_not_negative(entry: Entry, key: str, number: float) -> None:
    if number < 0.0:
        raise entry.error(key, f"is {number:g}; expected zero or positive")


def _read_cylinder(joint: str, entry: Entry) -> HydraulicCylinder:
    fields: Data = {"joint": joint, "count": entry.get("count", 1)}
    for key in _CYLINDER_NUMBERS:
        if key in entry:
            fields[key] = entry.number(key)
    if "stroke" in entry:
        fields["stroke"] = tuple(entry.vector("stroke").tolist())
    if entry.get("pulls"):
        fields["sign"] = -1.0
    cylinder = HydraulicCylinder(**fields)
    _check_cylinder(entry, cylinder)
    return cylinder


def _check_cylinder(entry: Entry, cylinder: HydraulicCylinder) -> None:
    if not 0.0 <= cylinder.rod < cylinder.bore:
        raise entry.error(
            "rod",
            f"is {cylinder.rod:g} m; expected zero up to less than the bore, {cylinder.bore:g} m",
        )
    lower, upper = cylinder.stroke
    if not lower < upper:
        raise entry.error("stroke", f"the lower end {lower:g} is not below the upper end {upper:g}")
    if not 0.0 <= cylinder.return_pressure < cylinder.supply_pressure:
        raise entry.error(
            "return_pressure",
            f"{cylinder.return_pressure:g} Pa has to lie from zero to less than the supply"
            " pressure",
        )
