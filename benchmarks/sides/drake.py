"""Drake's inverse dynamics of the open tree, with the closure by hand."""

from __future__ import annotations

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    MultibodyForces,
    PrismaticJoint,
    RevoluteJoint,
    SpatialInertia,
    UnitInertia,
)

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.description import RobotDescription

from ..closed_form import COORDINATES, linear, positions, projected, quadratic, triangles
from ..side import Side

Array = np.ndarray


def build(robot: RobotDescription) -> MultibodyPlant:
    """The open tree."""
    plant = MultibodyPlant(0.0)
    plant.mutable_gravity_field().set_gravity_vector(np.array(robot.gravity))
    bodies = {robot.base: plant.world_body()}

    def add(parent: str) -> None:
        for name, joint in robot.joints.items():
            if joint.parent != parent:
                continue
            link = robot.links[joint.child]
            com = np.array(link.com)
            about = np.array(link.inertia) / link.mass + com @ com * np.eye(3) - np.outer(com, com)
            unit = UnitInertia(*about.diagonal(), about[0, 1], about[0, 2], about[1, 2])
            body = plant.AddRigidBody(
                joint.child, SpatialInertia(link.mass, com, unit, skip_validity_check=True)
            )
            bodies[joint.child] = body
            place = RigidTransform(
                RotationMatrix(np.array(joint.rotation)), np.array(joint.translation)
            )
            frame = plant.AddFrame(
                FixedOffsetFrame(f"{name} frame", bodies[parent].body_frame(), place)
            )
            kind = RevoluteJoint if joint.type == "revolute" else PrismaticJoint
            plant.AddJoint(kind(name, frame, body.body_frame(), np.array(joint.axis)))
            add(joint.child)

    add(robot.base)
    plant.Finalize()
    return plant


class ByHand:
    """The closure by hand, CalcInverseDynamics for the tree."""

    def __init__(self, robot: Robot) -> None:
        self.plant = build(robot.description)
        self.context = self.plant.CreateDefaultContext()
        self.place = np.array(
            [self.plant.GetJointByName(name).velocity_start() for name in COORDINATES]
        )
        self.forces = MultibodyForces(self.plant)
        self.state, self.a = np.zeros(24), np.zeros(12)

    def inverse_dynamics(self, u: Array, du: Array, ddu: Array) -> Array:
        """Gravity as a force element, then the tree's inverse dynamics."""
        plant, context, place = self.plant, self.context, self.place
        q = u.tolist()
        v = du.tolist()
        t1, t2 = triangles(q)
        self.state[place] = positions(q, t1, t2)
        self.state[12 + place] = linear(v, t1, t2)
        a = linear(ddu.tolist(), t1, t2)
        self.a[place] = [x + y for x, y in zip(a, quadratic(v, t1, t2), strict=True)]
        plant.SetPositionsAndVelocities(context, self.state)
        plant.CalcForceElementsContribution(context, self.forces)
        force = plant.CalcInverseDynamics(context, self.a, self.forces)
        return np.array(projected(force[place].tolist(), t1, t2))


def sides(robot: Robot) -> list[Side]:
    """CalcInverseDynamics."""
    return [
        Side("Drake CalcInverseDynamics, closure by hand", {"id": ByHand(robot).inverse_dynamics})
    ]
