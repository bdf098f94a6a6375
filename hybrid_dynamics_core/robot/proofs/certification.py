"""Certified closed configurations and efforts."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ... import programs
from ...certified.boxes.certificate import Certificate
from ...certified.boxes.closed_box import Cells, LoopGraph, alone_within, closed_boxes
from ...certified.boxes.enclosed_program import EnclosedProgram
from ...certified.interval import Interval
from ...certified.rounding import down, up
from ...closed_state.state import ClosedState
from ...dynamics.loads import described_loads
from ...dynamics.pack_loads import pack_loads
from ...errors import InputError
from ...ground.arrays import Array, frozen
from ...ground.check_arguments import real_number
from ..closure import Closure
from ..model import RobotModel


class Certification:
    """Certificates of a robot's states.

    Args:
        model: the robot.
        closure: its closure.
    """

    def __init__(self, model: RobotModel, closure: Closure) -> None:
        self._model = model
        self._closure = closure
        self._graphs: dict[tuple[float, ...], LoopGraph] = {}
        self._efforts: dict[tuple[float, ...], EnclosedProgram] = {}

    def certify(
        self, state: ClosedState, ddu: ArrayLike | None = None, radius: float = 0.0
    ) -> Certificate:
        """Prove where the loops close, and what efforts hold the robot there.

        Interval arithmetic in outward rounding runs over the traced graph of the loops' equations,
        then over that of inverse dynamics (docs/certified.md says what this proves).

        Args:
            state: one closed state.
            ddu: active accelerations (n,) [rad/s^2, m/s^2]; zero if None.
            radius: half the width of a box of active coordinates about the state [rad, m]. All of
                the certificate then holds for each u of that box.

        Returns:
            The certificate. It says so if nothing could be proved.

        Raises:
            InputError: the state is a batch, is not closed or belongs to another robot, a shape is
                wrong, or the radius is negative.
        """
        width = real_number("radius", radius)
        if not 0.0 <= width < np.inf:
            raise InputError(f"radius is {width:g}; expected a finite number that is not negative")
        self._closure.check_state(state)
        if state.u.ndim != 1:
            raise InputError("a certificate is that of one state; expected no batch")
        if state.status:
            raise InputError("the state is not closed (its status says why)")
        if ddu is None:
            ddu = np.zeros_like(state.u)
        accelerations = self._closure.vector_like(state, "ddu", ddu)
        graph = self._graph(state)
        if not graph.is_square:
            return self._nothing("a loop has more equations than unknowns (least squares)")
        lower, upper = state.u.copy(), state.u.copy()
        if width:
            lower, upper = down(state.u - width), up(state.u + width)
        cells = Cells(lower[None], upper[None], state.s[graph.unknown][None])
        boxes = closed_boxes(graph, cells)
        if not boxes.holds[0]:
            return self._nothing("the test of Krawczyk fails: singular, open or too wide a box")
        s_lower, s_upper = self._all(lower, boxes.lower[0]), self._all(upper, boxes.upper[0])
        alone = self._all(np.zeros_like(lower), alone_within(graph, cells, boxes)[0])
        box = Interval(s_lower, s_upper)
        tau = self._program(state).at(box, state.du, accelerations)
        reason = "Krawczyk's operator maps a box about the state into itself"
        bounds = (s_lower, s_upper, alone, tau.lower, tau.upper)
        return Certificate(True, reason, *map(frozen, bounds))

    def _all(self, of_given: Array, of_unknown: Array) -> Array:
        """Values of all coordinates (n_s,), from those of the given and the other ones."""
        plan = self._model.program_model.plan
        values = np.zeros(len(self._model.coordinates))
        values[list(plan.given)] = of_given
        unknown = [k for block in plan.blocks for k in block.unknowns]
        values[unknown] = of_unknown
        return values

    def _nothing(self, reason: str) -> Certificate:
        n, size = len(self._model.active), len(self._model.coordinates)
        of_all, of_active = frozen(np.full(size, np.nan)), frozen(np.full(n, np.nan))
        return Certificate(False, reason, of_all, of_all, of_all, of_active, of_active)

    def _graph(self, state: ClosedState) -> LoopGraph:
        model = self._model.program_model
        signs = state.signs.tolist()
        _, charts = model.plan.split(signs)
        key = tuple(charts)
        if key not in self._graphs:
            self._graphs[key] = LoopGraph(model, charts)
        return self._graphs[key]

    def _program(self, state: ClosedState) -> EnclosedProgram:
        """Inverse dynamics under the loads of the description."""
        key = tuple(state.signs.tolist())
        if key not in self._efforts:
            model = self._model
            loads = described_loads(model.description, model.coordinates)
            pattern, values = pack_loads(loads, model.tree, model.frame, None)
            constants = {**values, "gravity": np.asarray(loads.gravity)}
            program = programs.inverse_dynamics(pattern)
            self._efforts[key] = EnclosedProgram(
                model.program_model, program, key, constants, "tau"
            )
        return self._efforts[key]
