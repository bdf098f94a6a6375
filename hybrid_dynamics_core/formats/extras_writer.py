"""Writer of extras: data that a format cannot express, as entries of a description file.

Each format's writer puts them where other programs ignore them. `extras_reader` reads them.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from enum import Enum, auto
from typing import Any

import numpy as np
import yaml

from ..description.actuators import EffortTable, HydraulicCylinder, Pump, Transmission
from ..description.document import Data
from ..description.effects import SMOOTHING, JointEffect, Payload
from ..description.followers import mimic_entry
from ..description.model import (
    Closure,
    Joint,
    Link,
    Loop,
    Mimic,
    MultiDofJoint,
    RobotDescription,
)
from ..ground.arrays import Array
from .stiffness_writer import stiffness_entry

_DESCRIPTIONS = {  # names of the entries in comments
    "gravity": "gravity",
    "links": "links whose mass, inertia or weight the format cannot say",
    "joints": "limits, friction, drives, springs and followers that the format cannot say",
    "loops": "types of loops",
    "closures": "kinds of closures and assembly modes",
    "active": "the active joints",
    "idle": "the idle joints",
    "end_effector": "the end effector",
    "payloads": "payloads as such",
    "actuators": "hydraulic cylinders",
    "transmissions": "drives that move several joints",
    "pumps": "pumps",
    "stiffness": "stiffness of drives, pins and links",
    "reference": "the reference configuration",
    "multi_dof": "joints of several freedoms",
    "zero": "zero places of joints",
}


class Feature(Enum):
    """Data that only some formats can express."""

    GRAVITY = auto()
    WEIGHT_SHARES = auto()  # shares of weights of links that are compensated
    NO_WEIGHT = auto()  # links without weight
    FRICTION = auto()  # viscous and Coulomb
    SPRING = auto()  # without preload
    MIMIC = auto()  # followers of one joint
    MIMIC_OF_SEVERAL = auto()
    ONE_SIDED_LIMITS = auto()
    UNLIMITED_SLIDES = auto()
    EFFORT_LIMITS = auto()
    VELOCITY_LIMITS = auto()


def extras_of(robot: RobotDescription, features: Collection[Feature]) -> Data:
    """Entries of format 1 for all data that a format cannot express.

    Args:
        robot: the robot to write.
        features: data that the format expresses.
    """
    extras: Data = {"source": robot.source}
    if Feature.GRAVITY not in features:
        extras["gravity"] = robot.gravity.tolist()
    extras["links"] = _link_entries(robot, features)
    extras["joints"] = _joint_entries(robot, features)
    extras["loops"] = {loop.name: _loop_entry(loop) for loop in robot.loops.values()}
    extras["closures"] = {closure.name: _closure_entry(closure) for closure in robot.closures}
    extras["active"] = list(robot.motors)
    extras["idle"] = list(robot.idle)
    extras["active_set"] = robot.active_set
    extras["end_effector"] = {"link": robot.end_effector}
    extras["payloads"] = _payload_entries(robot)
    extras["actuators"] = _cylinder_entries(robot)
    extras["transmissions"] = _transmission_entries(robot)
    extras["pumps"] = {name: _pump_entry(pump) for name, pump in robot.pumps.items()}
    extras["stiffness"] = stiffness_entry(robot.stiffness, str)
    extras["reference"] = dict(robot.plain_reference)
    extras["multi_dof"] = {joint.name: _row_entry(joint) for joint in robot.multi_dof.values()}
    return without_empty(extras)


def extras_text(extras: Data, one_line: bool = False) -> str:
    """The entries as YAML, with every digit of every number."""
    flow_style = True if one_line else None
    text: str = yaml.dump(
        dict(extras),
        Dumper=_Dumper,
        default_flow_style=flow_style,
        sort_keys=False,
        width=math.inf,
        allow_unicode=True,
    )
    return text.strip()


def extras_summary(extras: Data) -> str:
    """A list of the entries as text, for a comment."""
    return ", ".join(text for key, text in _DESCRIPTIONS.items() if key in extras)


def without_empty(entries: Data) -> Data:
    """Entries without those that are zero, none or empty."""
    return {key: value for key, value in entries.items() if value}


def link_entry(link: Link) -> Data:
    """The entry of a link in a description file."""
    if not link.mass and not link.inertia.any():
        return {}
    return {
        "mass": link.mass,
        "com": link.com.tolist(),
        "inertia": link.inertia.tolist(),
        **compensation_entry(link, link.compensated_com),
    }


def compensation_entry(link: Link, com: Array) -> Data:
    """The entry of the compensated weight of a link; empty if there is none.

    Args:
        link: the link.
        com: centre (3,) of the compensated mass [m], in the frame of the entry.
    """
    if not link.compensated_mass:
        return {}
    share = link.gravity_compensation
    if share is not None:
        return {"gravity_compensation": share}
    part = {"mass": link.compensated_mass, "com": com.tolist()}
    return {"gravity_compensation": part}


def _link_entries(robot: RobotDescription, features: Collection[Feature]) -> Data:
    """Entries of links whose weight the format cannot express."""
    entries: Data = {}
    for name, link in robot.links.items():
        share = link.gravity_compensation
        is_said = Feature.WEIGHT_SHARES in features and share is not None
        is_said |= Feature.NO_WEIGHT in features and share == 1.0
        if share != 0.0 and not is_said:
            entries[name] = link_entry(link)
    return entries


class _Dumper(yaml.SafeDumper):
    """YAML dumper that writes repeated lists out, without aliases."""

    def ignore_aliases(self, data: Any) -> bool:  # noqa: ARG002
        return True


def _joint_entries(robot: RobotDescription, features: Collection[Feature]) -> Data:
    entries: Data = {}
    for name, joint in robot.joints.items():
        entry: Data = {}
        if _limits_are_extra(joint, features):
            entry["limits"] = list(joint.limits)
        if math.isfinite(joint.effort_limit) and Feature.EFFORT_LIMITS not in features:
            entry["effort_limit"] = joint.effort_limit
        if math.isfinite(joint.velocity_limit) and Feature.VELOCITY_LIMITS not in features:
            entry["velocity_limit"] = joint.velocity_limit
        entry |= drive_limit_entries(joint)
        if name in robot.effects:
            entry |= _effect_entries(robot.effects[name], _features_of(robot, name, features))
        if name in robot.mimics and _mimic_feature(robot.mimics[name]) not in features:
            mimic = robot.mimics[name]
            entry["mimic"] = mimic_entry(dict(mimic.multipliers), mimic.offset)
        entries[name] = entry
    return without_empty(entries)


def drive_limit_entries(joint: Joint) -> Data:
    """Limits of a drive that only description files have."""
    entry: Data = {"power_limit": joint.power_limit}
    entry["acceleration_limit"] = joint.acceleration_limit
    entry = {key: value for key, value in entry.items() if math.isfinite(value)}
    if joint.effort_table is not None:
        entry["effort_table"] = _table_entry(joint.effort_table)
    return entry


def _table_entry(table: EffortTable) -> Data:
    entry: Data = {"rate": table.rates.tolist()}
    if len(table.positions) == 1:
        return entry | {"effort": table.efforts[0].tolist()}
    entry["position"] = table.positions.tolist()
    return entry | {"effort": table.efforts.tolist()}


def _features_of(
    robot: RobotDescription, joint: str, features: Collection[Feature]
) -> Collection[Feature]:
    """What a format says of a joint: it has no springs of rotation vectors."""
    if joint not in robot.angles_in_rows:
        return features
    return [feature for feature in features if feature != Feature.SPRING]


def _limits_are_extra(joint: Joint, features: Collection[Feature]) -> bool:
    """Whether a format cannot express a joint's limits: one-sided or missing ones."""
    lower, upper = map(math.isfinite, joint.limits)
    if lower != upper:
        return Feature.ONE_SIDED_LIMITS not in features
    is_unlimited_slide = joint.type == "prismatic" and not lower
    return is_unlimited_slide and Feature.UNLIMITED_SLIDES not in features


