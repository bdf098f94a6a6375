"""Poses, velocities and accelerations of a closed state."""

from __future__ import annotations

from numpy.typing import ArrayLike

from .. import programs
from ..closed_state.state import ClosedState, mark_open_rows
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.lazy import lazy
from ..kinematics.pose import Pose
from ..kinematics.pose_chain import PoseChain, find_pose_chain
from .closure import Closure
from .kernel_store import KernelStore
from .model import RobotModel


class Kinematics:
    """Kinematics of the frames and coordinates of a robot."""

    def __init__(
        self,
        model: RobotModel,
        kernels: KernelStore,
        closure: Closure,
    ) -> None:
        self._model = model
        self._kernels = kernels
        self._closure = closure

    def forward_kinematics(
        self,
        state: ClosedState,
        frame: str | None = None,
    ) -> Pose:
        """Pose of a frame in the base frame.

        Args:
            state: closed state, or a batch of N.
            frame: name in `frames`; the end effector if None.

        Returns:
            Position (3,) [m] and rotation (3, 3), or (N, 3) and (N, 3, 3).

        Raises:
            InputError: there is no such frame, or the state is of another robot.
        """
        program = programs.forward_kinematics(self._model.frame(frame))
        values = self._evaluate(f"pose {frame!r}", program, state)
        return Pose(values["position"], values["rotation"])

    def jacobian(
        self,
        state: ClosedState,
        frame: str | None = None,
    ) -> Array:
        """Jacobian of a frame's origin with respect to the active rates, in base axes.

        Args:
            state: closed state, or a batch of N.
            frame: name in `frames`; the end effector if None.

        Returns:
            (6, n) or (N, 6, n): linear velocity [m/s], then angular velocity [rad/s], per unit
            rate.

        Raises:
            InputError: there is no such frame, or the state is of another robot.
        """
        program = programs.jacobian(self._model.frame(frame))
        return self._evaluate(f"jacobian {frame!r}", program, state)["jacobian"]

    def accelerations(self, state: ClosedState, ddu: ArrayLike) -> Array:
        """Accelerations of all coordinates: s'' = R u'' + R' u'.

        Args:
            state: closed state, or a batch of N.
            ddu: active accelerations (n,) or (N, n) [rad/s^2, m/s^2].

        Returns:
            s'' (n_s,) or (N, n_s) [rad/s^2, m/s^2].

        Raises:
            InputError: a shape is wrong, or a value is not finite.
        """
        ddu = self._closure.vector_like(state, "ddu", ddu)
        return self._evaluate("accelerations", programs.ACCELERATIONS, state, ddu=ddu)["dds"]

    @lazy
    def pose_chain(self) -> PoseChain | None:
        """The end effector's coordinates, if its pose determines them in closed form.

        None if inverse kinematics has no closed form by such coordinates.
        """
        model = self._model
        frame = model.frame(None)
        chain = find_pose_chain(model.tree, frame, len(model.active))
        if chain is None:
            return None
        indices = (*chain.slides, *chain.turns)
        names = tuple(model.coordinates[k] for k in indices)
        try:
            model.program_model_from(names)
        except InputError:
            return None
        return chain

    def _evaluate(
        self, key: str, program: programs.Program, state: ClosedState, **inputs: Array
    ) -> dict[str, Array]:
        """Run a program on a state; rows that did not close stay NaN."""
        self._closure.check_state(state)
        inputs |= {"u": state.u, "du": state.du, "branch": state.signs, "guess": state.s}
        values, codes = self._kernels.run(key, program, inputs)
        mark_open_rows(state, values, codes)
        return values
