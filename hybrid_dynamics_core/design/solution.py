"""The result of a design: values, what is active, and what a little more room would give."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from types import MappingProxyType

import numpy as np

from ..ground.arrays import Array
from ..robot.robot import Robot
from .program import OBJECTIVE, SLACK, Evaluation, Program, Run

_AT_LIMIT = 1e-5  # of a scaled constraint


@dataclass(frozen=True, eq=False)
class DesignResult:
    """A solved design.

    Attributes:
        values: values of the variables in SI units, by name.
        objective: value of the objective.
        feasible: whether all constraints hold.
        active: names of the constraints and bounds that hold as equations.
        at_limit: by name of an active one, the entries that do, such as points of duty.
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
    at_limit: Mapping[str, tuple[int, ...]]
    sensitivities: Mapping[str, float]
    constraints: Mapping[str, float]
    objectives: tuple[float, ...]
    robot: Robot
    message: str


def result_of(
    robot: Robot, names: tuple[str, ...], program: Program, runs: Sequence[Run]
) -> DesignResult:
    """The result of the best of all runs.

    Args:
        robot: the robot that the design started from.
        names: names of the variables.
        program: its functions.
        runs: all runs.
    """
    best = min(runs, key=lambda run: run.order)
    evaluations = program.evaluations(names, best.values)
    values = dict(zip(names, best.values.tolist(), strict=True))
    constraints: dict[str, float] = {}
    at_limit: dict[str, tuple[int, ...]] = {}
    for name, evaluation in evaluations.items():
        if evaluation.kind == OBJECTIVE:
            continue
        constraints[name] = float(evaluation.value.min())
        entries = _at_limit(evaluation)
        if entries:
            at_limit[name] = entries
    return DesignResult(
        values=MappingProxyType(values),
        objective=best.objective,
        feasible=best.violation <= SLACK,
        active=tuple(at_limit),
        at_limit=MappingProxyType(at_limit),
        sensitivities=MappingProxyType(_multipliers(evaluations, at_limit)),
        constraints=MappingProxyType(constraints),
        objectives=tuple(run.objective for run in runs),
        robot=robot.with_parameters(values),
        message=best.message,
    )


def _at_limit(evaluation: Evaluation) -> tuple[int, ...]:
    """The entries of a constraint that hold as equations."""
    limit = _AT_LIMIT * evaluation.scale
    if evaluation.kind == "eq":
        limit = np.inf
    return tuple(np.flatnonzero(evaluation.value <= limit).tolist())


def _multipliers(
    evaluations: Mapping[str, Evaluation], at_limit: Mapping[str, tuple[int, ...]]
) -> dict[str, float]:
    """How much the objective falls per unit by which each active constraint is relaxed.

    The multipliers give the slope of the objective from those of the active entries; those of
    inequalities are not negative. Entries of one constraint are relaxed together.

    Args:
        evaluations: all functions and bounds.
        at_limit: entries that hold as equations, by name.
    """
    from scipy.optimize import nnls  # noqa: PLC0415  slow to import

    slopes: list[Array] = []
    owners: list[str] = []
    signs: list[float] = []
    for name, entries in at_limit.items():
        evaluation = evaluations[name]
        directions = (1.0, -1.0) if evaluation.kind == "eq" else (1.0,)
        for entry, sign in product(entries, directions):
            slopes.append(sign * evaluation.slope[entry])
            owners.append(name)
            signs.append(sign)
    if not slopes:
        return {}
    matrix = np.array(slopes).T
    sizes = np.linalg.norm(matrix, axis=0)
    sizes[sizes == 0.0] = 1.0
    objective = evaluations[OBJECTIVE].slope[0]
    factors, _ = nnls(matrix / sizes, objective)
    multipliers = dict.fromkeys(at_limit, 0.0)
    for name, sign, factor in zip(owners, signs, factors / sizes, strict=True):
        multipliers[name] += sign * float(factor)
    return multipliers
