"""The same robot in Pinocchio: its tree from the description, its pins as constraints. An engine of its own."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from hybrid_dynamics_core.description import RobotDescription


class PinocchioRobot:
    """Open tree of a description in Pinocchio, with Newton for the pins and the DAE as one KKT system.

    Coordinates s in the order `names`. A pin is three equations in space; in a planar loop one is redundant.
    """

    def __init__(self, robot: RobotDescription, names: tuple[str, ...]) -> None:
        self.model = pin.Model()
        self.model.gravity.linear = np.array(robot.gravity)
        self.frames: dict[str, tuple[int, pin.SE3]] = {robot.base: (0, pin.SE3.Identity())}
        waiting = dict(robot.joints)
        while waiting:  # depth first: Pinocchio's crba is silently wrong otherwise
            name = next(n for n in reversed(self._open(robot, waiting)))
            self._add(robot, name)
            del waiting[name]
        self.data = self.model.createData()
        self.index = np.array([self.model.joints[self.model.getJointId(n)].idx_v for n in names])
        self.closures = robot.closures

    def _open(self, robot: RobotDescription, waiting: dict) -> list[str]:
        last = self.model.names[-1]
        ready = [n for n, j in waiting.items() if j.parent in self.frames]
        own = [n for n in ready if last in robot.joints and robot.joints[n].parent == robot.joints[last].child]
        depth = {n: self.frames[robot.joints[n].parent][0] for n in ready}
        return own or sorted(ready, key=lambda n: depth[n])

    def _add(self, robot: RobotDescription, name: str) -> None:
        joint, link = robot.joints[name], robot.links[robot.joints[name].child]
        kind = pin.JointModelRevoluteUnaligned if joint.type == "revolute" else pin.JointModelPrismaticUnaligned
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

    def gaps(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Pin gaps (3 m,) [m] and their Jacobian (3 m, n_s)."""
        q = self.order(s)
        pin.computeJointJacobians(self.model, self.data, q)
        gaps, rows = [], []
        for closure in self.closures:
            (pa, ja), (pb, jb) = (
                self._point(link, point)
                for link, point in ((closure.link_a, closure.point_a), (closure.link_b, closure.point_b))
            )
            gaps.append(pa - pb)
            rows.append(ja - jb)
        return np.concatenate(gaps), np.vstack(rows)[:, self.index]

    def _point(self, link: str, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        index, _ = self.frames[link]
        where = self.data.oMi[index].act(np.array(point))
        jacobian = pin.getJointJacobian(self.model, self.data, index, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        arm = where - self.data.oMi[index].translation
        return where, jacobian[:3] - pin.skew(arm) @ jacobian[3:]

    def close(self, s: np.ndarray, n_active: int) -> np.ndarray:
        """Newton on the passive coordinates from s, to rounding."""
        s = s.copy()
        for _ in range(50):
            gap, jacobian = self.gaps(s)
            step = np.linalg.lstsq(jacobian[:, n_active:], -gap, rcond=1e-9)[0]
            s[n_active:] += step
            if np.abs(step).max() < 1e-14:
                break
        return s

    def bias(self, s: np.ndarray, ds: np.ndarray) -> np.ndarray:
        """(d/dt J_s) s' of the pins (3 m,) [m/s^2]."""
        q, v = self.order(s), self.order(ds)
        pin.forwardKinematics(self.model, self.data, q, v, np.zeros_like(v))
        result = []
        for closure in self.closures:
            a, b = (
                self._acceleration(link, point)
                for link, point in ((closure.link_a, closure.point_a), (closure.link_b, closure.point_b))
            )
            result.append(a - b)
        return np.concatenate(result)

    def _acceleration(self, link: str, point: np.ndarray) -> np.ndarray:
        index, _ = self.frames[link]
        rotation = self.data.oMi[index].rotation
        velocity, acceleration = self.data.v[index], self.data.a[index]
        at_point = velocity.linear + np.cross(velocity.angular, point)
        spatial = acceleration.linear + np.cross(acceleration.angular, point)
        return rotation @ (spatial + np.cross(velocity.angular, at_point))

    def tree_forces(self, s: np.ndarray, ds: np.ndarray, dds: np.ndarray) -> np.ndarray:
        """M s'' + C s' + g of the open tree (n_s,)."""
        return pin.rnea(self.model, self.data, self.order(s), self.order(ds), self.order(dds))[self.index]

    def mass_matrix(self, s: np.ndarray) -> np.ndarray:
        """M(s) of the open tree (n_s, n_s), from unit accelerations: one algorithm less to trust."""
        still = np.zeros(len(s))
        gravity = self.tree_forces(s, still, still)
        return np.array([self.tree_forces(s, still, e) - gravity for e in np.eye(len(s))]).T
