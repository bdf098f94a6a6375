"""Allowed units of each value of a description, by its key."""

from __future__ import annotations

from ..ground.units import coordinate_unit, effort_unit
from .document import Document, KeyPath

Units = tuple[str, ...]

_ANY: Units = ()
_INERTIA: Units = ("kg m^2",)
_BY_KEY: dict[str, Units] = {
    "gravity": ("m/s^2",),
    "mass": ("kg",),
    "com": ("m",),
    "xyz": ("m",),
    "rpy": ("rad",),
    "angle": ("rad",),
    "quat": ("1",),
    "quat_xyzw": ("1",),
    "matrix": ("1",),
    "inertia": _INERTIA,
    "principal": _INERTIA,
    "xx": _INERTIA,
    "yy": _INERTIA,
    "zz": _INERTIA,
    "xy": _INERTIA,
    "xz": _INERTIA,
    "yz": _INERTIA,
    "length": ("m",),
    "radius": ("m",),
    "inner": ("m",),
    "size": ("m",),
    "radii": ("m",),
    "rotor_inertia": _INERTIA,
    "bore": ("m",),
    "rod": ("m",),
    "stroke": ("m",),
    "return_pressure": ("Pa",),
    "supply_pressure": ("Pa",),
    "relief_pressure": ("Pa",),
    "flow_limit": ("m^3/s",),
    "power_limit": ("W",),
    "gravity_compensation": ("1",),
}
_SECTIONS = (
    "links",
    "joints",
    "frames",
    "payloads",
    "actuators",
    "pumps",
    "gravity",
    "end_effector",
)
_STIFFNESS: dict[str, Units] = {  # of the section `stiffness`; entries of matrices are in SI units
    "bulk_modulus": ("Pa",),
    "dead_volume": ("m^3",),
    "tensile_stiffness": ("N",),
    "spans": ("m",),
    "radial": ("N/m",),
    "axial": ("N/m",),
    "tilt": ("N m/rad", "N m"),
    "turn": ("N m/rad", "N m"),
    "E": ("Pa",),
    "G": ("Pa",),
    "A": ("m^2",),
    "Ay": ("m^2",),
    "Az": ("m^2",),
    "Iy": ("m^4",),
    "Iz": ("m^4",),
    "J": ("m^4",),
    "diameter": ("m",),
    "wall": ("m",),
    "width": ("m",),
    "height": ("m",),
    "radius": ("m",),
    "at": ("m",),
    "to": ("m",),
    "start": ("m",),
}
_COORDINATES = ("limits", "offset", "rest", "position")
_RATES = ("velocity_limit", "smoothing", "rate")
_EFFORTS = ("effort_limit", "coulomb", "preload", "effort")
_OF_TURNS: dict[str, Units] = {  # for revolute joints; the radian may be left out
    "viscous": ("N m s/rad", "N m s"),
    "stiffness": ("N m/rad", "N m"),
    "gear_ratio": ("1",),
}
_OF_SLIDES: dict[str, Units] = {
    "viscous": ("N s/m",),
    "stiffness": ("N/m",),
    "gear_ratio": ("rad/m",),
}


def units_at(document: Document, path: KeyPath) -> Units:
    """The allowed units of a value; empty if any unit is allowed.

    Args:
        document: the description.
        path: path of the value.
    """
    keys = [key for key in path if isinstance(key, str)]
    section = keys[0] if keys else ""
    if section == "closures":
        return _at_closure(keys)
    if section == "reference":
        return _of_joint(document, keys[-1], "limits")
    if section == "joints" and len(keys) > 2:
        units = _of_joint(document, keys[1], keys[-1])
        if units:
            return units
    if section == "stiffness":
        return _of_elasticity(document, keys)
    if section in _SECTIONS:
        return _BY_KEY.get(keys[-1], _ANY)
    return _ANY


def _at_closure(keys: list[str]) -> Units:
    """Units at an end of a closure, which is a point or a pose under the name of its link."""
    if len(keys) == 4:
        return ("m",)
    if len(keys) == 5:
        return _BY_KEY.get(keys[4], _ANY)
    return _ANY


def _of_elasticity(document: Document, keys: list[str]) -> Units:
    """Units of the section `stiffness`; those of a drive follow from its joint."""
    if keys[1] == "drives" and (len(keys) == 3 or keys[-1] == "stiffness"):
        return _of_joint(document, keys[2], "stiffness")
    return _STIFFNESS.get(keys[-1], _ANY)


def _of_joint(document: Document, name: str, key: str) -> Units:
    """Units of a joint's limits, efforts and effects, by its type."""
    joint = document.entries("joints").get(name) or {}
    joint_type = joint.get("type")
    if joint_type not in ("revolute", "prismatic"):
        return _ANY
    if key in _COORDINATES:
        return (coordinate_unit(joint_type),)
    if key == "acceleration_limit":
        return (coordinate_unit(joint_type, "/s^2"),)
    if key in _RATES:
        return (coordinate_unit(joint_type, "/s"),)
    if key in _EFFORTS:
        return (effort_unit(joint_type),)
    table = _OF_TURNS if joint_type == "revolute" else _OF_SLIDES
    return table.get(key, _ANY)
