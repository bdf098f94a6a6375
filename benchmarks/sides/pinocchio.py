"""Pinocchio from Python, in three ways.

The pins are closed by Newton, or by hand, or Pinocchio's constrained dynamics keeps them.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.description import RobotDescription

from ..closed_form import COORDINATES, linear, positions, projected, quadratic, triangles
from ..side import Side

Array = np.ndarray
N = 4
JOINTS = {
    "revolute": pin.JointModelRevoluteUnaligned,
    "prismatic": pin.JointModelPrismaticUnaligned,
}


def build(robot: RobotDescription) -> tuple[pin.Model, dict[str, int]]:
    """The open tree, depth first, and the index of each link's joint."""
    model = pin.Model()
    model.gravity.linear = np.array(robot.gravity)
    links = {robot.base: 0}

    def add(parent: str) -> None:
        for name, joint in robot.joints.items():
            if joint.parent != parent:
                continue
            kind = JOINTS[joint.type]
            placement = pin.SE3(np.array(joint.rotation), np.array(joint.translation))
            index = model.addJoint(links[parent], kind(np.array(joint.axis)), placement, name)
            link = robot.links[joint.child]
            inertia = pin.Inertia(link.mass, np.array(link.com), np.array(link.inertia))
            model.appendBodyToJoint(index, inertia, pin.SE3.Identity())
            links[joint.child] = index
            add(joint.child)

    add(robot.base)
    return model, links


def _places(model: pin.Model) -> Array:
    """(12,) where Pinocchio has each of the coordinates."""
    joints = [model.joints[model.getJointId(name)] for name in COORDINATES]
    return np.array([joint.idx_v for joint in joints])


class ByHand:
    """The closure by hand, Pinocchio for the tree."""

    def __init__(self, robot: Robot) -> None:
        self.model, _ = build(robot.description)
        self.data = self.model.createData()
        self.place = _places(self.model)
        self.order = np.argsort(self.place)
        self.q = np.zeros(12)
        self.v = np.zeros(12)
        self.a = np.zeros(12)

    def inverse_dynamics(self, u: Array, du: Array, ddu: Array) -> Array:
        """rnea on the tree, projected."""
        q = u.tolist()
        v = du.tolist()
        t1, t2 = triangles(q)
        a = linear(ddu.tolist(), t1, t2)
        extra = quadratic(v, t1, t2)
        place = self.place
        self.q[place] = positions(q, t1, t2)
        self.v[place] = linear(v, t1, t2)
        self.a[place] = [x + y for x, y in zip(a, extra, strict=True)]
        forces = pin.rnea(self.model, self.data, self.q, self.v, self.a)
        return np.array(projected(forces[place].tolist(), t1, t2))

    def closed(self, u: Array, du: Array) -> Array:
        """R of the closed state, which is put into the model with its bias accelerations."""
        place = self.place
        q = u.tolist()
        v = du.tolist()
        t1, t2 = triangles(q)
        self.q[place] = positions(q, t1, t2)
        self.v[place] = linear(v, t1, t2)
        self.a[place] = quadratic(v, t1, t2)
        R: Array = np.array([linear(e, t1, t2) for e in np.eye(4).tolist()]).T[self.order]
        return R

    def minimal_form(self, u: Array, du: Array) -> tuple[Array, Array, Array]:
        """crba and rnea on the tree, projected."""
        model, data = self.model, self.data
        R = self.closed(u, du)
        gravity = pin.computeGeneralizedGravity(model, data, self.q)
        bias = pin.rnea(model, data, self.q, self.v, self.a) - gravity
        M = pin.crba(model, data, self.q)
        return R.T @ M @ R, R.T @ bias, R.T @ gravity

    def forward_dynamics(self, u: Array, du: Array, tau: Array) -> Array:
        """crba and rnea on the tree, projected, and a system of four solved."""
        model, data = self.model, self.data
        R = self.closed(u, du)
        bias = pin.rnea(model, data, self.q, self.v, self.a)
        M = pin.crba(model, data, self.q)
        return np.linalg.solve(R.T @ M @ R, tau - R.T @ bias)

    def close(self, u: Array, du: Array) -> tuple[Array, Array]:
        """s and s'; no need of Pinocchio."""
        q = u.tolist()
        t1, t2 = triangles(q)
        return np.array(positions(q, t1, t2)), np.array(linear(du.tolist(), t1, t2))

    def batch(self, u: Array, du: Array, ddu: Array) -> Array:
        """A loop: there is no call for many states."""
        return np.array([self.inverse_dynamics(*row) for row in zip(u, du, ddu, strict=True)])


