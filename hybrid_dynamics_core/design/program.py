"""A design as a nonlinear program: scaled variables and functions, a bound above the largest."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..errors import InputError
from ..ground.arrays import Array
from .cycle import Cycle
from .quantity import Quantity
from .solvers import Constraint, Method, run_solver

Function = Callable[[Cycle], Quantity]
Functions = Mapping[str, Function]

OBJECTIVE = "objective"
LARGEST = "largest"  # constraint: no entry of the objective is above its bound
SLACK = 1e-6  # violation of scaled constraints that counts as none

_OPEN = 1e3  # objective in lengths of its first value, where loops do not close


@dataclass(frozen=True, eq=False)
class Evaluation:
    """A function of the variables at some values.

    Attributes:
        kind: "objective", "ineq" or "eq".
        value: its entries (m,).
        slope: their derivatives (m, k).
        scale: size of its entries.
    """

    kind: str
    value: Array
    slope: Array
    scale: float = 1.0

    @property
    def violation(self) -> float:
        """By how much the constraint does not hold."""
        if self.kind == OBJECTIVE:
            return 0.0
        apart = np.abs(self.value) if self.kind == "eq" else -self.value
        return float(max(apart.max(initial=0.0), 0.0))


@dataclass(frozen=True, eq=False)
class Run:
    """The end of one run.

    Attributes:
        values: values of the variables (k,).
        objective: value of the objective; infinite where loops are open.
        violation: largest violation of the scaled constraints.
        message: the last word of the solver.
    """

    values: Array
    objective: float
    violation: float
    message: str

    @property
    def order(self) -> tuple[bool, float]:
        """What is less for the better run."""
        return self.violation > SLACK, self.objective


@dataclass(frozen=True)
class Goals:
    """What a design is to reach.

    Attributes:
        objective: function of the cycle that is to be least.
        at_least: functions whose entries are zero or above, by name.
        equal: functions whose entries are zero, by name.
        of_largest: whether the largest entry of the objective is to be least.
    """

    objective: Function
    at_least: Functions
    equal: Functions
    of_largest: bool = False

    def functions(self) -> dict[str, tuple[str, Function]]:
        """Kind and function by name."""
        functions: dict[str, tuple[str, Function]] = {OBJECTIVE: (OBJECTIVE, self.objective)}
        for name, function in self.at_least.items():
            functions[name] = ("ineq", function)
        for name, function in self.equal.items():
            functions[name] = ("eq", function)
        return functions


class Program:
    """The program of a design: variables from 0 to 1, scaled functions.

    For the largest entry of the objective, one more variable is the bound that no entry exceeds, in
    sizes of the objective.
    """

    def __init__(
        self,
        cycle: Callable[[Array], Cycle],
        bounds: tuple[Array, Array],
        start: Array,
        goals: Goals,
    ) -> None:
        """Evaluate all functions once at the start, for their sizes.

        Args:
            cycle: the duty cycle at values (k,) of the variables.
            bounds: lower and upper bounds (k,).
            start: values to start from (k,).
            goals: what is to be reached.
        """
        self._cycle = cycle
        self.lower, self.upper = bounds
        self._room = self.upper - self.lower
        self._of_largest = goals.of_largest
        self._functions = goals.functions()
        self._memory: dict[bytes, dict[str, Evaluation]] = {}
        self._scales: dict[str, float] = {}
        for name, evaluation in self._evaluated(np.array(start)).items():
            size = np.abs(evaluation.value).max(initial=0.0)
            self._scales[name] = float(size) or 1.0

    # -- a run

    def solve(self, start: Array, method: Method) -> Run:
        """One run from a start (k,)."""
        scaled = (start - self.lower) / self._room
        limits = [(0.0, 1.0)] * len(start)
        constraints: list[Constraint] = []
        for name, (kind, _) in self._functions.items():
            if name != OBJECTIVE:
                constraints.append(self._constraint(name, kind))
        if self._of_largest:
            values = self._scaled_value(OBJECTIVE, scaled)
            scaled = np.append(scaled, values.max())
            limits.append((-np.inf, np.inf))
            constraints.append(Constraint("ineq", self._room_below, self._slope_below))
        ended = run_solver(
            method, self._objective, self._objective_slope, scaled, limits, constraints
        )
        inside = np.clip(ended.x[: len(start)], 0.0, 1.0)
        return self._run(self._unscaled(inside), ended.message)

    def _run(self, values: Array, message: str) -> Run:
        evaluations = self._evaluated(values)
        objective = float(evaluations[OBJECTIVE].value.max())
        if not math.isfinite(objective):
            objective = math.inf
        violation = 0.0
        for name, evaluation in evaluations.items():
            excess = evaluation.violation / self._scales[name]
            if not math.isfinite(excess):
                excess = math.inf
            violation = max(violation, excess)
        return Run(values, objective, violation, message)

    # -- functions of scaled variables

    def _objective(self, x: Array) -> float:
        if self._of_largest:
            return float(x[-1])
        return float(self._scaled_value(OBJECTIVE, x)[0])

    def _objective_slope(self, x: Array) -> Array:
        if not self._of_largest:
            (slope,) = self._scaled_slope(OBJECTIVE, x)
            return np.asarray(slope)
        slope = np.zeros(len(x))
        slope[-1] = 1.0
        return slope

    def _room_below(self, x: Array) -> Array:
        """How far the entries of the objective are below the bound (m,)."""
        return np.asarray(x[-1] - self._scaled_value(OBJECTIVE, x))

    def _slope_below(self, x: Array) -> Array:
        slope = -self._scaled_slope(OBJECTIVE, x)
        slope[:, -1] = 1.0
        return slope

    def _constraint(self, name: str, kind: str) -> Constraint:
        return Constraint(
            kind,
            lambda x: self._scaled_value(name, x),
            lambda x: self._scaled_slope(name, x),
        )

    def _scaled_value(self, name: str, x: Array) -> Array:
        evaluation = self._evaluated(self._unscaled(x))[name]
        value = evaluation.value / self._scales[name]
        otherwise = _OPEN if name == OBJECTIVE else -1.0
        return np.where(np.isfinite(value), value, otherwise)

    def _scaled_slope(self, name: str, x: Array) -> Array:
        """Slope (m, k), with a column of zeros for the bound."""
        evaluation = self._evaluated(self._unscaled(x))[name]
        factor = self._room / self._scales[name]
        slope = np.zeros((len(evaluation.value), len(x)))
        slope[:, : len(factor)] = evaluation.slope * factor
        return np.where(np.isfinite(slope), slope, 0.0)

    def _unscaled(self, x: Array) -> Array:
        share = x[: len(self._room)]
        return np.asarray(self.lower + share * self._room)

    # -- evaluations

    def evaluations(self, names: tuple[str, ...], values: Array) -> dict[str, Evaluation]:
        """All functions at values (k,) of the variables, with their bounds as constraints.

        With `of_largest`, slopes have one more column, for the bound, and `largest` is a
        constraint.
        """
        evaluations: dict[str, Evaluation] = {}
        for name, evaluation in self._evaluated(values).items():
            evaluations[name] = replace(evaluation, scale=self._scales[name])
        units = np.eye(len(values))
        for k, name in enumerate(names):
            low = self.lower[k]
            high = self.upper[k]
            unit = units[k : k + 1]
            scale = float(self._room[k])
            above = values[k : k + 1] - low
            below = high - values[k : k + 1]
            evaluations[f"{name} at least {low:g}"] = Evaluation("ineq", above, unit, scale)
            evaluations[f"{name} at most {high:g}"] = Evaluation("ineq", below, -unit, scale)
        if self._of_largest:
            return _with_bound(evaluations)
        return evaluations

    def _evaluated(self, values: Array) -> dict[str, Evaluation]:
        key = values.tobytes()
        if key not in self._memory:
            self._memory.clear()
            cycle = self._cycle(values)
            evaluations: dict[str, Evaluation] = {}
            for name, (kind, function) in self._functions.items():
                evaluations[name] = self._evaluation(name, kind, function(cycle), len(values))
            self._memory[key] = evaluations
        return self._memory[key]

    def _evaluation(self, name: str, kind: str, quantity: Any, count: int) -> Evaluation:
        if not isinstance(quantity, Quantity):
            raise InputError(
                f"{name} gives {quantity!r}; expected a Quantity computed from the cycle"
            )
        value = quantity.value.reshape(-1)
        if kind == OBJECTIVE and value.size != 1 and not self._of_largest:
            raise InputError(
                f"the objective has {value.size} entries; expected one: a sum or a maximum, or"
                " minimise_largest"
            )
        return Evaluation(kind, value, quantity.slope.reshape(-1, count))


def _with_bound(evaluations: Mapping[str, Evaluation]) -> dict[str, Evaluation]:
    """The evaluations with the bound as one more variable, at the largest entry."""
    widened: dict[str, Evaluation] = {}
    for name, evaluation in evaluations.items():
        zeros = np.zeros((len(evaluation.value), 1))
        slope = np.hstack([evaluation.slope, zeros])
        widened[name] = replace(evaluation, slope=slope)
    entries = widened[OBJECTIVE]
    bound = entries.value.max(keepdims=True)
    unit = np.zeros((1, entries.slope.shape[1]))
    unit[0, -1] = 1.0
    below = unit - entries.slope
    widened[LARGEST] = Evaluation("ineq", bound - entries.value, below, entries.scale)
    widened[OBJECTIVE] = Evaluation(OBJECTIVE, bound, unit, entries.scale)
    return widened
