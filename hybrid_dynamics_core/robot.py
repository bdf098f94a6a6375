"""The robot as its users see it: names, checked arrays in and out, errors with evidence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from . import programs
from .algebra.scalar import Scalar
from .closure.plan import build_plan
from .closure.reach import allowed_range
from .description.model import Array, Frame, JointType, RobotDescription, frozen
from .errors import InputError
from .inputs import vectors
from .kernels.run import Codes, Kernel
from .kernels.trace import Results
from .kinematics.pose import Pose
from .kinematics.solve import IKResult, solve_inverse_kinematics
from .mechanism.tree import build_tree
from .refusal import refusal
from .state import ClosedState, ClosureStatus


class Robot:
    """A hybrid robot: closure, kinematics and minimal-form dynamics from the active coordinates u (n,) or (N, n).

    Order: u = `active`, z = `passive`, s = `coordinates` = u + z. SI units, radians, base axes.
    """

    def __init__(self, description: RobotDescription) -> None:
        self.description = description
        tree = build_tree(description)
        self._model = programs.Model(tree, build_plan(tree, description))
        self._signs = frozen(self._model.plan.branch)
        self._start = frozen(self._model.plan.reference.q)
        self._gravity = description.gravity
        self._kernels: dict[str, Kernel] = {}

    # -- names -------------------------------------------------------------------------------------------------

    @property
    def name(self) -> str:
        """Name of the robot."""
        return self.description.name

    @property
    def active(self) -> tuple[str, ...]:
        """Names of the active coordinates u."""
        return self.coordinates[: self._model.tree.n_active]

    @property
    def passive(self) -> tuple[str, ...]:
        """Names of the passive coordinates z."""
        return self.coordinates[self._model.tree.n_active :]

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of all coordinates s = [u; z]."""
        return self._model.tree.coordinates

    @cached_property
    def joint_types(self) -> Mapping[str, JointType]:
        """'revolute' or 'prismatic' by coordinate name, in the order of `coordinates`."""
        return MappingProxyType({name: self.description.joints[name].type for name in self.coordinates})

    @property
    def base_frame(self) -> str:
        """Name of the base link, in whose frame poses are given."""
        return self.description.base

    @property
    def end_effector(self) -> str:
        """Name of the end-effector frame."""
        return self.description.end_effector

    @property
    def frames(self) -> tuple[str, ...]:
        """Frames whose pose can be asked: named frames and links."""
        return (*self.description.frames, *self.description.links)

    @property
    def loops(self) -> tuple[str, ...]:
        """Names of the loops, in the order in which they close."""
        return tuple(step.name for step in self._model.plan.steps)

    @cached_property
    def reference(self) -> Array:
        """The active coordinates (n,) of the description's reference configuration."""
        return frozen(self._model.plan.reference.q[: len(self.active)])

    @cached_property
    def limits(self) -> Array:
        """(n, 2) lower and upper limit of each active coordinate [rad or m], infinite where there is none.

        The description's limits, narrowed to the `closing_range`.
        """
        told = np.array([self.description.joints[name].limits for name in self.active])
        lower, upper = self.closing_range.T
        return frozen(np.stack([np.maximum(told[:, 0], lower), np.minimum(told[:, 1], upper)], axis=1))

    @cached_property
    def closing_range(self) -> Array:
        """(n, 2) range of each active coordinate [rad or m] between the toggle points of its loop.

        Infinite where the coordinate is in no loop, or in one with other given coordinates.
        """
        limits = np.tile([-np.inf, np.inf], (len(self.active), 1))
        for step in self._model.plan.steps:
            known = step.known
            if len(known) == 1 and known[0] < len(self.active):
                k = known[0]
                found = allowed_range(self._model.tree, step, self._model.plan.reference, k, float(self.reference[k]))
                if found is not None:
                    limits[k] = max(limits[k, 0], found[0]), min(limits[k, 1], found[1])
        return frozen(limits)

    # -- closure and kinematics --------------------------------------------------------------------------------

    def close(self, u: ArrayLike, du: ArrayLike | None = None, check: bool = True) -> ClosedState:
        """Close all loops at the active coordinates u and rates du (zero if None), each (n,) or (N, n).

        With `check` a state that cannot close raises ClosureError and a singular one SingularityError; without it
        its row is NaN and its `status` says why. Raises InputError for wrong shapes and values that are not finite.
        """
        u = vectors("u", u, self.active)
        du = np.zeros_like(u) if du is None else vectors("du", du, self.active, len(u) if u.ndim == 2 else -1)
        values, codes = self._run("close", programs.CLOSE, u=u, du=du, branch=self._signs, guess=self._start)
        if check:
            self._refuse(u, codes, values["distances"])
        else:
            for value in values.values():
                value[codes != 0] = np.nan
        residuals = np.abs(values["residuals"])
        residual = residuals.max(axis=-1, initial=0.0)
        status = np.where(codes == 0, 0, np.where(codes % 2 == 1, ClosureStatus.UNREACHABLE, ClosureStatus.SINGULAR))
        single = u.ndim == 1
        return ClosedState(
            u=frozen(u),
            du=frozen(du),
            s=values["s"],
            ds=values["ds"],
            R=values["R"],
            bias=values["bias"],
            residual=float(residual) if single else residual,
            branch=self._branch_names(self._signs),
            signs=self._signs,
            loops=self.loops,
            distances=values["distances"],
            status=ClosureStatus(int(status)) if single else status,
        )

    def forward_kinematics(self, state: ClosedState, frame: str | None = None) -> Pose:
        """Pose of the end effector, or of any name in `frames`, in the base frame: (3,) and (3, 3), or (N, ...)."""
        where = self._frame(frame)
        values = self._checked(f"pose {frame}", programs.forward_kinematics(where), state)
        return Pose(values["position"], values["rotation"])

    def jacobian(self, state: ClosedState, frame: str | None = None) -> Array:
        """(6, n) or (N, 6, n): d(linear, angular velocity)/du' of the frame's origin, base axes [m/s, rad/s]."""
        program = programs.jacobian(self._frame(frame))
        return self._checked(f"jacobian {frame}", program, state)["jacobian"]

    def accelerations(self, state: ClosedState, ddu: ArrayLike) -> Array:
        """s'' = R u'' + R' u' of all coordinates, (n_s,) or (N, n_s), from the active accelerations ddu."""
        ddu = self._like(state, "ddu", ddu)
        return self._checked("accelerations", programs.ACCELERATIONS, state, ddu)["dds"]

    def inverse_kinematics(
        self, target: ArrayLike | Pose, seed: ArrayLike | None = None, all_solutions: bool = False
    ) -> IKResult:
        """Active coordinates that bring the end effector to a position (3,) [m] or a Pose, within `limits`.

        The search starts at `seed` (the description's reference if None) and, where that fails or
        `all_solutions` is asked, from a fixed set of starts over the limits. Failure is told in `status`.
        """
        return solve_inverse_kinematics(self, target, seed, all_solutions)

    # -- dynamics ----------------------------------------------------------------------------------------------

    def inverse_dynamics(self, state: ClosedState, ddu: ArrayLike) -> Array:
        """Actuator torques [N m] and forces [N], (n,) or (N, n), for active accelerations ddu; Chu (2020), Eq. 25."""
        ddu = self._like(state, "ddu", ddu)
        return self._checked("inverse_dynamics", programs.INVERSE_DYNAMICS, state, ddu)["tau"]

    def minimal_form(self, state: ClosedState) -> tuple[Array, Array, Array]:
        """M-bar (n, n), C-bar u' (n,) and G-bar (n,) of M-bar u'' + C-bar u' + G-bar = tau; Chu (2020), Eq. 25."""
        values = self._checked("minimal_form", programs.MINIMAL_FORM, state)
        return values["M"], values["h"], values["g"]

    # -- inside ------------------------------------------------------------------------------------------------

    def _run(self, key: str, program: programs.Program, **inputs: Array) -> tuple[dict[str, Array], Codes]:
        kernel = self._kernels.get(key)
        if kernel is None:
            kernel = self._kernels[key] = _kernel(program, self._model)
        return kernel(*(inputs[name] for name in program.inputs))

    def _checked(
        self, key: str, program: programs.Program, state: ClosedState, ddu: Array | None = None
    ) -> dict[str, Array]:
        """Run on a state; rows that `close(..., check=False)` let through stay NaN."""
        self._own(state)
        zero = np.zeros_like(state.u) if ddu is None else ddu
        inputs = {"u": state.u, "du": state.du, "ddu": zero, "branch": state.signs, "guess": state.s}
        values, codes = self._run(key, program, gravity=self._gravity, **inputs)
        for value in values.values():
            value[codes != 0] = np.nan
        return values

    def _own(self, state: ClosedState) -> None:
        if not isinstance(state, ClosedState):
            raise InputError(f"expected a ClosedState from robot.close(u, du), got {type(state).__name__}")
        if state.s.shape[-1] != len(self.coordinates) or state.loops != self.loops:
            raise InputError("the state belongs to another robot")

    def _like(self, state: ClosedState, name: str, value: ArrayLike) -> Array:
        self._own(state)
        return vectors(name, value, self.active, len(state.u) if state.u.ndim == 2 else -1)

    def _frame(self, frame: str | None) -> Frame:
        name = frame or self.end_effector
        if name in self.description.frames:
            return self.description.frames[name]
        if name in self.description.links:
            return Frame(name)
        raise InputError(f"there is no frame '{name}'; known: {', '.join(self.frames)}")

    def _branch_names(self, signs: Array) -> Mapping[str, str]:
        steps = self._model.plan.steps
        return MappingProxyType({s.name: s.modes[0 if sign > 0 else 1] for s, sign in zip(steps, signs, strict=True)})

    def _refuse(self, u: Array, codes: Codes, distances: Array) -> None:
        if not codes.any():
            return
        row = None if u.ndim == 1 else int(np.flatnonzero(codes)[0])
        code = int(codes if row is None else codes[row])
        near = (distances if row is None else distances[row])[(code - 1) // 2]
        raise refusal(self._model, u if row is None else u[row], self._signs, code, float(near), row)

    def __repr__(self) -> str:
        return f"Robot('{self.name}', active={list(self.active)}, passive={list(self.passive)})"


def _kernel(program: programs.Program, model: programs.Model) -> Kernel:
    def run(*vectors: Sequence[Scalar]) -> Results:
        return program.run(model, programs.Inputs(**dict(zip(program.inputs, vectors, strict=True))))

    return Kernel(run, [model.size(name) for name in program.inputs])
