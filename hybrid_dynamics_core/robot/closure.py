"""The closing half of a robot: names, limits, and every way to close its loops."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from .. import programs
from ..closed_state.assembly_modes import (
    AssemblyMode,
    branch_names,
    list_modes,
    matching_signs,
    signs_of_names,
)
from ..closed_state.closure_solver import Closer, Start
from ..closed_state.diagnosis import error_for, raise_for_status
from ..closed_state.state import ClosedState, ClosureStatus, closure_statuses, settle
from ..closure.mobility import find_mobility, with_mobility
from ..closure.plan import build_plan
from ..closure.toggle_range import allowed_range
from ..description.model import JointType, RobotDescription
from ..errors import DescriptionError, InputError
from ..ground.arrays import Array, frozen
from ..ground.check_arrays import finite_vectors, vector_by_name
from ..ground.suggestions import no_such_name
from ..ground.wording import counted
from ..kernels.run import Codes, Kernel
from ..mechanism.tree import build_tree


class ClosingRobot:
    """Names, limits and closure of a robot; `Robot` adds what is asked of the closed mechanism."""

    def __init__(self, description: RobotDescription) -> None:
        tree = build_tree(description)
        self.idle: tuple[str, ...] = ()  # active coordinates that no motor drives
        self.dependent_motors: tuple[
            str, ...
        ] = ()  # motors that follow from the other ones: passive coordinates
        if description.active_set == "motors":
            mobility = find_mobility(tree, description)
            self.idle, self.dependent_motors = mobility.idle, mobility.dependent
            description, tree = with_mobility(description, mobility)
        self.description = description
        self._model = programs.Model(tree, build_plan(tree, description))
        self._signs = frozen(self._model.plan.branch)
        self._start = frozen(self._model.plan.reference.q)
        self._gravity = description.gravity
        self._kernels: dict[str, Kernel] = {}
        self._given_models: dict[tuple[str, ...], programs.Model] = {}
        self._branches: dict[bytes, Mapping[str, str]] = {}

    # -- names

    def __reduce__(self) -> tuple[type[ClosingRobot], tuple[RobotDescription]]:
        """A robot is its description: what is pickled or copied is made anew from it."""
        return type(self), (self.description,)

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
        return MappingProxyType(
            {name: self.description.joints[name].type for name in self.coordinates}
        )

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
        return tuple(dict.fromkeys((*self.description.frames, *self.description.links)))

    @cached_property
    def loops(self) -> tuple[str, ...]:
        """Names of the blocks of loops, in the order in which they close: a loop, or several joined by +."""
        return tuple(dict.fromkeys(step.name for step in self._model.plan.blocks))

    @property
    def redundant_equations(self) -> Mapping[str, int]:
        """By loop: how many of its equations follow from the others and were left out (by rank)."""
        counts: dict[str, int] = {}
        for equation in self._model.plan.redundant:
            counts[equation.loop.name] = counts.get(equation.loop.name, 0) + 1
        return MappingProxyType(counts)

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
        return frozen(
            np.stack([np.maximum(told[:, 0], lower), np.minimum(told[:, 1], upper)], axis=1)
        )

    @cached_property
    def closing_range(self) -> Array:
        """(n, 2) range of each active coordinate [rad or m] between the toggle points of its loop.

        Infinite where the coordinate is in no loop, or in one with other given coordinates.
        """
        limits = np.tile([-np.inf, np.inf], (len(self.active), 1))
        for step in self._model.plan.blocks:
            known = step.inputs
            if len(known) == 1 and known[0] < len(self.active):
                k = known[0]
                found = allowed_range(
                    self._model.tree, step, self._model.plan.reference, k, float(self.reference[k])
                )
                if found is not None:
                    limits[k] = max(limits[k, 0], found[0]), min(limits[k, 1], found[1])
        return frozen(limits)

    def loop_distances(self, distances: Array) -> Array:
        """Distances to a singularity of the steps of the closure (..., steps) -> the smallest of each of `loops`."""
        order, starts = self._loop_order
        if order == starts:  # a step a loop
            return distances
        nearest: Array = (
            np.minimum.reduceat(distances[..., order], starts, axis=-1) if starts else distances
        )
        return nearest

    # -- closure

    def close(
        self,
        u: ArrayLike,
        du: ArrayLike | None = None,
        check: bool = True,
        near: ClosedState | None = None,
        branch: Mapping[str, str] | None = None,
    ) -> ClosedState:
        """Close all loops at the active coordinates u and rates du (zero if None), each (n,) or (N, n).

        near: a closed state (one, or one a row) to come from. The way from there is followed in
        small steps, its
            branch is kept, and a jump to another assembly mode is refused. Without it the robot's
            own branch is taken;
            loops that have no closed form are followed from the reference configuration.
        branch: assembly modes by loop name, where they differ from the robot's; not together with
        `near`.

        With `check` a state that cannot close raises ClosureError and a singular one
        SingularityError; without it its row is NaN and its `status` says why. Raises InputError for
        wrong shapes and values that are not finite.
        """
        u = finite_vectors("u", u, self.active)
        du = (
            np.zeros_like(u)
            if du is None
            else finite_vectors("du", du, self.active, len(u) if u.ndim == 2 else -1)
        )
        start = self._start_at(near, len(u) if u.ndim == 2 else 0)
        signs = self._signs if near is None else near.signs
        if branch is not None and near is not None:
            raise InputError("give near or branch, not both: the branch of near is kept")
        if branch is not None:
            signs = frozen(signs_of_names(self._model.plan, signs, branch))
        values, codes = self._closer.close(u, du, signs, start)
        state = self._state(u, du, signs, values, codes, check)
        return state if near is None else replace(state, branch=self._followed(near, state))

    def closed_state(self, u: Array, du: Array, found: Sequence[Array]) -> ClosedState:
        """The state of what `kernels.closed_inverse_dynamics` found besides tau for u and du, without closing again."""
        values = dict(zip(("s", "ds", "R", "bias", "residuals", "distances"), found, strict=True))
        values["iterations"] = np.zeros((*u.shape[:-1], 1))
        return self._state(
            u, du, self._signs, values, np.zeros(u.shape[:-1], dtype=np.int64), check=True
        )

    def close_path(
        self, u: ArrayLike, du: ArrayLike | None = None, near: ClosedState | None = None
    ) -> ClosedState:
        """Close along a motion u (N, n): each row is followed from the one before, the first from `near`.

        Raises ClosureError or SingularityError with the `index` of the first row that cannot be
        reached on the branch: out of reach, at a toggle or change point, or only by a jump to
        another assembly mode.
        """
        u = finite_vectors("u", u, self.active)
        if u.ndim == 1:
            raise InputError(f"u has shape {u.shape}; expected a motion (N, {len(self.active)})")
        du = np.zeros_like(u) if du is None else finite_vectors("du", du, self.active, len(u))
        signs = self._signs if near is None else near.signs
        values, codes = self._closer.path(u, du, signs, self._start_at(near, 0))
        state = self._state(u, du, signs, values, codes, check=True)
        return state if near is None else replace(state, branch=self._followed(near, state))

    def _followed(self, near: ClosedState, state: ClosedState) -> Mapping[str, str]:
        """Names of the modes after a motion from `near`: loops without a closed form are on the mode they came from."""
        iterating = {step.name for step in self._model.plan.blocks if step.iterates}
        own = {name: near.branch[name] for name in iterating if name in near.branch}
        return MappingProxyType({**state.branch, **own})

    def _start_at(self, near: ClosedState | None, rows: int) -> Start | None:
        if near is None:
            return None
        self._own(near)
        if np.any(near.status):
            raise InputError(
                "near: the state is not closed (its status says why); come from one that is"
            )
        if near.s.ndim == 2 and near.s.shape[0] != rows:
            raise InputError(
                f"near holds {near.s.shape[0]} states; expected one, or one a row of u"
            )
        return Start(near.s, near.R)

    def _close_kernel(self, key: str, model: programs.Model) -> Closer:
        def run(u: Array, du: Array, branch: Array, guess: Array) -> tuple[dict[str, Array], Codes]:
            return self._run(key, programs.CLOSE, model, u=u, du=du, branch=branch, guess=guess)

        return Closer(model, run)

    @cached_property
    def _closer(self) -> Closer:
        return self._close_kernel("close", self._model)

    def close_given(
        self,
        values: Mapping[str, float],
        rates: Mapping[str, float] | None = None,
        accelerations: Mapping[str, float] | None = None,
        near: ClosedState | None = None,
    ) -> ClosedState:
        """Close from any independent set of coordinates: `values` by name [rad or m], with rates and accelerations.

        Rates and accelerations left out are zero. The configuration is followed from `near` (the
        reference if None). Returns the ClosedState with s, ds and dds. Raises InputError, with the
        reason, for a set that does not determine the rest, ClosureError or SingularityError where
        it cannot be reached.
        """
        names = tuple(values)
        model = self._model_for(names)
        at, speed, push = (
            vector_by_name(label, part, names, self.coordinates)
            for label, part in (
                ("values", values),
                ("rates", rates),
                ("accelerations", accelerations),
            )
        )
        start = self._start if near is None else near.s
        signs = matching_signs(model, start)
        closer = self._close_kernel(f"close {names}", model)
        here, _ = closer.at(start, signs)
        closed, code = closer.close(at, speed, signs, Start(here["s"], here["R"]))
        if code != 0:
            raise error_for(programs.Outcome.decode(int(code)), model, at, signs)
        given = {"u": at, "du": speed, "ddu": push, "branch": signs, "guess": closed["s"]}
        moved, _ = self._run(f"accelerations {names}", programs.ACCELERATIONS, model, **given)
        n = len(self.active)
        own = frozen(matching_signs(self._model, closed["s"]))
        u, du = closed["s"][:n].copy(), closed["ds"][:n].copy()
        result, codes = self._run(
            "close", programs.CLOSE, u=u, du=du, branch=own, guess=closed["s"]
        )
        return replace(self._state(u, du, own, result, codes, check=True), dds=moved["dds"])

    def assembly_modes(self, u: ArrayLike) -> tuple[AssemblyMode, ...]:
        """All assembly modes at the active coordinates u (n,): names by loop, and the closed state of each.

        The second solution of a universal joint (the same leg with its cross turned over) is not
        listed.
        """
        u = finite_vectors("u", u, self.active, -1)
        modes = []
        for signs, s, names in list_modes(self._model, u, self._signs, self._start):
            values, codes = self._run(
                "close", programs.CLOSE, u=u, du=np.zeros_like(u), branch=signs, guess=s
            )
            if codes == 0:
                state = self._state(u, np.zeros_like(u), frozen(signs), values, codes, check=True)
                modes.append(AssemblyMode(names, replace(state, branch=names)))
        return tuple(modes)

    # -- inside

    def _model_for(self, names: tuple[str, ...]) -> programs.Model:
        """The model with other given coordinates."""
        if names not in self._given_models:
            unknown = [name for name in names if name not in self.coordinates]
            if unknown:
                raise InputError(no_such_name("coordinate", unknown[0], self.coordinates))
            if len(names) != len(self.active):
                count = len(self.active)
                problem = f"the mechanism has {counted(count, 'degree')} of freedom; name {count}"
                raise InputError(
                    f"{', '.join(names)} ({counted(len(names), 'coordinate')}) cannot be given"
                    f" together: {problem}"
                )
            tree = self._model.tree
            near = dict(enumerate(self._start.tolist()))
            given = [self.coordinates.index(name) for name in names]
            try:
                plan = build_plan(tree, self.description, given, near)
            except DescriptionError as error:
                raise InputError(
                    f"{', '.join(names)} cannot be given together: {error.problem}"
                ) from error
            self._given_models[names] = programs.Model(tree, plan)
        return self._given_models[names]

    def _state(
        self, u: Array, du: Array, signs: Array, values: dict[str, Array], codes: Codes, check: bool
    ) -> ClosedState:
        status: ClosureStatus | np.ndarray
        iterations: int | np.ndarray
        if u.ndim == 1 and codes == 0:  # by far the most frequent case
            status, iterations = ClosureStatus.OK, int(values["iterations"][0])
            residual = max(map(abs, values["residuals"].tolist()), default=0.0)
        else:
            if check:
                raise_for_status(self._model, u, signs, codes, values["distances"])
            if codes.any():
                for value in values.values():
                    value[codes != 0] = np.nan
            status = closure_statuses(codes)
            iterations = np.nan_to_num(values["iterations"][..., 0]).astype(int)
            residual = np.abs(values["residuals"].T, order="C").max(
                axis=0, initial=0.0
            )  # rows are short
            if u.ndim == 1:
                status, iterations, residual = (
                    ClosureStatus(int(status)),
                    int(iterations),
                    float(residual),
                )
        return ClosedState(
            u=frozen(u),
            du=frozen(du),
            s=values["s"],
            ds=values["ds"],
            R=values["R"],
            bias=values["bias"],
            residual=residual,
            branch=self._named_branch(signs),
            signs=signs,
            loops=self.loops,
            distances=self.loop_distances(values["distances"]),
            status=status,
            iterations=iterations,
        )

    @cached_property
    def _loop_order(self) -> tuple[list[int], list[int]]:
        """The steps, loop by loop as in `loops`, and where in them each loop begins."""
        names = [step.name for step in self._model.plan.blocks]
        order = sorted(range(len(names)), key=lambda k: self.loops.index(names[k]))
        ordered = [names[k] for k in order]
        return order, [ordered.index(loop) for loop in self.loops]

    def _named_branch(self, signs: Array) -> Mapping[str, str]:
        """Names of the modes; motions stay on theirs, so they are looked up once."""
        key = signs.tobytes()
        if key not in self._branches:
            steps = zip(self._model.plan.blocks, signs, strict=True)
            modes = [step.modes[0 if sign > 0 else 1] for step, sign in steps]
            self._branches[key] = branch_names(self._model.plan, modes)
        return self._branches[key]

    def kernel(
        self, key: str, program: programs.Program, model: programs.Model | None = None
    ) -> Kernel:
        """The kernel of a program, made when first asked for; `key` tells programs and models apart."""
        if key not in self._kernels:
            label = f"{key.partition(' ')[0]} of {self.name}"
            self._kernels[key] = program.kernel(model or self._model, label)
        return self._kernels[key]

    def _run(
        self,
        key: str,
        program: programs.Program,
        model: programs.Model | None = None,
        **inputs: Array,
    ) -> tuple[dict[str, Array], Codes]:
        return self.kernel(key, program, model)(*(inputs[name] for name in program.inputs))

    def _checked(
        self, key: str, program: programs.Program, state: ClosedState, ddu: Array | None = None
    ) -> dict[str, Array]:
        """Run on a state; rows that `close(..., check=False)` let through stay NaN."""
        self._own(state)
        zero = np.zeros_like(state.u) if ddu is None else ddu
        values, codes = self._run(
            key,
            program,
            u=state.u,
            du=state.du,
            ddu=zero,
            branch=state.signs,
            guess=state.s,
            gravity=self._gravity,
        )
        settle(state, values, codes)
        return values

    def _own(self, state: ClosedState) -> None:
        if not isinstance(state, ClosedState):
            raise InputError(
                f"expected a ClosedState from robot.close(u, du), got {type(state).__name__}"
            )
        if not self.owns(state):
            raise InputError("the state belongs to another robot")

    def owns(self, state: ClosedState) -> bool:
        """Whether a state has this robot's coordinates and loops."""
        return state.s.shape[-1] == len(self.coordinates) and state.loops == self.loops

    def _like(self, state: ClosedState, name: str, value: ArrayLike) -> Array:
        self._own(state)
        return finite_vectors(name, value, self.active, len(state.u) if state.u.ndim == 2 else -1)
