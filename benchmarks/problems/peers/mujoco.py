"""MuJoCo: hinges and slides, ties by `connect`, springs by tendons, RK4."""

from __future__ import annotations

import time

import mujoco
import numpy as np

from .model import Model

Array = np.ndarray
Bodies = dict[str, mujoco.MjsBody]
KINDS = {"revolute": mujoco.mjtJoint.mjJNT_HINGE, "prismatic": mujoco.mjtJoint.mjJNT_SLIDE}
NAME = "MuJoCo"
PACKAGE = "mujoco"
LEAST = 1e-10  # mass [kg] and moments [kg m^2]: MuJoCo wants positive ones


class Engine:
    """One model at one step."""

    def __init__(self, model: Model, inner: int) -> None:
        problem = model.problem
        self.inner = inner
        self.model = model
        self.mj = compiled(model, problem.end / problem.samples / inner)
        self.data = mujoco.MjData(self.mj)
        self.place = [self.mj.joint(name).qposadr[0] for name in model.joints]

    def run(self) -> tuple[float, Array]:
        """CPU time [s] and rows of what is compared."""
        mujoco.mj_resetData(self.mj, self.data)
        data = self.data
        data.qpos[self.place] = list(self.model.s.values())
        data.qvel[self.place] = list(self.model.ds.values())
        for name, effort in self.model.tau.items():
            data.qfrc_applied[self.place[list(self.model.joints).index(name)]] = effort
        s = []
        ds = []
        begin = time.process_time()
        for k in range(self.model.problem.samples + 1):
            if k:
                mujoco.mj_step(self.mj, data, self.inner)
            s.append(data.qpos.copy())
            ds.append(data.qvel.copy())
        seconds = time.process_time() - begin
        places = self.place
        return seconds, self.model.rows(np.array(s)[:, places], np.array(ds)[:, places])


def compiled(model: Model, step: float) -> mujoco.MjModel:
    """The tree with its ties; as stiff as a step allows: `solref` of two steps."""
    spec = mujoco.MjSpec()
    spec.option.gravity = np.array(model.description.gravity)
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    spec.option.timestep = step
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    bodies = {model.base: spec.worldbody}
    for name, joint in model.joints.items():
        body = bodies[joint.parent].add_body(
            name=joint.child, pos=np.array(joint.translation), quat=_quaternion(joint.rotation)
        )
        body.add_joint(name=name, type=KINDS[joint.type], axis=np.array(joint.axis))
        link = model.links[joint.child]
        inertia = np.array(link.inertia) + LEAST * np.eye(3)
        body.explicitinertial = True
        body.mass = max(link.mass, LEAST)
        body.ipos = np.array(link.com)
        body.fullinertia = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        bodies[joint.child] = body
    spec.compiler.boundmass = spec.compiler.boundinertia = 0.0
    spec.compiler.balanceinertia = True
    _add_ties(spec, model, bodies, step)
    _add_springs(spec, model, bodies)
    return spec.compile()


def _add_ties(spec: mujoco.MjSpec, model: Model, bodies: Bodies, step: float) -> None:
    """A point is one `connect`; an axis is two of them, a length apart."""
    for closure in model.closures:
        pairs = [(closure.point_a, closure.point_b)]
        if closure.kind == "axis":
            along_a, along_b = closure.rotation_a[:, 2], closure.rotation_b[:, 2]
            pairs.append((closure.point_a + along_a, closure.point_b + along_b))
        for k, (a, b) in enumerate(pairs):
            tie = spec.add_equality(type=mujoco.mjtEq.mjEQ_CONNECT)
            tie.objtype = mujoco.mjtObj.mjOBJ_SITE
            tie.name1, tie.name2 = (f"{closure.name}{k}{end}" for end in "ab")
            bodies[closure.link_a].add_site(name=tie.name1, pos=a)
            bodies[closure.link_b].add_site(name=tie.name2, pos=b)
            tie.solref[:2] = [2.0 * step, 1.0]
            tie.solimp[:3] = [0.9999, 0.9999, 0.001]


def _add_springs(spec: mujoco.MjSpec, model: Model, bodies: Bodies) -> None:
    """Tendons between two sites."""
    for k, spring in enumerate(model.springs):
        bodies[spring.link_a].add_site(name=f"a{k}", pos=spring.point_a)
        bodies[spring.link_b].add_site(name=f"b{k}", pos=spring.point_b)
        tendon = spec.add_tendon(name=f"spring{k}")
        tendon.stiffness[0] = spring.stiffness
        tendon.damping[0] = spring.damping
        tendon.springlength = [spring.rest, spring.rest]
        tendon.wrap_site(f"a{k}")
        tendon.wrap_site(f"b{k}")


def _quaternion(rotation: Array) -> Array:
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.array(rotation).ravel())
    return quaternion
