"""Drake: loops by ball constraints of the discrete solver SAP, trees by an integrator."""

from __future__ import annotations

import time

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import DiscreteContactApproximation, MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    LinearSpringDamper,
    PrismaticJoint,
    RevoluteJoint,
    SpatialInertia,
    UnitInertia,
)
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator

from .model import Model

Array = np.ndarray
NAME = "Drake"
PACKAGE = "drake"
KINDS = {"revolute": RevoluteJoint, "prismatic": PrismaticJoint}


class Engine:
    """One model: loops at one step, trees at one accuracy."""

    def __init__(self, model: Model, inner: int) -> None:
        self.model = model
        problem = model.problem
        self.is_discrete = bool(model.closures)
        step = problem.end / problem.samples / inner
        self.step = step * self.is_discrete
        self.accuracy = 1e-3 / inner**2
        self.plant = built(model, self.step)

    def run(self) -> tuple[float, Array]:
        """CPU time [s] and rows of what is compared."""
        plant, model = self.plant, self.model
        simulator = Simulator(plant)
        context = simulator.get_mutable_context()
        joints = {name: plant.GetJointByName(name) for name in model.joints}
        place = [joint.velocity_start() for joint in joints.values()]
        state = np.zeros((2, len(place)))
        state[:, place] = [list(model.s.values()), list(model.ds.values())]
        plant.SetPositionsAndVelocities(context, state.ravel())
        tau = np.zeros(plant.num_velocities())
        for name, effort in model.tau.items():
            tau[joints[name].velocity_start()] = effort
        plant.get_applied_generalized_force_input_port().FixValue(context, tau)
        if not self.is_discrete:
            scheme = "runge_kutta3"
            if model.springs:
                scheme = "radau3"
            ResetIntegratorFromFlags(simulator, scheme, 0.01)
            integrator = simulator.get_mutable_integrator()
            integrator.set_target_accuracy(self.accuracy)
        simulator.Initialize()
        kept = [state]
        begin = time.process_time()
        for k in range(1, model.problem.samples + 1):
            simulator.AdvanceTo(k * model.problem.end / model.problem.samples)
            kept.append(plant.GetPositionsAndVelocities(context).reshape(2, -1))
        seconds = time.process_time() - begin
        rows = np.array(kept)[:, :, place]
        return seconds, model.rows(rows[:, 0], rows[:, 1])


def built(model: Model, step: float) -> MultibodyPlant:
    """The tree with its ties; a step of zero means continuous time."""
    plant = MultibodyPlant(step)
    if step:
        plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
    plant.mutable_gravity_field().set_gravity_vector(np.array(model.description.gravity))
    bodies = {model.base: plant.world_body()}
    for name, joint in model.joints.items():
        link = model.links[joint.child]
        body = plant.AddRigidBody(joint.child, _inertia(link.mass, link.com, link.inertia))
        bodies[joint.child] = body
        placement = RigidTransform(
            RotationMatrix(np.array(joint.rotation)), np.array(joint.translation)
        )
        parent = bodies[joint.parent].body_frame()
        frame = plant.AddFrame(FixedOffsetFrame(f"{name} frame", parent, placement))
        plant.AddJoint(KINDS[joint.type](name, frame, body.body_frame(), np.array(joint.axis)))
    for spring in model.springs:
        plant.AddForceElement(
            LinearSpringDamper(
                bodies[spring.link_a],
                spring.point_a,
                bodies[spring.link_b],
                spring.point_b,
                spring.rest,
                spring.stiffness,
                spring.damping,
            )
        )
    for closure in model.closures:
        pairs = [(closure.point_a, closure.point_b)]
        if closure.kind == "axis":
            along_a, along_b = closure.rotation_a[:, 2], closure.rotation_b[:, 2]
            pairs.append((closure.point_a + along_a, closure.point_b + along_b))
        for a, b in pairs:
            plant.AddBallConstraint(bodies[closure.link_a], a, bodies[closure.link_b], b)
    plant.Finalize()
    return plant


def _inertia(mass: float, com: Array, moments: Array) -> SpatialInertia:
    """Of a link, about its origin; a massless one gets a trace of mass."""
    if not mass:
        mass, moments = 1e-9, moments + 1e-9 * np.eye(3)
    about = np.array(moments) / mass + com @ com * np.eye(3) - np.outer(com, com)
    unit = UnitInertia(*about.diagonal(), about[0, 1], about[0, 2], about[1, 2])
    return SpatialInertia(mass, com, unit, skip_validity_check=True)
