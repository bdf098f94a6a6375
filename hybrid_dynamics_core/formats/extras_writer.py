"""What a robot says that a format has no words for, as the entries of a description file that would say it.

Each writer puts it where its format lets other programs pass it over; `description.extension` reads
it back.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from typing import Any
from xml.etree.ElementTree import Comment, Element

import numpy as np
import yaml

from ..description.actuators import HydraulicCylinder
from ..description.effects import SMOOTHING, JointEffect, Payload
from ..description.model import Joint, Link, RobotDescription

WORDS = {  # what comments call the entries
    "gravity": "gravity",
    "links": "masses of the base and of massless links",
    "joints": "limits, friction, drives and springs that the format cannot say",
    "loops": "types of loops",
    "closures": "kinds of closures and assembly modes",
    "active": "the active joints",
    "end_effector": "the end effector",
    "payloads": "payloads as such",
    "actuators": "hydraulic cylinders",
    "reference": "the reference configuration",
    "zero": "zero places of joints",
}


def rest_of(robot: RobotDescription, carried: Collection[str]) -> dict[str, Any]:
    """Entries of format 1 beyond what a format carries.

    `carried`, what the format says itself: "gravity", "friction" (viscous and Coulomb), "spring"
    (without preload), "mimic", "one-sided" limits, "unlimited" slides.
    """
    rest: dict[str, Any] = {"source": robot.source}
    if "gravity" not in carried:
        rest["gravity"] = robot.gravity.tolist()
    joints = {name: _joint(robot, joint, carried) for name, joint in robot.joints.items()}
    rest["joints"] = {name: entry for name, entry in joints.items() if entry}
    rest["loops"] = {
        name: {"type": loop.type, "base": loop.base, "arm": loop.arm, "k1": loop.k1, "k2": loop.k2}
        for name, loop in robot.loops.items()
    }
    rest["closures"] = {
        closure.name: (
            {"kind": closure.kind} | ({"assembly": closure.assembly} if closure.assembly else {})
        )
        for closure in robot.closures
    }
    rest["active"] = list(robot.active)
    rest["active_set"] = robot.active_set
    rest["end_effector"] = {"link": robot.end_effector}
    rest["payloads"] = {
        name: _payload(on, payload) for name, (on, payload) in robot.payloads.items()
    }
    rest["actuators"] = {name: _cylinder(cylinder) for name, cylinder in robot.actuators.items()}
    rest["reference"] = dict(robot.reference)
    return {key: value for key, value in rest.items() if value}


def as_text(rest: Mapping[str, Any], one_line: bool = False) -> str:
    """The entries as YAML, every digit of every number."""
    flow = True if one_line else None
    text: str = yaml.dump(
        dict(rest),
        Dumper=_Dumper,
        default_flow_style=flow,
        sort_keys=False,
        width=math.inf,
        allow_unicode=True,
    )
    return text.strip()


def in_words(rest: Mapping[str, Any]) -> str:
    """The entries for a comment."""
    return ", ".join(words for key, words in WORDS.items() if key in rest)


def comment(element: Element, text: str) -> None:
    """Put a comment first in an element; names may hold two hyphens side by side, which comments may not."""
    element.insert(0, Comment(f" {re.sub('-(?=-)', '- ', text)} "))


class _Dumper(yaml.SafeDumper):
    """Repeated lists are written out, since aliases help nobody who reads."""

    def ignore_aliases(self, data: Any) -> bool:  # noqa: ARG002
        return True


def link_entry(link: Link) -> dict[str, Any]:
    """A link as a description file has it."""
    if not link.mass:
        return {}
    return {"mass": link.mass, "com": link.com.tolist(), "inertia": link.inertia.tolist()}


def _joint(robot: RobotDescription, joint: Joint, carried: Collection[str]) -> dict[str, Any]:
    entry: dict[str, Any] = {}
    ends = [math.isfinite(limit) for limit in joint.limits]
    half = any(ends) and not all(ends) and "one-sided" not in carried
    slide = joint.type == "prismatic" and not any(ends) and "unlimited" not in carried
    if half or slide:
        entry["limits"] = list(joint.limits)
    effect = robot.effects.get(joint.name)
    if effect is not None:
        entry |= _effect(effect, carried)
    mimic = robot.mimics.get(joint.name)
    if mimic is not None and "mimic" not in carried:
        entry["mimic"] = {
            "joint": mimic.source,
            "multiplier": mimic.multiplier,
            "offset": mimic.offset,
        }
    return entry


def _effect(effect: JointEffect, carried: Collection[str]) -> dict[str, Any]:
    entry: dict[str, Any] = {}
    friction = (
        {"viscous": effect.viscous, "coulomb": effect.coulomb} if "friction" not in carried else {}
    )
    if effect.smoothing != SMOOTHING:
        friction["smoothing"] = effect.smoothing
    if any(friction.values()):
        entry["friction"] = friction
    if effect.rotor_inertia:
        entry["drive"] = {"rotor_inertia": effect.rotor_inertia, "gear_ratio": effect.gear_ratio}
    spring = {"stiffness": effect.stiffness, "rest": effect.rest} if "spring" not in carried else {}
    if effect.preload:
        spring["preload"] = effect.preload
    if any(spring.values()):
        entry["spring"] = spring
    return entry


def _payload(on: str, payload: Payload) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "on": on,
        "mass": payload.mass,
        "com": np.asarray(payload.com).tolist(),
    }
    return entry | {"inertia": np.asarray(payload.inertia).tolist()}


def _cylinder(cylinder: HydraulicCylinder) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "kind": "hydraulic_cylinder",
        "bore": cylinder.bore,
        "rod": cylinder.rod,
        "stroke": list(cylinder.stroke),
        "count": cylinder.count,
        "pulls": cylinder.sign < 0.0,
        "return_pressure": cylinder.return_pressure,
        "supply_pressure": cylinder.supply_pressure,
    }
    return {
        key: value for key, value in entry.items() if value not in ([-math.inf, math.inf], math.inf)
    }
