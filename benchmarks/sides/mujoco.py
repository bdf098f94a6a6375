"""MuJoCo's inverse dynamics of the open tree, with the closure by hand."""

from __future__ import annotations

import mujoco
import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.description import RobotDescription

from ..closed_form import COORDINATES, linear, positions, projected, quadratic, triangles
from ..side import Side

Array = np.ndarray
KINDS = {"revolute": mujoco.mjtJoint.mjJNT_HINGE, "prismatic": mujoco.mjtJoint.mjJNT_SLIDE}


def build(robot: RobotDescription) -> mujoco.MjModel:
    """The open tree."""
    spec = mujoco.MjSpec()
    spec.option.gravity = np.array(robot.gravity)
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT

    def add(parent: str, body: mujoco.MjsBody) -> None:
        for name, joint in robot.joints.items():
            if joint.parent != parent:
                continue
            quaternion = np.zeros(4)
            mujoco.mju_mat2Quat(quaternion, np.array(joint.rotation).ravel())
            link = robot.links[joint.child]
            child = body.add_body(
                name=joint.child, pos=np.array(joint.translation), quat=quaternion
            )
            child.add_joint(name=name, type=KINDS[joint.type], axis=np.array(joint.axis))
            child.explicitinertial = True
            child.mass = link.mass
            child.ipos = np.array(link.com)
            # MuJoCo wants every moment to be positive.
            inertia = np.array(link.inertia) + 1e-12 * np.eye(3)
            child.fullinertia = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
            add(joint.child, child)

    add(robot.base, spec.worldbody)
    spec.compiler.boundmass = spec.compiler.boundinertia = 0.0
    spec.compiler.balanceinertia = True
    return spec.compile()


class ByHand:
    """The closure by hand, mj_rne for the tree."""

    def __init__(self, robot: Robot) -> None:
        self.model = build(robot.description)
        self.data = mujoco.MjData(self.model)
        self.place = np.array([self.model.joint(name).dofadr[0] for name in COORDINATES])
        self.force = np.zeros(12)

    def inverse_dynamics(self, u: Array, du: Array, ddu: Array) -> Array:
        """The steps that mj_rne needs, and no others."""
        m, d, place = self.model, self.data, self.place
        q = u.tolist()
        v = du.tolist()
        t1, t2 = triangles(q)
        d.qpos[place] = positions(q, t1, t2)
        d.qvel[place] = linear(v, t1, t2)
        a = linear(ddu.tolist(), t1, t2)
        d.qacc[place] = [x + y for x, y in zip(a, quadratic(v, t1, t2), strict=True)]
        mujoco.mj_kinematics(m, d)
        mujoco.mj_comPos(m, d)
        mujoco.mj_comVel(m, d)
        mujoco.mj_rne(m, d, 1, self.force)
        return np.array(projected(self.force[place].tolist(), t1, t2))


def sides(robot: Robot) -> list[Side]:
    """mj_rne."""
    name = "MuJoCo mj_rne, closure by hand"
    return [Side(name, {"id": ByHand(robot).inverse_dynamics}, tolerance=1e-8)]
