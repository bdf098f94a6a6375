"""The calls of a robot as Functions of CasADi.

    dynamics = robot.casadi.forward_dynamics
    ddu, status = dynamics(u, du, tau)
    A = dynamics.jacobian()

Derivatives, maps and C code are CasADi's own.
"""

from __future__ import annotations

import re
from typing import Any

from ...closed_state.continuation import Start
from ...closed_state.state import ClosedState
from ...dynamics.loads import Loads
from ...errors import InputError
from ...ground.arrays import Array
from ...ground.lazy import lazy
from ..closure import Closure
from ..closure_runs import start_inputs
from ..dynamics import Dynamics
from .calls import CALL_BY_NAME, CallTracer

try:
    import casadi  # noqa: F401  whether it is there

    from ...kernels.frameworks import casadi_functions
except ModuleNotFoundError as error:  # pragma: no cover
    if error.name != "casadi":
        raise
    raise InputError(
        "robot.casadi needs CasADi: pip install 'hybrid_dynamics_ros[casadi]', or casadi"
    ) from error

Function = Any  # casadi.Function


class CasadiCalls:
    """The calls of a robot in CasADi.

    Each is a `casadi.Function` of vectors (n,). Its outputs are the results and `status`: 0
    (CLOSED), or the number of another `OutcomeKind`. With another one the results have no meaning.
    Derivatives, maps and C code are CasADi's own. Gravity, loads and assembly modes are constants.

    Loops without a closed form are closed from the reference configuration in one smooth move, or
    from another state, `robot.casadi.near(state)`. The status is JUMP if u is too far away.
    """

    def __init__(
        self,
        closure: Closure,
        dynamics: Dynamics,
        loads: Loads,
        frame: str | None = None,
        state: ClosedState | None = None,
    ) -> None:
        self._closure = closure
        self._dynamics = dynamics
        self._loads = loads
        self._frame = frame
        self._state = state

    def at(self, frame: str) -> CasadiCalls:
        """The same calls for another frame or link in place of the end effector.

        Raises:
            InputError: there is no such frame.
        """
        self._closure.model.frame(frame)
        return CasadiCalls(self._closure, self._dynamics, self._loads, frame, self._state)

    def under(self, loads: Loads) -> CasadiCalls:
        """The same calls under other loads."""
        return CasadiCalls(self._closure, self._dynamics, loads, self._frame, self._state)

    def near(self, state: ClosedState) -> CasadiCalls:
        """The same calls on the assembly mode of a state; iterated loops start from the state.

        Raises:
            InputError: the state is of another robot, a batch, or not closed.
        """
        self._closure.check_state(state)
        if state.u.ndim != 1 or state.status:
            raise InputError("expected one closed state, not a batch")
        return CasadiCalls(self._closure, self._dynamics, self._loads, self._frame, state)

    @lazy
    def close(self) -> Function:
        """(u, du) -> s (n_s), ds (n_s), status."""
        return self._function("close")

    @lazy
    def forward_kinematics(self) -> Function:
        """(u) -> position (3), rotation (3, 3) of the end effector, status."""
        return self._function("forward_kinematics")

    @lazy
    def jacobian(self) -> Function:
        """(u) -> jacobian (6, n) of the end effector, linear before angular, status."""
        return self._function("jacobian")

    @lazy
    def inverse_dynamics(self) -> Function:
        """(u, du, ddu) -> tau (n), status, by the minimal form; Chu (2020), Eq. 17."""
        return self._function("inverse_dynamics")

    @lazy
    def forward_dynamics(self) -> Function:
        """(u, du, tau) -> ddu (n), status, by the minimal form; Chu (2020), Eq. 17."""
        return self._function("forward_dynamics")

    @lazy
    def minimal_form(self) -> Function:
        """(u, du) -> M (n, n), h (n), g (n), status; minimal form, Chu (2020), Eq. 17."""
        return self._function("minimal_form")

    def _function(self, name: str) -> Function:
        """The Function of a call."""
        tracer = self._tracer
        call = CALL_BY_NAME[name]
        names = (*call.inputs, *tracer.start_names())
        # CasADi allows letters, digits and single underscores
        title = re.sub(r"\W+|_+", "_", f"{self._closure.model.name}_{name}").strip("_")
        traced = tracer.values(call)
        return casadi_functions.function(traced, f"f_{title}", names, self._constants())

    def _constants(self) -> dict[str, list[float]]:
        """Gravity (3) [m/s^2], and the start or guess of the loops, by name of the input."""
        constants = {"gravity": list(self._loads.gravity)}
        for name, array in self._start_inputs().items():
            constants[name] = array.tolist()
        return constants

    def _start_inputs(self) -> dict[str, Array]:
        """Start of loops that are followed, guess (n_s,) for those with closed forms."""
        state = self._state
        if not self._closure.is_followed:
            return {"guess": self._closure.start if state is None else state.s}
        if state is None:
            return start_inputs(self._closure.reference_start)
        return start_inputs(Start(state.s, state.R))

    @lazy
    def _tracer(self) -> CallTracer:
        """Traces the calls under these loads and on this assembly mode."""
        signs = self._closure.signs if self._state is None else self._state.signs
        return CallTracer(self._closure, self._dynamics, self._loads, self._frame, signs)
