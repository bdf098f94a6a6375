"""Poses and twists of ball and free joints, whose coordinates are three angles."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..algebra.charts import LEAVE
from ..closed_state.state import ClosedState
from ..errors import InputError
from ..ground.arrays import Array, frozen
from ..ground.check_arrays import finite_vectors, real_array
from ..ground.lazy import lazy
from ..ground.suggestions import no_such_name
from ..kinematics.joint_pose import FreelyTurning, freely_turning
from ..kinematics.pose import Pose, checked_pose
from .closure import Closure
from .model import RobotModel


@dataclass(frozen=True, eq=False)
class TwistMap:
    """Map from active rates to velocities that have the twists of ball and free joints.

    With v = V u': tau = V^T tau_v, M_v = V^-T M-bar V^-1, and v' = V u'' + drift.

    Attributes:
        V: (n, n) or (N, n, n).
        drift: V' u', (n,) or (N, n).
    """

    V: Array
    drift: Array

    def velocity(self, du: ArrayLike) -> Array:
        """v (n,) or (N, n) from u'."""
        return _times(self.V, np.asarray(du))

    def rates(self, v: ArrayLike) -> Array:
        """u' (n,) or (N, n) from v."""
        return _solved(self.V, np.asarray(v))

    def acceleration(self, ddu: ArrayLike) -> Array:
        """v' (n,) or (N, n) from u''."""
        return _times(self.V, np.asarray(ddu)) + self.drift

    def rate_accelerations(self, dv: ArrayLike) -> Array:
        """u'' (n,) or (N, n) from v'."""
        return _solved(self.V, np.asarray(dv) - self.drift)

    def wrenches(self, tau: ArrayLike) -> Array:
        """tau_v (n,) or (N, n) from tau, with wrenches on the children of ball and free joints."""
        return _solved(np.swapaxes(self.V, -1, -2), np.asarray(tau))

    def efforts(self, wrenches: ArrayLike) -> Array:
        """tau (n,) or (N, n) from tau_v."""
        return _times(np.swapaxes(self.V, -1, -2), np.asarray(wrenches))

    def mass_matrix(self, M: Array) -> Array:
        """M_v (n, n) or (N, n, n) from M-bar."""
        inverse = np.linalg.inv(self.V)
        result: Array = np.swapaxes(inverse, -1, -2) @ M @ inverse
        return result


