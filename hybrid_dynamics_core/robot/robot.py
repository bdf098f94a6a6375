"""The robot as its users see it: names, checked arrays in and out, errors with evidence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

from numpy.typing import ArrayLike

from .. import programs
from ..closed_state.assembly_modes import mode_names
from ..closed_state.state import ClosedState
from ..description.model import Frame
from ..dynamics.load_pattern import LoadPattern
from ..dynamics.loads import Loads
from ..errors import InputError
from ..ground.arrays import Array, frozen
from ..ground.suggestions import no_such_name
from ..kinematics.ik_problem import SOLVED
from ..kinematics.inverse_kinematics import IKResult, solve_inverse_kinematics
from ..kinematics.pose import Pose
from ..kinematics.pose_chain import PoseChain, find_pose_chain
from ..kinematics.workspace import COUNT, Workspace, find_workspace
from .actuation import RobotActuators
from .compiled_calls import RobotKernels


class Robot(RobotActuators):
    """A hybrid robot: closure, kinematics and minimal-form dynamics from the active coordinates u (n,) or (N, n).

    Order: u = `active`, z = `passive`, s = `coordinates` = u + z. SI units, radians, base axes.
    """

    @cached_property
    def kernels(self) -> RobotKernels:
        """Fused calls, from active coordinates straight to a result: the fastest there is."""
        return RobotKernels(self, self._frame, self._compiled_inputs, self.loads)

    @cached_property
    def mode_names(self) -> Mapping[str, tuple[str, ...]]:
        """Names of the assembly modes of each loop; loops closed by iteration are left out: theirs are numbered."""
        return mode_names(self._model.plan)

    def forward_kinematics(self, state: ClosedState, frame: str | None = None) -> Pose:
        """Pose of the end effector, or of any name in `frames`, in the base frame: (3,) and (3, 3), or (N, ...)."""
        where = self._frame(frame)
        values = self._checked(f"pose {frame!r}", programs.forward_kinematics(where), state)
        return Pose(values["position"], values["rotation"])

    def jacobian(self, state: ClosedState, frame: str | None = None) -> Array:
        """(6, n) or (N, 6, n): d(linear, angular velocity)/du' of the frame's origin, base axes [m/s, rad/s]."""
        program = programs.jacobian(self._frame(frame))
        return self._checked(f"jacobian {frame!r}", program, state)["jacobian"]

    def accelerations(self, state: ClosedState, ddu: ArrayLike) -> Array:
        """s'' = R u'' + R' u' of all coordinates, (n_s,) or (N, n_s), from the active accelerations ddu."""
        ddu = self._like(state, "ddu", ddu)
        return self._checked("accelerations", programs.ACCELERATIONS, state, ddu)["dds"]

    def inverse_kinematics(
        self,
        target: ArrayLike | Pose,
        seed: ArrayLike | None = None,
        all_solutions: bool = False,
        mask: Sequence[bool] | None = None,
        near: ClosedState | None = None,
        tolerance: float = SOLVED,
    ) -> IKResult:
        """Active coordinates that bring the end effector to a position (3,) [m] or a Pose, within `limits`.

        mask: which of x, y, z and the rotation about x, y, z (base axes) count; all that the target
        gives if None. near: one closed state whose assembly modes are kept; the robot's own if
        None. tolerance: `residual` [m] below which the target counts as reached; a target told with
        few digits, of more coordinates than the robot has freedoms, is met no better than its
        digits. The search starts at `seed` (if None at `near`, or else at the description's
        reference) and, where that fails or `all_solutions` is asked, from a fixed set of starts
        over the limits. Failure is told in `status`.

        Raises InputError for a target, seed, mask or `near` that is none, or that is too far away
        to compute with.
        """
        return solve_inverse_kinematics(self, target, seed, all_solutions, mask, near, tolerance)

    @cached_property
    def follows(self) -> bool:
        """Whether some loop has no closed form: its assembly mode is that of the state it is followed from."""
        return any(step.iterates for step in self._model.plan.blocks)

    def workspace(
        self,
        count: int = COUNT,
        frame: str | None = None,
        ranges: Mapping[str, tuple[float, float]] | None = None,
        held: Mapping[str, float] | None = None,
    ) -> Workspace:
        """Where the end effector, or a frame, can be, and how near to singular places and limits the robot is there.

        `count` samples are spread evenly over the active coordinates within `limits`, or within
        narrower `ranges` by name [rad or m]; those that are `held` stay at their value [rad or m].
        More samples are taken towards the ends and about the extremes. Samples that do not close
        are told apart by their status. A run of more than a second shows its progress on a
        terminal. Raises InputError for ranges that are empty or outside of the limits, and for held
        coordinates that are not active, not finite, or have a range too.
        """
        return find_workspace(self, count, frame, ranges, held=held)

    @cached_property
    def pose_chain(self) -> PoseChain | None:
        """The end effector's own coordinates where inverse kinematics has a closed form by them, else None."""
        chain = find_pose_chain(self._model.tree, self._frame(None), len(self.active))
        if chain is not None:
            try:
                self._model_for(tuple(self.coordinates[k] for k in (*chain.slides, *chain.turns)))
            except InputError:
                return None
        return chain

    def _compiled_inputs(self, loads: Loads) -> tuple[LoadPattern, dict[str, Array]]:
        """Which loads there are, and the robot's own values of all inputs that do not belong to a state."""
        pattern, arrays = self._pack_loads(loads, None)
        return pattern, {
            "branch": self._signs,
            "guess": self._start,
            "gravity": frozen(loads.gravity),
            **arrays,
        }

    def _frame(self, frame: str | None) -> Frame:
        name = frame or self.end_effector
        if name in self.description.frames:
            return self.description.frames[name]
        if name in self.description.links:
            return Frame(name)
        raise InputError(no_such_name("frame", name, self.frames))

    def __repr__(self) -> str:
        return f"Robot('{self.name}', active={list(self.active)}, passive={list(self.passive)})"
