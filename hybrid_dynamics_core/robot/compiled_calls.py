"""Compiled calls: from active coordinates to a result in one call of compiled code.

    tau = robot.kernels.inverse_dynamics(u, du, ddu)
    M, h, g = robot.kernels.minimal_form(u, du)

The calls take one state (n,) or a batch (N, n). With float64 arrays in C order, a single state
costs little more than its arithmetic. Other arguments are converted first. Wrong shapes and values
that are not finite raise InputError. States that do not close raise the error of `robot.close`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from .. import programs
from ..closed_state.state import ClosedState
from ..description.model import Frame
from ..dynamics.load_pattern import LoadPattern
from ..dynamics.loads import Loads
from ..ground.arrays import Array, frozen
from ..ground.lazy import lazy
from .call_kernels import CallKernels
from .closure import Closure
from .compiled_call import CompiledCall
from .dynamics import Dynamics
from .kernel_store import KernelStore
from .warm_start import WarmStart

Call = Callable[..., Any]
ProgramOfLoads = Callable[[LoadPattern], programs.Program]
ProgramOfFrame = Callable[[Frame], programs.Program]


class RobotKernels:
    """The compiled calls of a robot.

    All calls also take these keywords:

        out: array for the result, or a tuple of several: float64, C order, right shape.
        check: False for NaN in rows without a result, instead of an error.
        threads: number of threads for a batch.

    and the other vectors of their program, such as gravity=(3,). Loops without a closed form are
    iterated from the reference configuration. What is far from it is followed in small steps, which
    takes longer. Along a motion, give start=robot.kernels.start(): each call starts from the
    configuration of the previous one, and refuses to jump to another mode. A batch is then a motion
    too. With guess=(n_s,), a configuration nearby, nothing is compared.
    """

    def __init__(
        self,
        kernels: KernelStore,
        closure: Closure,
        dynamics: Dynamics,
        loads: Loads,
        frame: str | None = None,
    ) -> None:
        self._kernels = kernels
        self._closure = closure
        self._dynamics = dynamics
        self._loads = loads
        self._frame = frame

    def at(self, frame: str) -> RobotKernels:
        """The same calls for another frame or link in place of the end effector.

        Raises:
            InputError: there is no such frame.
        """
        self._closure.model.frame(frame)
        return RobotKernels(self._kernels, self._closure, self._dynamics, self._loads, frame)

    def under(self, loads: Loads) -> RobotKernels:
        """The same calls under other loads.

        Loads of the same kinds with other values use the same compiled code.
        """
        return RobotKernels(self._kernels, self._closure, self._dynamics, loads, self._frame)

    def start(self, state: ClosedState | None = None) -> WarmStart:
        """Where a motion starts, for the argument `start` of the calls.

        Args:
            state: closed state of this robot; the reference configuration if None.

        Raises:
            InputError: the state is of another robot, a batch, or not closed.
        """
        if state is None:
            state = self._closure.close(self._closure.start[: len(self._closure.model.active)])
        self._closure.check_state(state)
        return WarmStart(state)

    @lazy
    def close(self) -> Call:
        """(u, du=0) -> s, ds. All coordinates and their rates, (n_s,) or (N, n_s)."""
        return self._compile("all coordinates", programs.MOTION, optional=("du",))

    @lazy
    def forward_kinematics(self) -> Call:
        """(u) -> position (3,) and rotation (3, 3) of the end effector in the base frame."""
        return self._compile_at_frame("pose", programs.forward_kinematics)

    @lazy
    def jacobian(self) -> Call:
        """(u) -> Jacobian (6, n) of the tool, d(linear, angular velocity)/du', base axes."""
        return self._compile_at_frame("jacobian", programs.jacobian)

    @lazy
    def pose_and_jacobian(self) -> Call:
        """(u) -> position (3,), rotation (3, 3), Jacobian (6, n), for inverse kinematics."""
        return self._compile_at_frame("pose and jacobian", programs.pose_and_jacobian)

    @lazy
    def inverse_dynamics(self) -> Call:
        """(u, du, ddu) -> tau (n,) of the minimal form, torques and forces; Chu (2020), Eq. 17."""
        return self._compile_under_loads("inverse_dynamics", programs.inverse_dynamics)

    @lazy
    def closed_inverse_dynamics(self) -> Call:
        """(u, du, ddu) -> tau (n,), and s, ds, R, bias, residuals, distances of the closed state.

        `robot.closed_state` builds a ClosedState from them. The results equal those of the robot's
        `close` and `inverse_dynamics`, bit by bit if every loop has a closed form. Errors are the
        same too.
        """
        program = programs.closed_inverse_dynamics
        return self._compile_under_loads("closed_inverse_dynamics", program)

    @lazy
    def minimal_form(self) -> Call:
        """(u, du) -> M-bar (n, n), C-bar u' (n,), G-bar (n,); Chu (2020), Eq. 17."""
        return self._compile_under_loads("minimal_form", programs.minimal_form)

    @lazy
    def forward_dynamics(self) -> Call:
        """(u, du, tau) -> ddu (n,). Active accelerations from actuator torques and forces."""
        explain = partial(self._dynamics.forward_dynamics, loads=self._loads)
        return self._compile_under_loads("forward_dynamics", programs.forward_dynamics, explain)

    def _compile_at_frame(
        self,
        name: str,
        program: ProgramOfFrame,
    ) -> Call:
        frame = self._closure.model.frame(self._frame)
        return self._compile(f"{name} {self._frame!r}", program(frame))

    def _compile_under_loads(
        self,
        name: str,
        program: ProgramOfLoads,
        explain: Call | None = None,
    ) -> Call:
        """The call of a program under the loads.

        Args:
            name: name of the program.
            program: function from a pattern of loads to the program.
            explain: the robot's method that raises the error of states without a result.
        """
        pattern, values = self._dynamics.pack(self._loads)
        constants = {**self._constants, "gravity": frozen(self._loads.gravity), **values}

        def call(
            pattern: LoadPattern, under_any_gravity: Callable[[], CompiledCall] | None
        ) -> CompiledCall:
            kernels = CallKernels(self._kernels, pattern.key(name), program(pattern))
            return CompiledCall(
                kernels,
                self._closure,
                constants,
                explain=explain,
                under_any_gravity=under_any_gravity,
            )

        def general() -> CompiledCall:
            return call(pattern.under_any_gravity(), None)

        return call(pattern, general).caller()

    def _compile(
        self,
        key: str,
        program: programs.Program,
        optional: Sequence[str] = (),
    ) -> Call:
        kernels = CallKernels(self._kernels, key, program)
        call = CompiledCall(kernels, self._closure, self._constants, optional)
        return call.caller()

    @lazy
    def _constants(self) -> dict[str, Array]:
        """Inputs of all programs that do not vary with the state."""
        return {"branch": self._closure.signs, "guess": self._closure.start}
