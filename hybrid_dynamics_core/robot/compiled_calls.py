"""Fused calls: from active coordinates straight to a result, in one call of compiled code.

    tau = robot.kernels.inverse_dynamics(u, du, ddu)
    M, h, g = robot.kernels.minimal_form(u, du)

One state (n,) or a batch (N, n). With float64 arrays in C order a single state costs little more
than the arithmetic; anything else that holds numbers is converted first. Nothing is left unchecked:
wrong shapes and values that are not finite raise InputError, states that do not close raise what
`robot.close` raises for them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from .. import programs
from ..description.model import Frame
from ..dynamics.load_pattern import LoadPattern
from ..dynamics.loads import Loads
from ..ground.arrays import Array
from ..ground.lazy import lazy
from .compiled_call import CompiledCall

if TYPE_CHECKING:
    from .robot import Robot

Call = Callable[..., Any]
FindFrame = Callable[[str | None], Frame]
Prepare = Callable[
    [Loads], tuple[LoadPattern, dict[str, Array]]
]  # which loads, and all inputs that are not of a state


class RobotKernels:
    """The fused calls of a robot.

    All of them take

        out: arrays for the results (one, or a tuple where there are several): float64, C order, of
        the right shape. check: False to get NaN in rows that have no answer, instead of an error
        that names the first of them. threads: how many work on a batch.

    and as keywords the other vectors of their program, such as gravity=(3,). Loops without a closed
    form are followed from the reference configuration, which takes longer, unless guess=(n_s,), a
    configuration near by, is given.
    """

    def __init__(
        self,
        robot: Robot,
        find: FindFrame,
        prepare: Prepare,
        loads: Loads,
        frame: str | None = None,
    ) -> None:
        self._robot, self._find, self._prepare, self._loads, self._frame = (
            robot,
            find,
            prepare,
            loads,
            frame,
        )

    def at(self, frame: str) -> RobotKernels:
        """The same calls with another frame, or link, in place of the end effector."""
        self._find(frame)
        return RobotKernels(self._robot, self._find, self._prepare, self._loads, frame)

    def under(self, loads: Loads) -> RobotKernels:
        """The same calls under other loads.

        Loads of the same kinds with other values use the same compiled code.
        """
        return RobotKernels(self._robot, self._find, self._prepare, loads, self._frame)

    @lazy
    def close(self) -> Call:
        """(u, du=0) -> s, ds: all coordinates and their rates, (n_s,) or (N, n_s)."""
        return self._fused("all coordinates", programs.MOTION, optional=("du",))

    @lazy
    def forward_kinematics(self) -> Call:
        """(u) -> position (3,) and rotation (3, 3) of the end effector in the base frame."""
        return self._fused(
            f"pose {self._frame!r}", programs.forward_kinematics(self._find(self._frame))
        )

    @lazy
    def jacobian(self) -> Call:
        """(u) -> (6, n): d(linear, angular velocity)/du' of the end effector's origin, base axes."""
        return self._fused(f"jacobian {self._frame!r}", programs.jacobian(self._find(self._frame)))

    @lazy
    def pose_and_jacobian(self) -> Call:
        """(u) -> position (3,), rotation (3, 3) and Jacobian (6, n): what a step of inverse kinematics needs."""
        return self._fused(
            f"pose and jacobian {self._frame!r}",
            programs.pose_and_jacobian(self._find(self._frame)),
        )

    @lazy
    def inverse_dynamics(self) -> Call:
        """(u, du, ddu) -> tau (n,): actuator torques and forces; Chu (2020), Eq. 25."""
        return self._loaded("inverse_dynamics", programs.inverse_dynamics)

    @lazy
    def closed_inverse_dynamics(self) -> Call:
        """(u, du, ddu) -> tau (n,), and s, ds, R, bias, residuals, distances, of which `robot.closed_state` is made.

        What `close` and `inverse_dynamics` of the robot give, to the same bits where every loop has
        a closed form, and refused where one of the two is.
        """
        return self._loaded("closed_inverse_dynamics", programs.closed_inverse_dynamics)

    @lazy
    def minimal_form(self) -> Call:
        """(u, du) -> M-bar (n, n), C-bar u' (n,), G-bar (n,); Chu (2020), Eq. 25."""
        return self._loaded("minimal_form", programs.minimal_form)

    @lazy
    def forward_dynamics(self) -> Call:
        """(u, du, tau) -> ddu (n,): active accelerations from actuator torques and forces."""
        return self._loaded(
            "forward_dynamics", programs.forward_dynamics, self._robot.forward_dynamics
        )

    def _loaded(
        self,
        name: str,
        program: Callable[[LoadPattern], programs.Program],
        explain: Call | None = None,
    ) -> Call:
        """The call of a program under the loads; `explain`: the robot's own method, asked where there is no answer."""
        pattern, _ = self._prepare(self._loads)
        again = None if explain is None else partial(explain, loads=self._loads)
        return self._fused(pattern.key(name), program(pattern), explain=again)

    def _fused(
        self,
        key: str,
        program: programs.Program,
        optional: Sequence[str] = (),
        explain: Call | None = None,
    ) -> Call:
        _, own = self._prepare(self._loads)
        return CompiledCall(self._robot, key, program, own, optional, explain).caller()
