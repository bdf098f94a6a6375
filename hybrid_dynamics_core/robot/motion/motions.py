"""Equations of motion for integrators."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ... import programs
from ...closed_state.state import ClosedState
from ...dynamics.loads import Loads
from ...ground.arrays import Array
from ...ground.check_arguments import require_type
from ...kernels.run import Kernel
from ..closure import Closure
from ..dynamics import Dynamics
from ..loaded_programs import LoadedProgram
from .near import MotionNear
from .steps import MotionSteps

LARGEST_MAP = 10_000  # entries of R: a step keeps it on the stack, and each row of a batch has it


class Motions:
    """Motions of a robot in its active coordinates.

    Args:
        closure: closes its loops.
        dynamics: its dynamics.
    """

    def __init__(self, closure: Closure, dynamics: Dynamics) -> None:
        self._closure = closure
        self._dynamics = dynamics

    def motion_near(self, state: ClosedState, loads: Loads | None = None) -> MotionNear:
        """A function for integrators, which closes the loops from one nearby state.

        Args:
            state: closed state to follow from.
            loads: loads besides the actuators; `robot.loads` if None.

        Returns:
            A function (u, u', tau) -> (u'', power [W]) of vectors (n,). The power is that of tau
            and applied wrenches minus that of friction: the rate of energy. Results are NaN if the
            loops do not close. It raises MassSingularityError as in `forward_dynamics`.
        """
        self._closure.check_state(state)
        acting, kernel, names, constants = self._program("motion", programs.motion, loads)

        def explain(u: Array, du: Array, tau: Array) -> None:
            near = self._closure.close(u, du, near=state)
            self._dynamics.forward_dynamics(near, tau, acting)

        return MotionNear(kernel, names, constants, state, explain)

    def motion_steps(self, loads: Loads | None = None) -> MotionSteps | None:
        """An integrator in compiled code, for motions under constant efforts.

        Args:
            loads: loads besides the actuators; `robot.loads` if None.

        Returns:
            The integrator; None where there is no compiled code, or the robot is too large for it.
        """
        model = self._closure.model
        if len(model.coordinates) * len(model.active) > LARGEST_MAP:
            return None
        program = programs.motion_and_configuration
        _, kernel, names, constants = self._program("motion_steps", program, loads)
        if not kernel.can_step:
            return None
        types = model.joint_types.values()
        angles = np.array([float(kind == "revolute") for kind in types])
        return MotionSteps(kernel, names, constants, angles)

    def _program(self, key: str, program: LoadedProgram, loads: Loads | None) -> _MotionProgram:
        if loads is None:
            loads = self._dynamics.loads
        require_type("loads", loads, Loads, "robot.loads")
        pattern, values = self._dynamics.pack(loads)
        kernel, names = self._dynamics.programs.kernel(key, program, pattern)
        return _MotionProgram(loads, kernel, names, {"gravity": loads.gravity, **values})


class _MotionProgram(NamedTuple):
    """A program of motions under loads.

    Attributes:
        loads: the loads.
        kernel: its code.
        names: names of its inputs, in order.
        constants: values of those that do not vary along a motion.
    """

    loads: Loads
    kernel: Kernel
    names: tuple[str, ...]
    constants: dict[str, Array]
