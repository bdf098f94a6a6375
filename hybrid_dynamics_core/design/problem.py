"""A design: variables with bounds, a duty cycle, an objective and constraints, and its solution."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from ..errors import InputError
from ..ground.arrays import Array, frozen
from ..ground.suggestions import no_such_name
from ..robot.robot import Robot
from .cycle import Cycle, Duty
from .quantity import Quantity
from .solution import DesignResult, Evaluation, result_of

Function = Callable[[Cycle], Quantity]
Method = Literal["SLSQP", "trust-constr"]
Bounds = Mapping[str, tuple[float, float]]

_OPEN = 1e3  # objective in lengths of its first value, where loops do not close


class Design:
    """A design problem of a robot.

    Attributes:
        names: names of the variables.
        lower: their lower bounds (k,).
        upper: their upper bounds (k,).
        start: their values in the description (k,).
    """

    def __init__(
        self,
        robot: Robot,
        variables: Bounds,
        duty: Sequence[Duty],
        given: Sequence[str] | None = None,
    ) -> None:
        """Check the variables and the duty cycle.

        Args:
            robot: the robot to start from.
            variables: (lower, upper) bound in SI units, by name of `parameters:` or path.
            duty: points of the duty cycle.
            given: coordinates that the points name; the active ones if None.

        Raises:
            InputError: a name is unknown, or a bound is not on its side of the start.
        """
        if not duty:
            raise InputError("a design needs at least one point of duty")
        self._robot = robot
        self._duty = tuple(duty)
        self.names = tuple(variables)
        self._family = robot.free(*self.names, given=given).interpreted()
        self.start = self._family.values
        self.lower, self.upper = self._bounds(variables)
        self._reference = self._family.reference
        for point in self._duty:
            for name in (*point.at, *point.rates, *point.accelerations):
                if name not in self._family.coordinates:
                    raise InputError(
                        no_such_name("given coordinate", name, self._family.coordinates)
                    )

    def cycle(self, values: Sequence[float] | Array | None = None) -> Cycle:
        """The duty cycle at values (k,) of the variables; at the start if None."""
        at = self.start if values is None else np.asarray(values, dtype=np.float64)
        return Cycle(self._family, self._duty, self._reference, self._robot, at)

    def minimise(
        self,
        objective: Function,
        at_least: Mapping[str, Function] | None = None,
        equal: Mapping[str, Function] | None = None,
        starts: int = 1,
        method: Method = "SLSQP",
    ) -> DesignResult:
        """The values of the variables with the least objective.

        Args:
            objective: function of the cycle, one number.
            at_least: functions of the cycle whose entries are zero or above, by name.
            equal: functions whose entries are zero, by name.
            starts: number of starts: the description, then points spread over the bounds.
            method: SciPy's solver.

        Returns:
            The best design of all starts, with active constraints and their sensitivities.

        Raises:
            InputError: the loops do not close at the start, or `starts` is below 1.
        """
        if starts < 1:
            raise InputError(f"starts is {starts}; expected 1 or more")
        if not self.cycle().closes:
            raise InputError(
                "the loops do not close at every point of duty with the start's values"
            )
        problem = _Problem(self, objective, at_least or {}, equal or {})
        runs = [problem.solve(start, method) for start in self._starts(starts)]
        best = min(runs, key=lambda run: (run.violation > problem.slack, run.objective))
        return result_of(
            self._robot, self.names, problem.evaluations(best.values), runs, problem.slack
        )

    # -- variables

    def _bounds(self, variables: Bounds) -> tuple[Array, Array]:
        lower: list[float] = []
        upper: list[float] = []
        if len(self._family.names) != len(self.names):
            raise InputError("a variable is one number; name each number of a list by its index")
        for name, start in zip(self.names, self.start, strict=True):
            low, high = (float(bound) for bound in variables[name])
            if not low <= start <= high or not math.isfinite(high - low):
                raise InputError(
                    f"{name}: bounds [{low:g}, {high:g}] do not contain its value {start:g}"
                )
            if low == high:
                raise InputError(f"{name}: bounds [{low:g}, {high:g}] leave no room")
            lower.append(low)
            upper.append(high)
        return frozen(lower), frozen(upper)

    def _starts(self, count: int) -> list[Array]:
        """The description's values, then a fixed set of others within the bounds."""
        from scipy.stats import qmc  # noqa: PLC0415  slow to import

        starts = [np.array(self.start)]
        room = self.upper - self.lower
        sequence = qmc.Halton(len(self.names), seed=0)
        for _ in range(count - 1):
            (point,) = sequence.random(1)
            starts.append(self.lower + room * point)
        return starts