class JointPoses:
    """Poses, twists and charts of the ball and free joints of a robot."""

    def __init__(self, model: RobotModel, closure: Closure) -> None:
        self._model = model
        self._closure = closure

    @lazy
    def _joints(self) -> Mapping[str, FreelyTurning]:
        joints = freely_turning(self._model.description, self._model.tree)
        return {joint.name: joint for joint in joints}

    def joint_pose(self, state: ClosedState, joint: str) -> Pose:
        """Pose of the child of a ball or free joint, in the frame of the child at zero.

        Args:
            state: closed state, or a batch of N.
            joint: name of the joint.

        Returns:
            Position (3,) [m] and rotation (3, 3), or (N, 3) and (N, 3, 3).

        Raises:
            InputError: there is no such joint, or the state is of another robot.
        """
        self._closure.check_state(state)
        return self._joint(joint).pose(state.s, self._closure.charts.of(state))

    def joint_twist(self, state: ClosedState, joint: str) -> Array:
        """Velocity of the child of a ball or free joint relative to its parent, in child axes.

        Args:
            state: closed state, or a batch of N.
            joint: name of the joint.

        Returns:
            Linear velocity of the child's origin [m/s], then angular velocity [rad/s]: (6,) or
            (N, 6). For a ball joint only the angular velocity: (3,) or (N, 3).

        Raises:
            InputError: there is no such joint, or the state is of another robot.
        """
        self._closure.check_state(state)
        turning = self._joint(joint)
        velocity_map = turning.velocity_map(state.s, self._closure.charts.of(state))
        return _times(velocity_map, state.ds[..., turning.coordinates])

    def close_at_poses(
        self,
        poses: Mapping[str, Pose],
        twists: Mapping[str, ArrayLike] | None = None,
        u: ArrayLike | None = None,
        du: ArrayLike | None = None,
        near: ClosedState | None = None,
    ) -> ClosedState:
        """Close with active ball and free joints at given poses, in the charts that suit them best.

        Args:
            poses: pose of the child in the joint frame, by joint. The position is ignored for a
                ball joint.
            twists: twist by joint, as in `joint_twist`; zero where left out.
            u: active coordinates (n,) [rad, m], ignored for joints in `poses`; the reference if
                None.
            du: active rates (n,) [rad/s, m/s], ignored for joints in `poses`; zero if None.
            near: closed state from which the motion is followed, as in `close`.

        Returns:
            The closed state.

        Raises:
            InputError: a joint is neither ball nor free, or not active; a pose is not rigid.
            ClosureError, SingularityError: as in `close`.
        """
        model = self._model
        if u is None:
            u = model.reference
        u = finite_vectors("u", u, model.active, -1).copy()
        du = np.zeros_like(u) if du is None else finite_vectors("du", du, model.active, -1).copy()
        signs = np.array(self._closure.signs if near is None else near.signs)
        charts = signs[len(model.plan.blocks) :]
        rates = dict(twists or {})
        for name, pose in poses.items():
            joint = self._active_joint(name)
            u[joint.coordinates], charts[joint.chart] = joint.coordinates_at(checked_pose(pose))
            du[joint.coordinates] = self._rates(joint, u, charts, rates.pop(name, None))
        for name in rates:
            raise InputError(f"twists: '{name}' has no pose in poses")
        if near is None:
            return self._closure.close_on(u, du, frozen(signs))
        return self._closure.close(u, du, near=self._closure.charts.change(near, charts))

    def recentred(self, state: ClosedState, leave: float = LEAVE) -> ClosedState:
        """The same state, with ball and free joints in charts far from singular.

        Args:
            state: closed state, or a batch of N.
            leave: second angle of a joint, above which its chart changes [rad].

        Returns:
            The state. If a chart changed, its `u`, `du`, `s` and `ds` are in the new chart.
        """
        self._closure.check_state(state)
        return self._closure.charts.recentred(state, leave)

    def in_urdf_angles(self, state: ClosedState) -> ClosedState:
        """The same state, with active ball and free joints in the first chart, that of the URDF.

        Args:
            state: closed state, or a batch of N.

        Returns:
            The state, unchanged if they already are. States closed near it stay in this chart.
        """
        self._closure.check_state(state)
        return self._closure.charts.in_first(state)

    def twist_map(self, state: ClosedState) -> TwistMap:
        """The map from active rates u' to velocities v that have twists of ball and free joints.

        Args:
            state: closed state, or a batch of N.
        """
        self._closure.check_state(state)
        charts = self._closure.charts.of(state)
        n = state.n
        rows = state.u.shape[:-1]
        V = np.broadcast_to(np.eye(n), (*rows, n, n)).copy()
        drift = np.zeros(state.u.shape)
        for joint in self._joints.values():
            k = joint.coordinates
            if max(k) < n:
                rows_of, columns_of = np.ix_(k, k)
                velocity_map = joint.velocity_map(state.s, charts)
                V[..., rows_of, columns_of] = velocity_map
                drift[..., k] = joint.drift(state.s, state.ds, velocity_map)
        return TwistMap(V, drift)

    def _rates(
        self, joint: FreelyTurning, u: Array, charts: Array, twist: ArrayLike | None
    ) -> Array:
        k = len(joint.coordinates)
        if twist is None:
            return np.zeros(k)
        vector = real_array(f"twists['{joint.name}']", twist)
        if vector.shape != (k,) or not np.isfinite(vector).all():
            raise InputError(
                f"twists: that of '{joint.name}' is {vector}; expected {k} finite numbers"
            )
        s = np.zeros(len(self._model.coordinates))
        s[: len(u)] = u
        return _solved(joint.velocity_map(s, charts), vector)

    def _joint(self, name: str) -> FreelyTurning:
        if name not in self._joints:
            raise InputError(no_such_name("ball or free joint", name, self._joints))
        return self._joints[name]

    def _active_joint(self, name: str) -> FreelyTurning:
        joint = self._joint(name)
        if max(joint.coordinates) >= len(self._model.active):
            raise InputError(f"joint '{name}' is not active: the loops determine its pose")
        return joint


def _times(matrix: Array, vector: Array) -> Array:
    product: Array = (matrix @ vector[..., None])[..., 0]
    return product


def _solved(matrix: Array, vector: Array) -> Array:
    solution = np.linalg.solve(matrix, vector[..., None])[..., 0]
    return np.asarray(solution, dtype=float)
