"""The geometry of a robot as a function of what may vary, on arrays.

The description is built once with live numbers; arrays with one entry a row take their places.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..algebra.live import Live, bound, live_numbers
from ..calibration.adjustable import OUTSIDE, AdjustableRobot, FreeParameter
from ..calibration.closed_rows import ClosedRows, Geometry, closed_near
from ..calibration.free_robot import FreeRobot, charts_of
from ..calibration.loop_choices import LoopChoices, with_four_bars
from ..closure.constraints.equations import LoopEquations
from ..closure.constraints.from_description import loop_equations
from ..description.geometry import Transform
from ..description.model import Frame
from ..errors import DescriptionError, InputError
from ..ground.arrays import Array, frozen
from ..kernels.differentiate import evaluate
from ..kernels.graph import Graph
from ..mechanism.tree import Tree, build_tree
from ..robot.parameters.live_model import all_frames, merged_numbers
from ..robot.robot import Robot
from .entries import PLAY, Entry, Play, Table, checked_table
from .pins import Pin, pin_of, with_displaced

PROBE = 1e-3  # [m or rad] change with which the geometry is compared with that of the description
SAME = 1e-9  # difference of the two, in lengths of a loop or of the robot's reach
MISREAD = "is used by a loop in a way that this analysis cannot follow"


@dataclass(frozen=True, eq=False)
class Variable:
    """Something that varies: a number, or the place of a pin in its hole.

    Attributes:
        name: its path.
        entry: its tolerance or play.
        columns: its columns of the variation; one for a number.
        unit: `m` or `rad`; empty if the description does not say.
        pin: the pin with play; None for a number.
    """

    name: str
    entry: Entry
    columns: slice
    unit: str
    pin: Pin | None = None

    @property
    def size(self) -> int:
        """Number of its columns."""
        return len(self.indices)

    @property
    def indices(self) -> range:
        """Indices of its columns."""
        return range(self.columns.start, self.columns.stop)


@dataclass(frozen=True, eq=False)
class _Live:
    """The constants of the geometry that vary."""

    tree: Tree
    loops: tuple[LoopEquations, ...]
    frames: Mapping[str, Frame]


class VariedRobot:
    """A robot whose numbers and pins vary.

    Attributes:
        robot: the robot as it is described.
        variables: what varies.
        count: number of columns of a variation.
    """

    def __init__(self, robot: Robot, table: Table, law: str) -> None:
        """Build the geometry.

        Args:
            robot: the robot as it is described.
            table: tolerances and plays by path.
            law: the law of numbers without one.

        Raises:
            InputError: a path leads to nothing, is given twice, or may not vary; or a value is no
                tolerance.
        """
        self.robot = robot
        self._adjustable = AdjustableRobot(robot)
        entries = checked_table(table, law, self._unit)
        self._tree = build_tree(robot.description)
        self.variables: list[Variable] = []
        self._parameters: list[FreeParameter] = []
        self.count = 0
        for name, entry in entries.items():
            if not isinstance(entry, Play):
                self._add_numbers(name, entry)
        for name, entry in entries.items():
            if isinstance(entry, Play):
                pin = pin_of(name, robot.description, self._tree)
                self._add(Variable(name, entry, self._next(pin.free_directions.shape[1]), "m", pin))
        self._free_robot = self._checked_free_robot()
        self._graph = Graph()
        choices = LoopChoices(self._adjustable, self._parameters, robot.description)
        self._live = self._built(choices.general, ())
        self._require_effect()
        self._require_same()
        pins = [variable for variable in self.variables if variable.pin is not None]
        if pins:  # which break any parallelogram
            loops = [closure.name for closure in robot.description.closures]
            self._live = self._built(loops, pins)

    # -- what varies

    def _unit(self, name: str) -> str:
        """The unit of a path; empty if the description does not say."""
        if name.endswith(PLAY):
            return "m"
        return self._located(name)[0].unit

    def _located(self, name: str) -> list[FreeParameter]:
        """The numbers of a path."""
        try:
            return self._adjustable.parameters([name])
        except InputError as error:
            raise InputError(str(error).replace("free:", "tolerances:", 1)) from error

    def _add_numbers(self, name: str, entry: Entry) -> None:
        """Add a number, or all numbers of a list."""
        for parameter in self._located(name):
            if parameter.place in OUTSIDE:
                raise InputError(
                    f"tolerances: {name} is no part of the robot's geometry; lengths, places of"
                    " joints and pins, tilts and offsets are"
                )
            self._add(Variable(parameter.name, entry, self._next(1), parameter.unit))
            self._parameters.append(parameter)

    def _next(self, size: int) -> slice:
        return slice(self.count, self.count + size)

    def _add(self, variable: Variable) -> None:
        for other in self.variables:
            if _place(other) == _place(variable):
                raise InputError(f"tolerances: '{variable.name}' is given twice")
        self.variables.append(variable)
        self.count = variable.columns.stop

    # -- geometry

    def _checked_free_robot(self) -> FreeRobot | None:
        """The robot of the description with other numbers; None if none varies."""
        if not self._parameters:
            return None
        try:
            free_robot = FreeRobot(self._adjustable, self._parameters)
        except InputError as error:
            raise InputError(str(error).replace("free:", "tolerances:", 1)) from error
        for k, problem in free_robot.fixed.items():
            raise InputError(f"tolerances: {self._parameters[k].name} cannot change: {problem}")
        return free_robot

    def _built(self, general: Collection[str], displaced: Sequence[Variable]) -> _Live:
        """The geometry with live numbers.

        Args:
            general: parallelograms to close as general four-bars.
            displaced: pins with live displacements.
        """
        lives: list[Live] = []
        for k, parameter in enumerate(self._parameters):
            lives.append(Live(parameter.start, self._graph.input(0, k)))
        plain = self._adjustable.numbers((), ())
        live = self._adjustable.numbers(self._parameters, lives)
        merged = merged_numbers(self.robot.description, plain, live)
        pins: list[Pin] = []
        shifts: list[list[Live]] = []
        for variable in displaced:
            assert variable.pin is not None  # noqa: S101
            pins.append(variable.pin)
            symbols = [self._graph.input(0, k) for k in variable.indices]
            shifts.append([Live(0.0, symbol) for symbol in symbols])
        description = with_displaced(with_four_bars(merged, general), pins, shifts)
        tree = build_tree(description)
        loops = loop_equations(tree, description, frozenset())
        return _Live(tree, tuple(loops), all_frames(description))

    @property
    def start(self) -> Array:
        """The columns as they are described (m,): values of the numbers, zero for pins."""
        values = np.zeros(self.count)
        for k, parameter in enumerate(self._parameters):
            values[k] = parameter.start
        return frozen(values)

    def at(self, change: Array) -> Geometry:
        """The geometry with changes (m,), or (N, m) with one row for each row of coordinates."""
        columns = self.start + change
        inputs: dict[int, Any] = {}
        for index, (op, _, component) in enumerate(self._graph.nodes):
            if op == "input":
                column = columns[..., int(component)]
                inputs[index] = _scalar(column)
        numbers = live_numbers(self._live)
        symbols = [number.symbol for number in numbers]
        values = evaluate(self._graph, symbols, inputs)
        by_number: dict[int, Any] = {}
        for number, value in zip(numbers, values, strict=True):
            by_number[id(number)] = value
        live = bound(self._live, by_number)
        gains = np.ones(len(live.tree.coordinates))
        base = Transform(np.eye(3), np.zeros(3))
        return Geometry(live.tree, live.loops, live.frames, base, gains)

    def closed(self, u: Array) -> ClosedRows:
        """Closed states (N) of the described robot at active coordinates u (N, n).

        Raises:
            StateError: a row does not close.
        """
        state = self.robot.close(u)
        geometry = self.at(np.zeros(self.count))
        near = ClosedRows(geometry, np.array(state.s), charts_of(self.robot, state))
        return closed_near(geometry, near, self.given, u)

    @property
    def given(self) -> Array:
        """Indices of the active coordinates (n,)."""
        coordinates = self.robot.coordinates
        indices = [coordinates.index(name) for name in self.robot.active]
        return np.array(indices, dtype=int)

    # -- checks

    def _require_effect(self) -> None:
        """Raise InputError for a number that no pose depends on, such as a mass."""
        live = self._live
        places = [(body.rotation, body.translation, body.axis) for body in live.tree.bodies]
        numbers = live_numbers((live.loops, live.frames, places))
        symbols = [number.symbol for number in numbers]
        used: set[int] = set()
        for index in self._graph.live(symbols):
            op, _, component = self._graph.nodes[index]
            if op == "input":
                used.add(int(component))
        for k, parameter in enumerate(self._parameters):
            if k not in used:
                raise InputError(f"tolerances: {parameter.name} has no effect on the geometry")

    def _require_same(self) -> None:
        """Compare with the geometry of the description with other numbers.

        Raises:
            InputError: a number is used in a way that live numbers do not follow.
        """
        if self._free_robot is None:
            return
        rows = self.closed(self.robot.reference[None])
        for k, parameter in enumerate(self._parameters):
            change, described = self._described(k)
            if not _are_same(_moved(rows, self.at(change)), _moved(rows, described)):
                raise InputError(f"tolerances: {parameter.name} {MISREAD}")

    def _described(self, k: int) -> tuple[Array, Geometry]:
        """A change of the k-th number (m,), and the geometry of the description with it."""
        free_robot = self._free_robot
        assert free_robot is not None  # noqa: S101
        change = np.zeros(self.count)
        change[k] = PROBE
        try:
            return change, free_robot.geometry(free_robot.start + change[: self.numbers])
        except DescriptionError:  # possible on one side only
            change[k] = -PROBE
            return change, free_robot.geometry(free_robot.start + change[: self.numbers])

    @property
    def numbers(self) -> int:
        """Number of the columns that are numbers; those of pins follow."""
        return len(self._parameters)


def _place(variable: Variable) -> tuple[object, ...]:
    pin = variable.pin
    return (variable.name,) if pin is None else (pin.place, pin.key)


def _scalar(column: Array) -> Any:
    """One number as a float, a column of them as an array."""
    return float(column) if column.ndim == 0 else column.copy()


def _moved(rows: ClosedRows, geometry: Geometry) -> ClosedRows:
    return replace(rows, geometry=geometry)


def _are_same(one: ClosedRows, other: ClosedRows) -> bool:
    """Whether two geometries have the same gaps and poses at the same coordinates."""
    reach = one.poses().extent()
    for first, second in zip(_facts(one), _facts(other), strict=True):
        if first.shape != second.shape:
            return False
        apart = np.abs(first - second)
        if apart.max(initial=0.0) > SAME * (1.0 + reach):
            return False
    return True


def _facts(rows: ClosedRows) -> Sequence[Array]:
    """Gaps and their derivatives, each equation in its own unit, and the poses of all frames."""
    gaps, jacobian = rows.geometry.linearised(rows.s, rows.charts)
    units = np.linalg.norm(jacobian, axis=2)
    posed = rows.poses()
    poses = [posed.frame(name) for name in sorted(rows.geometry.frames)]
    turns = np.array([rotation for rotation, _ in poses])
    origins = np.array([origin for _, origin in poses])
    return gaps / units, jacobian / units[:, :, None], turns, origins
