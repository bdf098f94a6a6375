"""Chains of four-bar stages.

Each stage stands on the rocker of the one before, turned by a right angle.
"""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.description.geometry import rotation_from_rpy
from hybrid_dynamics_core.description.model import Closure, Frame, Joint, Link, RobotDescription
from hybrid_dynamics_core.ground.arrays import frozen

CRANK, COUPLER, ROCKER = 0.2, 0.4, 0.3  # [m] lengths of a stage's links
BASE = 0.35  # [m] between the pins on the link that it stands on
NO_ROTATION = frozen(np.eye(3))
AXIS = frozen([0.0, 0.0, 1.0])


def chain(stages: int) -> Robot:
    """A robot of so many cranks, couplers and rockers; the cranks are active."""
    joints: dict[str, Joint] = {}
    links = {"base": Link("base")}
    closures = []
    reference: dict[str, float] = {}
    parent = "base"
    for k in range(stages):
        joints |= _joints(k, parent)
        links |= _links(k)
        closures.append(_pin(k))
        reference |= {f"a{k}": 1.2, f"b{k}": -0.9, f"c{k}": 1.4}
        parent = f"rocker{k}"
    description = RobotDescription(
        name=f"chain{stages}",
        source="generated",
        gravity=frozen([0.0, 0.0, -9.81]),
        base="base",
        links=MappingProxyType(links),
        joints=MappingProxyType(joints),
        closures=tuple(closures),
        loops=MappingProxyType({}),
        active=tuple(f"a{k}" for k in range(stages)),
        end_effector="end_effector",
        frames=MappingProxyType({"end_effector": Frame(parent)}),
        reference=MappingProxyType(reference),
    )
    return Robot(description)


def _joints(k: int, parent: str) -> dict[str, Joint]:
    """The joints of stage k: a of the crank, b of the coupler, c of the rocker."""
    turned = NO_ROTATION
    if k:
        turned = frozen(rotation_from_rpy(np.pi / 2, 0.0, 0.0))
    foot = frozen([0.1, 0.0, 0.0])
    other_foot = frozen(foot + turned @ [BASE, 0.0, 0.0])
    crank_end = frozen([CRANK, 0.0, 0.0])
    return {
        f"a{k}": Joint(f"a{k}", "revolute", parent, f"crank{k}", turned, foot, AXIS),
        f"b{k}": Joint(
            f"b{k}", "revolute", f"crank{k}", f"coupler{k}", NO_ROTATION, crank_end, AXIS
        ),
        f"c{k}": Joint(f"c{k}", "revolute", parent, f"rocker{k}", turned, other_foot, AXIS),
    }


def _links(k: int) -> dict[str, Link]:
    """Slender links with a small offset of their centres of mass."""
    links = {}
    for part, mass, length in (
        ("crank", 1.0, CRANK),
        ("coupler", 1.5, COUPLER),
        ("rocker", 2.0, ROCKER),
    ):
        across = mass * length**2 / 12.0
        inertia = frozen(np.diag([0.001, across, across]))
        centre = frozen([length / 2.0, 0.01, 0.02])
        links[f"{part}{k}"] = Link(f"{part}{k}", mass, centre, inertia)
    return links


def _pin(k: int) -> Closure:
    """The pin that joins coupler and rocker."""
    coupler_end = frozen([COUPLER, 0.0, 0.0])
    rocker_end = frozen([ROCKER, 0.0, 0.0])
    return Closure(
        f"pin{k}",
        f"coupler{k}",
        coupler_end,
        f"rocker{k}",
        rocker_end,
        assembly="counterclockwise",
    )