class Newton:
    """The pins by Newton, written for any tree.

    Gaps and Jacobians come from Pinocchio, two rows in the plane of a pin.
    """

    def __init__(self, robot: Robot) -> None:
        self.model, links = build(robot.description)
        self.data = self.model.createData()
        self.place = _places(self.model)
        self.active = self.place[:N]
        self.passive = self.place[N:]
        self.start = np.zeros(12)
        self.start[self.place] = robot.close(robot.reference).s
        self.pins = []
        for closure in robot.description.closures:
            ends = ((closure.link_a, closure.point_a), (closure.link_b, closure.point_b))
            frames = []
            for link, point in ends:
                name = f"{closure.name} {link}"
                placement = pin.SE3(np.eye(3), point)
                frame = pin.Frame(name, links[link], placement, pin.FrameType.OP_FRAME)
                frames.append(self.model.addFrame(frame))
            self.pins.append(frames)
        self.data = self.model.createData()

    def _gaps(self, q: Array) -> tuple[Array, Array]:
        model, data = self.model, self.data
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        turn = data.oMi[1].rotation.T[[0, 2]]  # the plane of all pins turns with the first joint
        world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        gaps = []
        rows = []
        for a, b in self.pins:
            gaps.append(turn @ (data.oMf[a].translation - data.oMf[b].translation))
            jacobian_a = pin.getFrameJacobian(model, data, a, world)
            jacobian_b = pin.getFrameJacobian(model, data, b, world)
            rows.append(turn @ (jacobian_a - jacobian_b)[:3])
        return np.concatenate(gaps), np.concatenate(rows)

    def _close(self, u: Array) -> tuple[Array, Array]:
        q = self.start.copy()
        q[self.active] = u
        while True:
            gap, rows = self._gaps(q)
            if np.abs(gap).max() < 1e-13:
                return q, rows
            q[self.passive] -= np.linalg.solve(rows[:, self.passive], gap)

    def _map(self, rows: Array) -> Array:
        R = np.zeros((12, N))
        R[self.active] = np.eye(N)
        R[self.passive] = -np.linalg.solve(rows[:, self.passive], rows[:, self.active])
        return R

    def close(self, u: Array, du: Array) -> tuple[Array, Array]:
        """s and s'."""
        q, rows = self._close(u)
        return q[self.place], (self._map(rows) @ du)[self.place]

    def inverse_dynamics(self, u: Array, du: Array, ddu: Array) -> Array:
        """Accelerations from the drift of the pins, then rnea on the tree, projected."""
        model, data = self.model, self.data
        q, rows = self._close(u)
        R = self._map(rows)
        v = R @ du
        a = R @ ddu
        pin.forwardKinematics(model, data, q, v, np.zeros(12))
        turn = data.oMi[1].rotation.T[[0, 2]]
        world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        bias = []
        for i, j in self.pins:
            acceleration_i = pin.getFrameClassicalAcceleration(model, data, i, world).linear
            acceleration_j = pin.getFrameClassicalAcceleration(model, data, j, world).linear
            bias.append(turn @ (acceleration_i - acceleration_j))
        a[self.passive] -= np.linalg.solve(rows[:, self.passive], np.concatenate(bias))
        return np.asarray(R.T @ pin.rnea(model, data, q, v, a))


class Constrained:
    """Pinocchio's own constrained forward dynamics, with positions and rates closed by hand.

    Pins are points that coincide. In a plane one of the three equations of each is redundant.
    """

    def __init__(self, robot: Robot) -> None:
        self.hand = ByHand(robot)
        self.model, links = build(robot.description)
        self.data = self.model.createData()
        models = pin.StdVec_RigidConstraintModel()
        for closure in robot.description.closures:
            model = pin.RigidConstraintModel(
                pin.ContactType.CONTACT_3D,
                self.model,
                links[closure.link_a],
                pin.SE3(np.eye(3), np.array(closure.point_a)),
                links[closure.link_b],
                pin.SE3(np.eye(3), np.array(closure.point_b)),
                pin.ReferenceFrame.LOCAL,
            )
            models.append(model)
        self.constraints = models
        self.constraint_data = pin.StdVec_RigidConstraintData()
        for model in models:
            self.constraint_data.append(model.createData())
        pin.initConstraintDynamics(self.model, self.data, self.constraints, self.constraint_data)
        self.settings = pin.ProximalSettings(1e-10, 1e-4, 100)  # accuracy, damping, most iterations
        self.tau = np.zeros(12)

    def forward_dynamics(self, u: Array, du: Array, tau: Array) -> Array:
        """By the factorised system of all constraints."""
        a = pin.constraintDynamics(
            *self._state(u, du, tau), self.constraints, self.constraint_data, self.settings
        )
        return np.asarray(a[self.hand.place[:N]])

    def _state(
        self, u: Array, du: Array, tau: Array
    ) -> tuple[pin.Model, pin.Data, Array, Array, Array]:
        hand = self.hand
        place = hand.place
        q = u.tolist()
        t1, t2 = triangles(q)
        hand.q[place] = positions(q, t1, t2)
        hand.v[place] = linear(du.tolist(), t1, t2)
        self.tau[place[:N]] = tau
        return self.model, self.data, hand.q, hand.v, self.tau


def sides(robot: Robot) -> list[Side]:
    """Three ways to use Pinocchio."""
    hand = ByHand(robot)
    newton = Newton(robot)
    constrained = Constrained(robot)
    by_hand: dict[str, Callable[..., object]] = {
        "id": hand.inverse_dynamics,
        "minimal": hand.minimal_form,
        "fd": hand.forward_dynamics,
        "close": hand.close,
        "id_batch": hand.batch,
    }
    return [
        Side("Pinocchio, closure by hand", by_hand),
        Side("Pinocchio, Newton closure", {"id": newton.inverse_dynamics, "close": newton.close}),
        Side("Pinocchio, constraintDynamics", {"fd": constrained.forward_dynamics}, tolerance=1e-4),
    ]
