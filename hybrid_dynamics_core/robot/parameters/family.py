"""Robots of one structure: the free parameters are arguments of compiled code."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy

import numpy as np
from numpy.typing import ArrayLike

from ...closed_state.state import ClosedState
from ...dynamics.loads import Loads
from ...dynamics.pack_loads import pack_loads
from ...errors import InputError
from ...ground.arrays import Array, frozen
from ...ground.check_arrays import finite_vectors
from ...ground.suggestions import no_such_name
from ...kernels import generated
from ...kernels.run import Kernel
from ...programs.live import PARAMETERS, LiveCall, LiveModel, LiveProgram
from ..closure import Closure
from ..model import RobotModel
from .family_result import BY, FamilyResult, by_loop, result_of

_PIN = ("pin_forces", "pin_moments")


Derivatives = bool | tuple[str, ...]


class RobotFamily:
    """A robot whose free parameters are arguments of its compiled code.

    All calls take active coordinates u (n,) or (N, n) and parameters (k,) or (N, k), also mixed,
    in the order of `names`. Code is compiled once. Closed forms stay those of the robot.

    Attributes:
        coordinates: names of the coordinates u that calls take: the active ones, or others.
        all_coordinates: names of `s`.
        names: names of the free parameters.
        values: their values in the description (k,).
    """

    def __init__(
        self,
        closure: Closure,
        loads: Loads,
        live: LiveModel,
        values: Mapping[str, float],
        loads_are_free: bool,
    ) -> None:
        """Store the parts; nothing is compiled yet.

        Args:
            closure: closure of the described robot.
            loads: loads of the description.
            live: the model with live numbers.
            values: values by name of the parameter.
            loads_are_free: whether the parameters change loads, which are no part of the model.
        """
        self.names = tuple(values)
        self.values = frozen(list(values.values()))
        self._closure = closure
        self._model: RobotModel = closure.model
        self._loads = loads
        self._live = live
        described = live.described or closure.model.program_model
        self._signs = frozen(described.plan.signs)
        self._reference = frozen(described.plan.reference.q)
        given = [closure.model.coordinates[k] for k in described.plan.given]
        self.coordinates = tuple(given)
        self.all_coordinates = closure.model.coordinates
        self._is_active = self.coordinates == closure.model.active
        self._loads_are_free = loads_are_free
        self._backend: str | None = None
        self._kernels: dict[tuple[LiveCall, tuple[str, ...]], Kernel] = {}

    @property
    def reference(self) -> Mapping[str, float]:
        """All coordinates at the reference of the description, by name [rad, m]."""
        return dict(zip(self.all_coordinates, self._reference.tolist(), strict=True))

    def interpreted(self) -> RobotFamily:
        """The same without a compiler: ready at once, and slower in long batches."""
        other = copy(self)
        vars(other).update(_backend=generated.NAME, _kernels={})
        return other

    def close(
        self, u: ArrayLike, parameters: ArrayLike | None = None, derivatives: Derivatives = True
    ) -> FamilyResult:
        """Close the loops: `s` (n_s,), `R` (n_s, n), and `distances` to singularities by loop.

        Args:
            u: active coordinates [rad, m].
            parameters: values of the parameters; those of the description if None.
            derivatives: whether to differentiate, or only by some of "parameters" and "u".

        Raises:
            InputError: a shape is wrong, or a value is not finite.
        """
        names = ("s", "R", "distances")
        result = self._run(LiveCall("close"), names, u, parameters, derivatives)
        blocks = [block.name for block in self._live.plan.blocks]
        return by_loop(result, blocks, tuple(dict.fromkeys(blocks)))

    def forward_kinematics(
        self,
        u: ArrayLike,
        parameters: ArrayLike | None = None,
        frame: str | None = None,
        derivatives: Derivatives = True,
    ) -> FamilyResult:
        """The pose of a frame: `position` (3,) [m] and `rotation` (3, 3), in base axes.

        Args:
            u: active coordinates [rad, m].
            parameters: values of the parameters; those of the description if None.
            frame: name in `frames`; the end effector if None.
            derivatives: whether to differentiate, or only by some of "parameters" and "u".

        Raises:
            InputError: there is no such frame, or a vector is wrong.
        """
        call = LiveCall("pose", self._frame(frame))
        return self._run(call, ("position", "rotation"), u, parameters, derivatives)

    def jacobian(
        self,
        u: ArrayLike,
        parameters: ArrayLike | None = None,
        frame: str | None = None,
        derivatives: Derivatives = True,
    ) -> FamilyResult:
        """The `jacobian` (6, n) of a frame's origin, linear before angular, in base axes.

        Args:
            u: active coordinates [rad, m].
            parameters: values of the parameters; those of the description if None.
            frame: name in `frames`; the end effector if None.
            derivatives: whether to differentiate, or by what. By the parameters, these are mixed
                derivatives of the pose.

        Raises:
            InputError: there is no such frame, or a vector is wrong.
        """
        call = LiveCall("jacobian", self._frame(frame))
        return self._run(call, ("jacobian",), u, parameters, derivatives)

    def inverse_dynamics(
        self,
        u: ArrayLike,
        parameters: ArrayLike | None = None,
        du: ArrayLike | None = None,
        ddu: ArrayLike | None = None,
        loads: Loads | None = None,
        derivatives: Derivatives = True,
    ) -> FamilyResult:
        """The efforts `tau` (n,) [N m, N] of a motion under the loads of the description.

        Args:
            u: active coordinates [rad, m].
            parameters: values of the parameters; those of the description if None.
            du: active rates; zero if None.
            ddu: active accelerations; zero if None.
            loads: other loads than those of the description.
            derivatives: whether to differentiate, or only by some of "parameters" and "u".

        Raises:
            InputError: a vector is wrong, or a parameter is part of a load.
        """
        motion = self._motion(u, du, ddu)
        loads = self._checked(loads)
        return self._dynamic("inverse_dynamics", ("tau",), motion, loads, (parameters, derivatives))

    def reactions(
        self,
        u: ArrayLike,
        parameters: ArrayLike | None = None,
        du: ArrayLike | None = None,
        ddu: ArrayLike | None = None,
        loads: Loads | None = None,
        derivatives: Derivatives = True,
    ) -> FamilyResult:
        """Forces in pins of closures: `pin_forces` [N], `pin_moments` [N m] (pins, 3), base axes.

        Args:
            u: active coordinates [rad, m].
            parameters: values of the parameters; those of the description if None.
            du: active rates; zero if None.
            ddu: active accelerations; zero if None.
            loads: other loads than those of the description.
            derivatives: whether to differentiate, or only by some of "parameters" and "u".

        Raises:
            InputError: a vector is wrong, or a parameter is part of a load.
        """
        motion = self._motion(u, du, ddu)
        loads = self._checked(loads)
        return self._dynamic("reactions", _PIN, motion, loads, (parameters, derivatives))

    def mass(self, parameters: ArrayLike | None = None) -> float:
        """Mass of all moving links [kg].

        Args:
            parameters: values of the parameters (k,); those of the description if None.
        """
        bodies = self._live.at(self._parameters(parameters).tolist()).tree.bodies
        return float(sum(body.mass for body in bodies))

    # -- computation

    def _checked(self, loads: Loads | None) -> Loads:
        """The loads of a call."""
        if loads is not None:
            return loads
        if self._loads_are_free:
            names = ", ".join(self.names)
            raise InputError(
                f"{names}: one of them is part of a load or effect, which dynamics take as `loads`"
            )
        return self._loads

    def _dynamic(
        self,
        kind: str,
        outputs: tuple[str, ...],
        motion: Mapping[str, Array],
        loads: Loads,
        at: tuple[ArrayLike | None, Derivatives],
    ) -> FamilyResult:
        """Results of dynamics; `at` are the parameters, and whether to differentiate."""
        rows = len(motion["u"]) if motion["u"].ndim == 2 else None
        pattern, values = pack_loads(loads, self._model.tree, self._model.frame, rows)
        values = {**values, **motion, "gravity": loads.gravity}
        call = LiveCall(kind, pattern=pattern)
        parameters, derivatives = at
        return self._run(call, outputs, motion["u"], parameters, derivatives, values)

    def _motion(
        self, u: ArrayLike, du: ArrayLike | None, ddu: ArrayLike | None
    ) -> dict[str, Array]:
        motion = {"u": self._vector("u", u)}
        for name, vector in (("du", du), ("ddu", ddu)):
            motion[name] = np.zeros(len(self.coordinates))
            if vector is not None:
                motion[name] = self._vector(name, vector)
        return motion

    def _run(
        self,
        call: LiveCall,
        outputs: tuple[str, ...],
        u: ArrayLike,
        parameters: ArrayLike | None,
        derivatives: Derivatives,
        values: Mapping[str, Array] | None = None,
    ) -> FamilyResult:
        by = _vectors(derivatives)
        program = LiveProgram(self._live, call, outputs, by)
        kernel = self._kernels.get((call, by))
        if kernel is None:
            label = f"{call.kind} of {self._model.name} with free parameters"
            kernel = self._kernels[call, by] = program.kernel(label, self._backend)
        active = self._vector("u", u)
        inputs = {
            "u": active,
            "du": np.zeros(active.shape[-1]),
            "branch": self._signs,
            "guess": self._guess(active),
            PARAMETERS: self._parameters(parameters),
            **(values or {}),
        }
        arguments = [inputs[name] for name in program.inputs]
        _check_rows(dict(zip(program.inputs, arguments, strict=True)))
        results, codes = kernel(*arguments)
        lengths = {name: inputs[name].shape[-1] for name in by}
        return result_of(results, codes, outputs, lengths)

    def _vector(self, name: str, value: ArrayLike) -> Array:
        return finite_vectors(name, value, self.coordinates)

    def _parameters(self, parameters: ArrayLike | None) -> Array:
        if parameters is None:
            return self.values
        return finite_vectors(PARAMETERS, parameters, self.names)

    def _guess(self, u: Array) -> Array:
        """Where iterations start: at the described robot, closed at the same coordinates."""
        if not (self._closure.iterates and self._is_active):
            return self._reference
        state: ClosedState = self._closure.close(u, check=False)
        return np.where(np.isfinite(state.s), state.s, self._reference)

    def _frame(self, frame: str | None) -> str:
        name = self._model.description.end_effector if frame is None else frame
        if name not in self._model.frames:
            raise InputError(no_such_name("frame", name, self._model.frames))
        return name


def _vectors(derivatives: Derivatives) -> tuple[str, ...]:
    """The vectors by which results are differentiated."""
    if isinstance(derivatives, bool):
        return BY if derivatives else ()
    for name in derivatives:
        if name not in BY:
            raise InputError(no_such_name("vector", name, BY))
    return tuple(derivatives)


def _check_rows(arguments: Mapping[str, Array]) -> None:
    """Raise if batches have different numbers of rows."""
    rows = {name: len(array) for name, array in arguments.items() if array.ndim == 2}
    if len(set(rows.values())) > 1:
        listed = ", ".join(f"{name} has {count}" for name, count in rows.items())
        raise InputError(f"batches need equally many rows: {listed}")