def _effect_entries(effect: JointEffect, features: Collection[Feature]) -> Data:
    entries: Data = {}
    friction: dict[str, float] = {}
    if Feature.FRICTION not in features:
        friction = {"viscous": effect.viscous, "coulomb": effect.coulomb}
    if effect.smoothing != SMOOTHING:
        friction["smoothing"] = effect.smoothing
    if any(friction.values()):
        entries["friction"] = friction
    if effect.rotor_inertia:
        entries["drive"] = {"rotor_inertia": effect.rotor_inertia, "gear_ratio": effect.gear_ratio}
    spring: dict[str, float] = {}
    if Feature.SPRING not in features:
        spring = {"stiffness": effect.stiffness, "rest": effect.rest}
    if effect.preload:
        spring["preload"] = effect.preload
    if any(spring.values()):
        entries["spring"] = spring
    return entries


def _mimic_feature(mimic: Mimic) -> Feature:
    """The feature that a format needs for a follower."""
    return Feature.MIMIC if len(mimic.multipliers) == 1 else Feature.MIMIC_OF_SEVERAL


def _row_entry(joint: MultiDofJoint) -> Data:
    return {"type": joint.type, "joints": list(joint.joints)}


def _loop_entry(loop: Loop) -> Data:
    return {
        "type": loop.type,
        "base": loop.base,
        "arm": loop.arm,
        "k1": loop.k1,
        "k2": loop.k2,
    }