class _Problem:
    """The problem as SciPy takes it: variables from 0 to 1, scaled functions."""

    slack = 1e-6  # of scaled constraints

    def __init__(
        self,
        design: Design,
        objective: Function,
        at_least: Mapping[str, Function],
        equal: Mapping[str, Function],
    ) -> None:
        self._design = design
        self._room = design.upper - design.lower
        self._functions: dict[str, tuple[str, Function]] = {"objective": ("objective", objective)}
        for name, function in at_least.items():
            self._functions[name] = ("ineq", function)
        for name, function in equal.items():
            self._functions[name] = ("eq", function)
        self._memory: dict[bytes, dict[str, Evaluation]] = {}
        first = self._evaluated(np.array(design.start))
        self._scales: dict[str, float] = {}
        for name, evaluation in first.items():
            self._scales[name] = float(np.abs(evaluation.value).max(initial=0.0)) or 1.0
        self._first = float(first["objective"].value[0])

    def solve(self, start: Array, method: Method) -> Any:
        """One run from a start."""
        from scipy.optimize import minimize  # noqa: PLC0415  slow to import

        scaled = (start - self._design.lower) / self._room
        constraints = [self._constraint(name) for name in self._functions if name != "objective"]
        options: dict[str, float] = {"maxiter": 300}
        if method == "SLSQP":
            options["ftol"] = 1e-12
        ended = minimize(
            lambda x: self._value("objective", x)[0],
            scaled,
            jac=lambda x: self._slope("objective", x)[0],
            bounds=[(0.0, 1.0)] * len(start),
            constraints=constraints,
            method=method,
            options=options,
        )
        values = self._unscaled(np.clip(ended.x, 0.0, 1.0))
        return _Run(values, self._evaluated(values), self._scales, str(ended.message))

    def evaluations(self, values: Array) -> dict[str, Evaluation]:
        """All functions at values of the variables, with bounds as constraints."""
        evaluations = dict(self._evaluated(values))
        units = np.eye(len(values))
        for name, evaluation in evaluations.items():
            evaluations[name] = replace(evaluation, scale=self._scales[name])
        for k, name in enumerate(self._design.names):
            low = self._design.lower[k]
            high = self._design.upper[k]
            unit = units[k : k + 1]
            scale = float(self._room[k])
            above_low = values[k : k + 1] - low
            below_high = high - values[k : k + 1]
            evaluations[f"{name} at least {low:g}"] = Evaluation("ineq", above_low, unit, scale)
            evaluations[f"{name} at most {high:g}"] = Evaluation("ineq", below_high, -unit, scale)
        return evaluations

    def _constraint(self, name: str) -> dict[str, Any]:
        kind, _ = self._functions[name]
        return {
            "type": kind,
            "fun": lambda x: self._value(name, x),
            "jac": lambda x: self._slope(name, x),
        }

    def _value(self, name: str, x: Array) -> Array:
        evaluation = self._evaluated(self._unscaled(x))[name]
        value = evaluation.value / self._scales[name]
        if name == "objective":
            return np.where(np.isfinite(value), value, _OPEN)
        return np.where(np.isfinite(value), value, -1.0)

    def _slope(self, name: str, x: Array) -> Array:
        evaluation = self._evaluated(self._unscaled(x))[name]
        slope = evaluation.slope * self._room / self._scales[name]
        return np.where(np.isfinite(slope), slope, 0.0)

    def _unscaled(self, x: Array) -> Array:
        return np.asarray(self._design.lower + x * self._room)

    def _evaluated(self, values: Array) -> dict[str, Evaluation]:
        key = values.tobytes()
        if key not in self._memory:
            self._memory.clear()
            cycle = self._design.cycle(values)
            evaluations: dict[str, Evaluation] = {}
            for name, (kind, function) in self._functions.items():
                evaluations[name] = _evaluation(name, kind, function(cycle), len(values))
            self._memory[key] = evaluations
        return self._memory[key]


class _Run:
    """The end of one run."""

    def __init__(
        self,
        values: Array,
        evaluations: Mapping[str, Evaluation],
        scales: Mapping[str, float],
        message: str,
    ) -> None:
        self.values = values
        self.message = message
        value = float(evaluations["objective"].value[0])
        self.objective = value if math.isfinite(value) else math.inf
        self.violation = 0.0
        for name, evaluation in evaluations.items():
            excess = evaluation.violation / scales[name]
            self.violation = max(self.violation, excess if math.isfinite(excess) else math.inf)


def _evaluation(name: str, kind: str, quantity: Any, count: int) -> Evaluation:
    if not isinstance(quantity, Quantity):
        raise InputError(f"{name} gives {quantity!r}; expected a Quantity computed from the cycle")
    value = quantity.value.reshape(-1)
    if kind == "objective" and value.size != 1:
        raise InputError(
            f"the objective has {value.size} entries; expected one: a sum or a maximum"
        )
    return Evaluation(kind, value, quantity.slope.reshape(-1, count))
