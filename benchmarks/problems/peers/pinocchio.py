"""Pinocchio: `constraintDynamics` with Baumgarte's terms, `aba` for trees; RK4 in Python."""

from __future__ import annotations

import time

import numpy as np
import pinocchio as pin

from .model import Model, Spring

Array = np.ndarray
NAME = "Pinocchio"
PACKAGE = "pin"
KINDS = {
    "revolute": pin.JointModelRevoluteUnaligned,
    "prismatic": pin.JointModelPrismaticUnaligned,
}
SpringEnds = tuple[Spring, int, int]
WORLD = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


class Engine:
    """One model at one step."""

    def __init__(self, model: Model, inner: int) -> None:
        problem = model.problem
        self.model = model
        self.inner = inner
        self.step = problem.end / problem.samples / inner
        self.pin, self.links = built(model)
        names = list(model.joints)
        self.place = [self.pin.joints[self.pin.getJointId(name)].idx_q for name in names]
        self.springs = _spring_frames(self.pin, model, self.links)
        self.ties = _ties(self.pin, model, self.links, 0.2 / self.step)
        self.data = self.pin.createData()
        self.tie_data = pin.StdVec_RigidConstraintData()
        for tie in self.ties:
            self.tie_data.append(tie.createData())
        self.tau = np.zeros(self.pin.nv)
        for name, effort in model.tau.items():
            self.tau[self.place[names.index(name)]] = effort
        if len(self.ties):
            pin.initConstraintDynamics(self.pin, self.data, self.ties, self.tie_data)
        self.settings = pin.ProximalSettings(1e-12, 1e-8, 10)  # accuracy, damping, most iterations
        if any(closure.kind == "axis" for closure in model.closures):
            self.settings = pin.ProximalSettings(1e-12, 1e-4, 100)  # its rows are redundant

    def run(self) -> tuple[float, Array]:
        """CPU time [s] and rows of what is compared."""
        y = np.zeros((2, self.pin.nv))
        y[0, self.place] = list(self.model.s.values())
        y[1, self.place] = list(self.model.ds.values())
        kept = [y]
        begin = time.process_time()
        for _ in range(self.model.problem.samples):
            for _ in range(self.inner):
                y = self._stepped(y)
            kept.append(y)
        seconds = time.process_time() - begin
        s, ds = np.array(kept)[:, 0], np.array(kept)[:, 1]
        return seconds, self.model.rows(s[:, self.place], ds[:, self.place])

    def _stepped(self, y: Array) -> Array:
        """One step of the classical Runge-Kutta method."""
        h = self.step
        k1 = self._slope(y)
        k2 = self._slope(y + 0.5 * h * k1)
        k3 = self._slope(y + 0.5 * h * k2)
        k4 = self._slope(y + h * k3)
        after: Array = y + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
        return after

    def _slope(self, y: Array) -> Array:
        q, v = y
        tau = self.tau
        if self.springs:
            tau = tau + self._spring_forces(q, v)
        if len(self.ties):
            a = pin.constraintDynamics(
                self.pin, self.data, q, v, tau, self.ties, self.tie_data, self.settings
            )
        else:
            a = pin.aba(self.pin, self.data, q, v, tau)
        return np.array([v, a])

    def _spring_forces(self, q: Array, v: Array) -> Array:
        """Efforts of springs between points."""
        model, data = self.pin, self.data
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        tau = np.zeros(model.nv)
        for spring, a, b in self.springs:
            gap = data.oMf[b].translation - data.oMf[a].translation
            length = np.linalg.norm(gap)
            along = gap / length
            jacobian = pin.getFrameJacobian(model, data, b, WORLD)[:3]
            jacobian = jacobian - pin.getFrameJacobian(model, data, a, WORLD)[:3]
            row = along @ jacobian
            force = spring.stiffness * (length - spring.rest) + spring.damping * (row @ v)
            tau -= force * row
        return tau


def built(model: Model) -> tuple[pin.Model, dict[str, int]]:
    """The tree, and the joint of each link."""
    tree = pin.Model()
    tree.gravity.linear = np.array(model.description.gravity)
    links = {model.base: 0}
    for name, joint in model.joints.items():
        placement = pin.SE3(np.array(joint.rotation), np.array(joint.translation))
        kind = KINDS[joint.type](np.array(joint.axis))
        index = tree.addJoint(links[joint.parent], kind, placement, name)
        link = model.links[joint.child]
        inertia = pin.Inertia(link.mass, np.array(link.com), np.array(link.inertia))
        tree.appendBodyToJoint(index, inertia, pin.SE3.Identity())
        links[joint.child] = index
    return tree, links


def _spring_frames(tree: pin.Model, model: Model, links: dict[str, int]) -> list[SpringEnds]:
    """Springs with the frames of their ends."""
    springs = []
    for k, spring in enumerate(model.springs):
        ends: list[int] = []
        for link, point in ((spring.link_a, spring.point_a), (spring.link_b, spring.point_b)):
            placement = pin.SE3(np.eye(3), point)
            name = f"spring {k} {len(ends)}"
            frame = pin.Frame(name, links[link], placement, pin.FrameType.OP_FRAME)
            ends.append(tree.addFrame(frame))
        springs.append((spring, ends[0], ends[1]))
    return springs


def _ties(
    tree: pin.Model, model: Model, links: dict[str, int], rate: float
) -> pin.StdVec_RigidConstraintModel:
    """Points that coincide, two for an axis; gaps die out as exp(-rate t)."""
    ties = pin.StdVec_RigidConstraintModel()
    gains = pin.BaumgarteCorrectorParameters(rate**2, 2.0 * rate)
    for closure in model.closures:
        pairs = [(closure.point_a, closure.point_b)]
        if closure.kind == "axis":
            along_a, along_b = closure.rotation_a[:, 2], closure.rotation_b[:, 2]
            pairs.append((closure.point_a + along_a, closure.point_b + along_b))
        for a, b in pairs:
            tie = pin.RigidConstraintModel(
                pin.ContactType.CONTACT_3D,
                tree,
                links[closure.link_a],
                pin.SE3(np.eye(3), np.array(a)),
                links[closure.link_b],
                pin.SE3(np.eye(3), np.array(b)),
                pin.ReferenceFrame.LOCAL,
            )
            tie.setBaumgarteCorrectorParameters(gains)
            ties.append(tie)
    return ties