def _closure_entry(closure: Closure) -> Data:
    entry: Data = {"kind": closure.kind}
    if closure.assembly:
        entry["assembly"] = closure.assembly
    return entry


def _payload_entries(robot: RobotDescription) -> Data:
    entries: Data = {}
    for name, (frame, payload) in robot.payloads.items():
        entries[name] = _payload_entry(frame, payload)
    return entries


def _payload_entry(frame: str, payload: Payload) -> Data:
    return {
        "on": frame,
        "mass": payload.mass,
        "com": np.asarray(payload.com).tolist(),
        "inertia": np.asarray(payload.inertia).tolist(),
    }


def _cylinder_entries(robot: RobotDescription) -> Data:
    entries: Data = {}
    for joint, cylinder in robot.actuators.items():
        entries[joint] = _cylinder_entry(cylinder)
    return entries


def _transmission_entries(robot: RobotDescription) -> Data:
    entries: Data = {}
    for name, transmission in robot.transmissions.items():
        entries[name] = _transmission_entry(transmission)
    return entries


def _transmission_entry(transmission: Transmission) -> Data:
    entry: Data = {"joints": dict(transmission.multipliers)}
    if transmission.offset:
        entry["offset"] = transmission.offset
    if math.isfinite(transmission.effort_limit):
        entry["effort_limit"] = transmission.effort_limit
    return entry


def _pump_entry(pump: Pump) -> Data:
    limits = {"flow_limit": pump.flow_limit, "power_limit": pump.power_limit}
    finite = {key: value for key, value in limits.items() if math.isfinite(value)}
    return {"cylinders": list(pump.cylinders), **finite}


def _cylinder_entry(cylinder: HydraulicCylinder) -> Data:
    entry: Data = {
        "kind": "hydraulic_cylinder",
        "bore": cylinder.bore,
        "rod": cylinder.rod,
        "stroke": list(cylinder.stroke),
        "count": cylinder.count,
        "pulls": cylinder.sign < 0.0,
        "return_pressure": cylinder.return_pressure,
        "supply_pressure": cylinder.supply_pressure,
    }
    if cylinder.stroke == (-math.inf, math.inf):
        del entry["stroke"]
    entry["relief_pressure"] = cylinder.relief_pressure
    entry["flow_limit"] = cylinder.flow_limit
    for key in ("supply_pressure", "relief_pressure", "flow_limit"):
        if entry[key] == math.inf:
            del entry[key]
    return entry
