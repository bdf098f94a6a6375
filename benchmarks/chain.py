"""Chains of four-bar stages: each stands on the rocker of the one before, turned by a right angle."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.description.geometry import rotation_from_rpy
from hybrid_dynamics_core.description.model import Closure, Frame, Joint, Link, RobotDescription
from hybrid_dynamics_core.ground.arrays import frozen

LINKS = 3  # of a stage


def chain(stages: int) -> Robot:
    """A robot of `stages` cranks, couplers and rockers; the cranks are active."""
    joints, links, closures = {}, {"base": Link("base")}, []
    reference: dict[str, float] = {}
    stand = "base"
    for k in range(stages):
        turned = frozen(rotation_from_rpy(np.pi / 2, 0.0, 0.0) if k else np.eye(3))
        crank, coupler, rocker = (f"{part}{k}" for part in ("crank", "coupler", "rocker"))
        foot = frozen([0.1, 0.0, 0.0])
        for joint, parent, child, rotation, place in (
            (f"a{k}", stand, crank, turned, foot),
            (f"b{k}", crank, coupler, frozen(np.eye(3)), frozen([0.2, 0.0, 0.0])),
            (f"c{k}", stand, rocker, turned, frozen(foot + turned @ [0.35, 0.0, 0.0])),
        ):
            joints[joint] = Joint(
                joint, "revolute", parent, child, rotation, place, frozen([0.0, 0.0, 1.0])
            )
        for name, mass, length in ((crank, 1.0, 0.2), (coupler, 1.5, 0.4), (rocker, 2.0, 0.3)):
            inertia = np.diag([0.001, mass * length**2 / 12.0, mass * length**2 / 12.0])
            links[name] = Link(name, mass, frozen([length / 2.0, 0.01, 0.02]), frozen(inertia))
        pin = (frozen([0.4, 0.0, 0.0]), frozen([0.3, 0.0, 0.0]))
        closures.append(
            Closure(f"pin{k}", coupler, pin[0], rocker, pin[1], assembly="counterclockwise")
        )
        reference |= {f"a{k}": 1.2, f"b{k}": -0.9, f"c{k}": 1.4}
        stand = rocker
    return Robot(
        RobotDescription(
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
            frames=MappingProxyType({"end_effector": Frame(stand)}),
            reference=MappingProxyType(reference),
        )
    )
