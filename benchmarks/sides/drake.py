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
from hybrid_dynamics_core.description.model import Link

from ..closed_form import COORDINATES, linear, positions, projected, quadratic, triangles
from ..side import Side

Array = np.ndarray


JOINTS = {"revolute": RevoluteJoint, "prismatic": PrismaticJoint}


def build(robot: RobotDescription) -> MultibodyPlant:
    """The open tree."""
    plant = MultibodyPlant(0.0)
    plant.mutable_gravity_field().set_gravity_vector(np.array(robot.gravity))
    bodies = {robot.base: plant.world_body()}

    def add(parent: str) -> None:
        for name, joint in robot.joints.items():
            if joint.parent != parent:
                continue
            body = plant.AddRigidBody(joint.child, _spatial_inertia(robot.links[joint.child]))
            bodies[joint.child] = body
            rotation = RotationMatrix(np.array(joint.rotation))
            placement = RigidTransform(rotation, np.array(joint.translation))
            offset = FixedOffsetFrame(f"{name} frame", bodies[parent].body_frame(), placement)
            frame = plant.AddFrame(offset)
            kind = JOINTS[joint.type]
            plant.AddJoint(kind(name, frame, body.body_frame(), np.array(joint.axis)))
            add(joint.child)

    add(robot.base)
    plant.Finalize()
    return plant


def _spatial_inertia(link: Link) -> SpatialInertia:
    com = np.array(link.com)
    about = np.array(link.inertia) / link.mass + com @ com * np.eye(3) - np.outer(com, com)
    unit = UnitInertia(*about.diagonal(), about[0, 1], about[0, 2], about[1, 2])
    return SpatialInertia(link.mass, com, unit, skip_validity_check=True)


class ByHand:
    """The closure by hand, CalcInverseDynamics for the tree."""

    def __init__(self, robot: Robot) -> None:
        self.plant = build(robot.description)
        self.context = self.plant.CreateDefaultContext()
        joints = [self.plant.GetJointByName(name) for name in COORDINATES]
        self.place = np.array([joint.velocity_start() for joint in joints])
        self.forces = MultibodyForces(self.plant)
        self.state = np.zeros(24)
        self.a = np.zeros(12)

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
    name = "Drake CalcInverseDynamics, closure by hand"
    return [Side(name, {"id": ByHand(robot).inverse_dynamics})]
