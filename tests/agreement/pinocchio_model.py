"""The same robot in Pinocchio: its tree from the description, its closures as constraints."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from hybrid_dynamics_core.description import Closure, Joint, RobotDescription

LOCAL = pin.ReferenceFrame.LOCAL
KINDS = {
    "revolute": pin.JointModelRevoluteUnaligned,
    "prismatic": pin.JointModelPrismaticUnaligned,
}
TIED = {"axis": [0, 1], "frame": [0, 1, 2]}  # axes of the closure's frame, by its kind


class PinocchioRobot:
    """Open tree of a description in Pinocchio, with Newton for the closures.

    Coordinates s in the order `names`. A pin is three equations in space; in a planar loop one is
    redundant.
    """

    def __init__(self, robot: RobotDescription, names: tuple[str, ...]) -> None:
        self.robot = robot
        self.model = pin.Model()
        self.model.gravity.linear = np.array(robot.gravity)
        self.frames: dict[str, tuple[int, pin.SE3]] = {robot.base: (0, pin.SE3.Identity())}
        waiting = dict(robot.joints)
        while waiting:  # depth first: Pinocchio's crba is silently wrong otherwise
            name = self._candidates(robot, waiting)[-1]
            self._add(robot, name)
            del waiting[name]
        self.data = self.model.createData()
        self.index = np.array([self.model.joints[self.model.getJointId(n)].idx_v for n in names])
        self.closures = robot.closures

    def _candidates(self, robot: RobotDescription, waiting: dict[str, Joint]) -> list[str]:
        """Joints that can be added, those on the last link alone where there are any."""
        ready = [name for name, joint in waiting.items() if joint.parent in self.frames]
        last = self.model.names[-1]
        if last in robot.joints:
            link = robot.joints[last].child
            on_last = [name for name in ready if robot.joints[name].parent == link]
            if on_last:
                return on_last
        depth = {name: self.frames[robot.joints[name].parent][0] for name in ready}
        return sorted(ready, key=depth.__getitem__)

    def _add(self, robot: RobotDescription, name: str) -> None:
        joint = robot.joints[name]
        link = robot.links[joint.child]
        kind = KINDS[joint.type]
        parent, _ = self.frames[joint.parent]
        placement = pin.SE3(np.array(joint.rotation), np.array(joint.translation))
        index = self.model.addJoint(parent, kind(np.array(joint.axis)), placement, name)
        inertia = pin.Inertia(link.mass, np.array(link.com), np.array(link.inertia))
        self.model.appendBodyToJoint(index, inertia, pin.SE3.Identity())
        self.frames[link.name] = (index, pin.SE3.Identity())

    def order(self, s: np.ndarray) -> np.ndarray:
        """From the order of `names` to Pinocchio's."""
        q = np.empty(self.model.nv)
        q[self.index] = s
        return q

    # -- closures

    def gaps(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Gaps of all closures [m], [rad] where axes are tied, and their Jacobian (rows, n_s)."""
        q = self.order(s)
        pin.computeJointJacobians(self.model, self.data, q)
        gaps = [np.zeros(0)]
        rows = [np.zeros((0, self.model.nv))]
        for closure in self.closures:
            a, ja = self._end(closure, "a")
            b, jb = self._end(closure, "b")
            gaps.append(a.translation - b.translation)
            rows.append(ja[:3] - jb[:3])
            axes = _tied(closure)
            if axes:
                turned = pin.log3(b.rotation.T @ a.rotation)  # in the closure's frame on b
                slope = pin.Jlog3(b.rotation.T @ a.rotation) @ a.rotation.T @ (ja[3:] - jb[3:])
                gaps.append(turned[axes])
                rows.append(slope[axes])
        return np.concatenate(gaps), np.vstack(rows)[:, self.index]

    def _end(self, closure: Closure, end: str) -> tuple[pin.SE3, np.ndarray]:
        """Placement of one end of a closure in the base frame, and its Jacobian in base axes."""
        index, frame = self._place(closure, end)
        jacobian = pin.getJointJacobian(self.model, self.data, index, pin.ReferenceFrame.LOCAL)
        at_end = frame.toActionMatrixInverse() @ jacobian
        placement = self.data.oMi[index] * frame
        turn = placement.rotation
        return placement, np.vstack([turn @ at_end[:3], turn @ at_end[3:]])

    def _place(self, closure: Closure, end: str) -> tuple[int, pin.SE3]:
        """Joint and placement of one end.

        About the free axis of a revolute joint both ends stand alike.
        """
        index, _ = self.frames[getattr(closure, f"link_{end}")]
        rotation = np.array(getattr(closure, f"rotation_{end}"))
        return index, pin.SE3(rotation, np.array(getattr(closure, f"point_{end}")))

    def constraint_jacobian(self, s: np.ndarray) -> np.ndarray:
        """Pinocchio's Jacobian of the closures as contact constraints (rows, n_s).

        Pins are 3D contacts, all others 6D. A closure of kind axis lacks the row of the turn about
        its axis.
        """
        q = self.order(s)
        pin.computeJointJacobians(self.model, self.data, q)
        parts = [np.zeros((0, self.model.nv))]
        for closure in self.closures:
            axes = _tied(closure)
            kind = pin.ContactType.CONTACT_3D
            if axes:
                kind = pin.ContactType.CONTACT_6D
            i, a = self._place(closure, "a")
            j, b = self._place(closure, "b")
            constraint = pin.RigidConstraintModel(kind, self.model, i, a, j, b, LOCAL)
            data = constraint.createData()
            constraint.calc(self.model, self.data, data)
            rows = pin.getConstraintJacobian(self.model, self.data, constraint, data)
            if axes:
                rows = rows[[0, 1, 2, *(3 + k for k in axes)]]
            parts.append(rows)
        return np.vstack(parts)[:, self.index]

    def close(self, s: np.ndarray, n_active: int) -> np.ndarray:
        """Newton on the passive coordinates from s, to rounding."""
        s = s.copy()
        for _ in range(50):
            gap, jacobian = self.gaps(s)
            step = np.linalg.lstsq(jacobian[:, n_active:], -gap, rcond=1e-9)[0]
            s[n_active:] += step
            if np.abs(step).max(initial=0.0) < 1e-14:
                break
        return s

    def velocity_map(self, s: np.ndarray, n_active: int) -> np.ndarray:
        """R = [E; -J_z^-1 J_u] of Pinocchio's constraint Jacobian, by least squares."""
        jacobian = self.constraint_jacobian(s)
        passive = -np.linalg.lstsq(jacobian[:, n_active:], jacobian[:, :n_active], rcond=1e-9)[0]
        return np.vstack([np.eye(n_active), passive])

    def bias(self, s: np.ndarray, ds: np.ndarray) -> np.ndarray:
        """(d/dt J_s) s' of the pins (3 m,) [m/s^2]."""
        q, v = self.order(s), self.order(ds)
        pin.forwardKinematics(self.model, self.data, q, v, np.zeros_like(v))
        result = []
        for closure in self.closures:
            a = self._acceleration(closure.link_a, closure.point_a)
            b = self._acceleration(closure.link_b, closure.point_b)
            result.append(a - b)
        return np.concatenate(result)

    def _acceleration(self, link: str, point: np.ndarray) -> np.ndarray:
        index, _ = self.frames[link]
        rotation = self.data.oMi[index].rotation
        velocity = self.data.v[index]
        acceleration = self.data.a[index]
        at_point = velocity.linear + np.cross(velocity.angular, point)
        spatial = acceleration.linear + np.cross(acceleration.angular, point)
        result: np.ndarray = rotation @ (spatial + np.cross(velocity.angular, at_point))
        return result

    # -- links and forces

    def pose(self, s: np.ndarray, link: str) -> tuple[np.ndarray, np.ndarray]:
        """Rotation and origin of a link in the base frame."""
        pin.forwardKinematics(self.model, self.data, self.order(s))
        placement = self.data.oMi[self.frames[link][0]]
        return placement.rotation.copy(), placement.translation.copy()

    def velocity(self, s: np.ndarray, ds: np.ndarray, link: str) -> tuple[np.ndarray, np.ndarray]:
        """Linear velocity of a link's origin and its angular velocity, base axes."""
        pin.forwardKinematics(self.model, self.data, self.order(s), self.order(ds))
        index, _ = self.frames[link]
        twist = pin.getVelocity(
            self.model, self.data, index, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        return twist.linear, twist.angular

    def tree_forces(self, s: np.ndarray, ds: np.ndarray, dds: np.ndarray) -> np.ndarray:
        """M s'' + C s' + g of the open tree (n_s,)."""
        forces: np.ndarray = pin.rnea(
            self.model, self.data, self.order(s), self.order(ds), self.order(dds)
        )
        chosen: np.ndarray = forces[self.index]
        return chosen

    def mass_matrix(self, s: np.ndarray) -> np.ndarray:
        """M(s) of the open tree (n_s, n_s), from unit accelerations: one algorithm less is used."""
        still = np.zeros(len(s))
        gravity = self.tree_forces(s, still, still)
        columns = [self.tree_forces(s, still, unit) - gravity for unit in np.eye(len(s))]
        return np.array(columns).T

    def crba(self, s: np.ndarray) -> np.ndarray:
        """M(s) of the open tree by Pinocchio's composite rigid body algorithm."""
        upper = np.triu(pin.crba(self.model, self.data, self.order(s)))
        matrix: np.ndarray = (upper + np.triu(upper, 1).T)[np.ix_(self.index, self.index)]
        return matrix

    def constraint_dynamics(self, s: np.ndarray, ds: np.ndarray, tau: np.ndarray) -> np.ndarray:
        """s'' of the tree with its closures as contacts, for forces tau (n_s,) along s.

        The redundant rows of a planar loop leave the multipliers open, not s''. The proximal
        iteration settles s'' in a few rounds, and is stopped after them.
        """
        models = pin.StdVec_RigidConstraintModel()
        datas = pin.StdVec_RigidConstraintData()
        for closure in self.closures:
            for model in self._contacts(closure):
                models.append(model)
                datas.append(model.createData())
        pin.initConstraintDynamics(self.model, self.data, models, datas)
        q, v, forces = (self.order(x) for x in (s, ds, tau))
        settings = pin.ProximalSettings(1e-14, 1e-10, 20)
        dds: np.ndarray = pin.constraintDynamics(
            self.model, self.data, q, v, forces, models, datas, settings
        )
        chosen: np.ndarray = dds[self.index]
        return chosen

    def _contacts(self, closure: Closure) -> list[pin.RigidConstraintModel]:
        """The contacts of a closure.

        A weld is one of six rows, a ball or pin one of three, a tied axis two of these on it.
        """
        i, a = self._place(closure, "a")
        j, b = self._place(closure, "b")
        kind = pin.ContactType.CONTACT_3D
        heights = [0.0]
        if closure.kind == "frame":
            kind = pin.ContactType.CONTACT_6D
        if closure.kind == "axis":
            heights = [0.0, 0.5]
        contacts = []
        for height in heights:
            up = pin.SE3(np.eye(3), np.array([0.0, 0.0, height]))
            contact = pin.RigidConstraintModel(kind, self.model, i, a * up, j, b * up, LOCAL)
            contacts.append(contact)
        return contacts


def _tied(closure: Closure) -> list[int]:
    """Axes of the closure's frame about which the ends cannot turn against each other."""
    return TIED.get(closure.kind, [])
