"""Readers for joint effects, payloads and hydraulic cylinders of a description file."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from ..errors import InputError
from ..ground.suggestions import no_such_name
from .actuators import HydraulicCylinder, Transmission
from .document import Data
from .effects import JointEffect, Payload
from .entries import Entry, section_entries
from .inertia import read_inertia
from .rigid_body import TRIANGLE_SLACK
from .values import ValueReader

_EFFECT_PARTS = ("friction", "drive", "spring")
_CYLINDER_NUMBERS = ("bore", "rod", "return_pressure", "supply_pressure")
_CYLINDER_BOUNDS = ("relief_pressure", "flow_limit")


def read_effects(values: ValueReader) -> Mapping[str, JointEffect]:
    """Friction, rotors and springs of all joints that have any.

    Args:
        values: reader of the values of a validated document.

    Returns:
        Effects by joint.

    Raises:
        DescriptionError: a number is not finite; friction or a rotor's inertia is negative; the
            smoothing is not above zero.
    """
    effects: dict[str, JointEffect] = {}
    joints = section_entries(values, "joints")
    for name, joint in joints.items():
        numbers: dict[str, float] = {}
        for part in map(joint.sub, _EFFECT_PARTS):
            for key in part:
                numbers[key] = part.number(key)
        if numbers:
            effects[name] = JointEffect(**numbers)  # the schema's keys are the names of its fields
    for name, effect in effects.items():
        _check_effect(joints[name], effect)
    return MappingProxyType(effects)


def read_payloads(values: ValueReader) -> Mapping[str, tuple[str, Payload]]:
    """Payloads and the frames that carry them.

    Args:
        values: reader of the values of a validated document.

    Returns:
        (name of the frame, payload) by name of the payload.

    Raises:
        DescriptionError: a number is not finite, or no rigid body has the numbers of a payload.
    """
    payloads: dict[str, tuple[str, Payload]] = {}
    for name, entry in section_entries(values, "payloads").items():
        mass = entry.number("mass")
        com = entry.vector("com")
        inertia = read_inertia(entry, mass, TRIANGLE_SLACK)
        try:
            payload = Payload(mass, com, inertia, strict=False)
        except InputError as error:
            raise values.document.error(entry.path, str(error)) from error
        payloads[name] = (entry["on"], payload)
    return MappingProxyType(payloads)


def read_actuators(values: ValueReader) -> Mapping[str, HydraulicCylinder]:
    """Hydraulic cylinders.

    Args:
        values: reader of the values of a validated document.

    Returns:
        Cylinders by joint.

    Raises:
        DescriptionError: an actuator's joint is missing or not prismatic, the rod is not thinner
            than the bore, the stroke is not ascending, or the return pressure is negative or not
            below the supply pressure.
    """
    cylinders: dict[str, HydraulicCylinder] = {}
    joints = values.document.data["joints"]
    for name, entry in section_entries(values, "actuators").items():
        if name not in joints:
            raise values.document.error(
                entry.path,
                f"there is no joint '{name}'; expected the name of the actuator's joint",
            )
        joint_type = joints[name]["type"]
        if joint_type != "prismatic":
            raise values.document.error(
                entry.path,
                f"is on joint '{name}', which is {joint_type}; expected a prismatic joint",
            )
        cylinders[name] = _read_cylinder(name, entry)
    return MappingProxyType(cylinders)


def read_transmissions(values: ValueReader) -> Mapping[str, Transmission]:
    """Drives that move several joints.

    Args:
        values: reader of the values of a validated document.

    Returns:
        Transmissions by the name of the drive.

    Raises:
        DescriptionError: a joint is not there or does not move, a multiplier is zero, or a drive
            has the name of a joint.
    """
    transmissions: dict[str, Transmission] = {}
    joints = values.document.data["joints"]
    moving = [name for name, joint in joints.items() if joint["type"] != "fixed"]
    for name, entry in section_entries(values, "transmissions").items():
        if name in joints:
            raise values.document.error(entry.path, f"'{name}' is the name of a joint too")
        multipliers: dict[str, float] = {}
        factors = entry.sub("joints")
        for joint in factors:
            if joint not in moving:
                raise factors.error(joint, no_such_name("joint", joint, moving))
            multipliers[joint] = factors.number(joint)
            if not multipliers[joint]:
                raise factors.error(joint, "is 0; expected the rate of the drive per rate of it")
        transmissions[name] = Transmission(
            MappingProxyType(multipliers), entry.number("offset"), entry.bound("effort_limit")
        )
    return MappingProxyType(transmissions)


def _check_effect(joint: Entry, effect: JointEffect) -> None:
    """Raise a DescriptionError for a number that is not allowed."""
    friction = joint.sub("friction")
    _require_not_negative(friction, "viscous", effect.viscous)
    _require_not_negative(friction, "coulomb", effect.coulomb)
    _require_not_negative(joint.sub("drive"), "rotor_inertia", effect.rotor_inertia)
    if effect.smoothing <= 0.0:
        raise friction.error(
            "smoothing",
            f"is {effect.smoothing:g}; expected a rate [rad/s or m/s] above zero, over which"
            " Coulomb friction changes sign",
        )


def _require_not_negative(entry: Entry, key: str, number: float, unit: str = "") -> None:
    if number < 0.0:
        quantity = f"{number:g} {unit}".rstrip()
        raise entry.error(key, f"is {quantity}; expected zero or positive")


def _read_cylinder(joint: str, entry: Entry) -> HydraulicCylinder:
    """The cylinder of an entry; keys that are left out have the defaults of the class."""
    fields: Data = {"joint": joint, "count": entry.get("count", 1)}
    for key in _CYLINDER_NUMBERS:
        if key in entry:
            fields[key] = entry.number(key)
    for key in _CYLINDER_BOUNDS:
        fields[key] = entry.bound(key)
    if "stroke" in entry:
        fields["stroke"] = tuple(entry.vector("stroke").tolist())
    if entry.get("pulls"):
        fields["sign"] = -1.0
    cylinder = HydraulicCylinder(**fields)  # the keys read above are the names of its fields
    _check_cylinder(entry, cylinder)
    return cylinder


def _check_cylinder(entry: Entry, cylinder: HydraulicCylinder) -> None:
    """Raise a DescriptionError for impossible sizes."""
    if not 0.0 <= cylinder.rod < cylinder.bore:
        raise entry.error(
            "rod",
            f"is {cylinder.rod:g} m; expected zero up to less than the bore, {cylinder.bore:g} m",
        )
    lower, upper = cylinder.stroke
    if not lower < upper:
        raise entry.error(
            "stroke", f"is [{lower:g}, {upper:g}] m; expected the lower end below the upper one"
        )
    pressure = cylinder.return_pressure
    _require_not_negative(entry, "return_pressure", pressure, "Pa")
    for key in ("supply_pressure", "relief_pressure"):
        highest = getattr(cylinder, key)
        if not pressure < highest:
            what = key.replace("_", " ")
            problem = f"is {pressure:g} Pa; expected less than the {what}, {highest:g} Pa"
            raise entry.error("return_pressure", problem)
