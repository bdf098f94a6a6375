"""The result of a design: values, what is active, and what a little more room would give."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from ..ground.arrays import Array
from ..robot.robot import Robot

_AT_LIMIT = 1e-5  # of a scaled constraint


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
        if self.kind == "objective":
            return 0.0
        apart = np.abs(self.value) if self.kind == "eq" else -self.value
        return float(max(apart.max(initial=0.0), 0.0))


@dataclass(frozen=True, eq=False)
class DesignResult:
    """A solved design.

    Attributes:
        values: values of the variables in SI units, by name.
        objective: value of the objective.
        feasible: whether all constraints hold.
        active: names of the constraints and bounds that hold as equations.
        sensitivities: by name of an active one, how much the objective falls per unit by which it
            is relaxed.
        constraints: least value of each constraint, by name.
        objectives: objective at the end of each start; infinite where loops are open.
        robot: the robot with these values.
        message: the last word of the solver.
    """

    values: Mapping[str, float]
    objective: float
    feasible: bool
    active: tuple[str, ...]
    sensitivities: Mapping[str, float]
    constraints: Mapping[str, float]
    objectives: tuple[float, ...]
    robot: Robot
    message: str


def result_of(
    robot: Robot,
    names: Sequence[str],
    evaluations: Mapping[str, Evaluation],
    runs: Sequence[Any],
    slack: float,
) -> DesignResult:
    """The result of the best of all runs.

    Args:
        robot: the robot that the design started from.
        names: names of the variables.
        evaluations: all functions and bounds at the best values.
        runs: all runs.
        slack: violation of scaled constraints that counts as none.
    """
    best = min(runs, key=lambda run: (run.violation > slack, run.objective))
    values = dict(zip(names, best.values.tolist(), strict=True))
    constraints: dict[str, float] = {}
    slopes: dict[str, Array] = {}
    for name, evaluation in evaluations.items():
        if evaluation.kind == "objective":
            continue
        place = int(np.argmin(evaluation.value))
        constraints[name] = float(evaluation.value[place])
        limit = _AT_LIMIT * evaluation.scale
        if evaluation.kind == "eq" or evaluation.value[place] <= limit:
            slopes[name] = evaluation.slope[place]
    objective = evaluations["objective"].slope[0]
    equal = [k for k, name in enumerate(slopes) if evaluations[name].kind == "eq"]
    return DesignResult(
        values=MappingProxyType(values),
        objective=best.objective,
        feasible=best.violation <= slack,
        active=tuple(slopes),
        sensitivities=MappingProxyType(_multipliers(objective, slopes, equal)),
        constraints=MappingProxyType(constraints),
        objectives=tuple(run.objective for run in runs),
        robot=robot.with_parameters(values),
        message=best.message,
    )


def _multipliers(
    objective: Array, slopes: Mapping[str, Array], equal: list[int]
) -> dict[str, float]:
    """The multipliers with which the slopes of active constraints give that of the objective.

    Those of inequalities are not negative.

    Args:
        objective: slope of the objective (k,).
        slopes: slopes of the active constraints by name, (k,) each.
        equal: places of the equalities among them.
    """
    from scipy.optimize import nnls  # noqa: PLC0415  slow to import

    if not slopes:
        return {}
    matrix = np.array(list(slopes.values())).T
    sizes = np.linalg.norm(matrix, axis=0)
    sizes[sizes == 0.0] = 1.0
    both = np.hstack([matrix / sizes, -matrix[:, equal] / sizes[equal]])
    factors, _ = nnls(both, objective)
    signed = factors[: len(slopes)]
    signed[equal] -= factors[len(slopes) :]
    return dict(zip(slopes, (signed / sizes).tolist(), strict=True))
