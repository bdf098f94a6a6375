"""Certified closed configurations and efforts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ... import programs
from ...certified.boxes.cells import CellKind, CertifiedCells, Near, Subdivision
from ...certified.boxes.certificate import Certificate
from ...certified.boxes.closed_box import ClosedBoxes, alone_within, closed_boxes
from ...certified.boxes.closed_forms import ClosedForms, Verdicts
from ...certified.boxes.enclosed_program import EnclosedProgram
from ...certified.boxes.loop_graph import Cells, LoopGraph
from ...certified.interval import Interval
from ...certified.rounding import down, up
from ...closed_state.state import ClosedState
from ...description.model import Frame
from ...dynamics.loads import described_loads
from ...dynamics.pack_loads import pack_loads
from ...errors import InputError
from ...ground.arrays import Array, frozen
from ...ground.check_arguments import integer, real_number, require_type
from ...ground.check_arrays import real_array
from ...ground.suggestions import no_such_name
from ..closure import Closure
from ..model import RobotModel

DEPTH = 12  # how often a cell is halved by default
DEEPEST = 30  # the largest depth that a caller may ask for


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
        self._check_one_closed(state)
        if ddu is None:
            ddu = np.zeros_like(state.u)
        accelerations = self._closure.vector_like(state, "ddu", ddu)
        graph = self._graph(state)
        if not graph.is_square:
            return self._nothing("a loop has more equations than unknowns (least squares)")
        lower, upper = state.u.copy(), state.u.copy()
        if width:
            lower, upper = down(state.u - width), up(state.u + width)
        solution = state.s[graph.unknown]
        cells = Cells(lower[None], upper[None], solution[None])
        boxes = closed_boxes(graph, cells)
        if not boxes.holds[0]:
            return self._nothing("the test of Krawczyk fails: singular, open or too wide a box")
        # of all coordinates, from the active ones and the unknowns
        s_lower = self._all(lower, boxes.lower[0])
        s_upper = self._all(upper, boxes.upper[0])
        radii = alone_within(graph, cells, boxes)
        alone = self._all(np.zeros_like(lower), radii[0])
        rows = Interval(s_lower[None], s_upper[None])
        efforts = self._program(state)
        tau = efforts.at(rows, state.du, accelerations)
        reason = "Krawczyk's operator maps a box about the state into itself"
        return Certificate(
            holds=True,
            reason=reason,
            s_lower=frozen(s_lower),
            s_upper=frozen(s_upper),
            alone=frozen(alone),
            tau_lower=frozen(tau.lower[0]),
            tau_upper=frozen(tau.upper[0]),
        )

    def certify_cells(
        self,
        ranges: Mapping[str, tuple[float, float]] | None = None,
        depth: int = DEPTH,
        frame: str | None = None,
    ) -> CertifiedCells:
        """Prove of cells of active coordinates that the loops close in them, or that they do not.

        The box of the ranges is halved until each cell is decided, or was halved `depth` times.
        Limits of joints are not considered.

        Args:
            ranges: range of each active coordinate by name [rad, m]; the others are held at the
                reference. The limits of all of them if None.
            depth: how often a cell is halved at most, each time across its longest side.
            frame: name of the frame whose places are enclosed; the end effector if None.

        Returns:
            The cells: closed without a singularity, open, or undecided.

        Raises:
            InputError: a name is unknown, a range is empty or not finite, the depth is not from 0
                to 30, or loops are solved by least squares.
        """
        steps = integer("depth", depth)
        if not 0 <= steps <= DEEPEST:
            raise InputError(f"depth is {steps}; expected an integer from 0 to {DEEPEST}")
        lower, upper = self._box(ranges)
        place = self._model.frame(frame)
        reference = self._closure.close(self._model.reference)
        graph = self._graph(reference)
        if not graph.is_square:
            raise InputError("a loop has more equations than unknowns (least squares)")
        model = self._model.program_model
        signs = reference.signs.tolist()
        forms = ClosedForms(model, signs, reference.s.tolist(), place)
        subdivision = Subdivision(graph, forms, self._near(graph))
        cells, kinds, boxes, verdicts = subdivision.decided(lower, upper, steps)
        places = self._places(cells, boxes, signs, place)
        lowest, highest = _tightest(places, boxes, verdicts)
        closed = (kinds == CellKind.CLOSED)[:, None]
        return CertifiedCells(
            lower=frozen(cells.lower),
            upper=frozen(cells.upper),
            kind=kinds,
            position_lower=frozen(np.where(closed, lowest, np.nan)),
            position_upper=frozen(np.where(closed, highest, np.nan)),
        )

    def _check_one_closed(self, state: ClosedState) -> None:
        self._closure.check_state(state)
        if state.u.ndim != 1:
            raise InputError("a certificate is that of one state; expected no batch")
        if state.status:
            raise InputError("the state is not closed (its status says why)")

    def _near(self, graph: LoopGraph) -> Near:
        """A function from u (k, n) to the unknowns (k, m) there, and to whether the loops close."""

        def near(u: Array) -> tuple[Array, NDArray[np.bool_]]:
            states = self._closure.close(u, check=False)
            closes = np.asarray(states.status == 0)
            return states.s[:, graph.unknown], closes

        return near

    def _places(
        self,
        cells: Cells,
        boxes: ClosedBoxes,
        signs: Sequence[float],
        place: Frame,
    ) -> Interval:
        """Positions (k, 3) [m] of a frame in the cells, enclosed through the boxes of unknowns."""
        model = self._model.program_model
        program = programs.forward_kinematics(place)
        position = EnclosedProgram(model, program, signs, {}, "position")
        s = Interval(
            self._all(cells.lower, boxes.lower),
            self._all(cells.upper, boxes.upper),
        )
        still = np.zeros(len(model.plan.given))
        with np.errstate(all="ignore"):
            return position.at(s, still, still)

    def _box(
        self,
        ranges: Mapping[str, tuple[float, float]] | None,
    ) -> tuple[Array, Array]:
        """Lower and upper bounds (n,) of the active coordinates."""
        active = self._model.active
        lower = self._model.reference.copy()
        upper = self._model.reference.copy()
        if ranges is None:
            ranges = dict(zip(active, self._model.limits.tolist(), strict=True))
        require_type("ranges", ranges, Mapping, "{'q1': (0.0, 1.0)}")
        for name, ends in ranges.items():
            if name not in active:
                raise InputError(f"ranges: {no_such_name('active coordinate', name, active)}")
            bounds = real_array(f"range of {name}", ends)
            if bounds.shape != (2,):
                raise InputError(f"ranges: {name} is {ends}; expected (lower, upper)")
            first, last = bounds.tolist()
            if not -np.inf < first <= last < np.inf:
                raise InputError(f"ranges: {name} is [{first:g}, {last:g}]; expected finite bounds")
            k = active.index(name)
            lower[k] = first
            upper[k] = last
        return lower, upper

    def _all(self, of_given: Array, of_unknown: Array) -> Array:
        """Values of all coordinates (..., n_s), from those of the given and the other ones."""
        plan = self._model.program_model.plan
        values = np.zeros((*of_given.shape[:-1], len(self._model.coordinates)))
        values[..., list(plan.given)] = of_given
        unknown = [k for block in plan.blocks for k in block.unknowns]
        values[..., unknown] = of_unknown
        return values

    def _nothing(self, reason: str) -> Certificate:
        """The certificate if nothing was proved."""
        of_all = frozen(np.full(len(self._model.coordinates), np.nan))
        of_active = frozen(np.full(len(self._model.active), np.nan))
        return Certificate(
            holds=False,
            reason=reason,
            s_lower=of_all,
            s_upper=of_all,
            alone=of_all,
            tau_lower=of_active,
            tau_upper=of_active,
        )

    def _graph(self, state: ClosedState) -> LoopGraph:
        model = self._model.program_model
        signs = state.signs.tolist()
        _, charts = model.plan.split(signs)
        key = tuple(charts)
        if key not in self._graphs:
            self._graphs[key] = LoopGraph(model.tree, model.plan.blocks, model.plan.given, charts)
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


def _tightest(places: Interval, boxes: ClosedBoxes, verdicts: Verdicts) -> tuple[Array, Array]:
    """Lower and upper bounds (k, 3) [m] of places by both proofs; infinite without a proof."""
    by_form = verdicts.closes[:, None]
    by_test = boxes.holds[:, None]
    lowest = np.where(by_test, places.lower, -np.inf)
    highest = np.where(by_test, places.upper, np.inf)
    above = np.fmax(lowest, verdicts.place_lower)
    below = np.fmin(highest, verdicts.place_upper)
    return np.where(by_form, above, lowest), np.where(by_form, below, highest)
