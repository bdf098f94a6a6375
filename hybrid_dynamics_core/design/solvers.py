"""Solvers of nonlinear programs behind one call: SciPy's, and Ipopt through CasADi."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from ..errors import InputError
from ..ground.arrays import Array

Method = Literal["SLSQP", "trust-constr", "ipopt"]
METHODS: tuple[Method, ...] = ("SLSQP", "trust-constr", "ipopt")

_MOST = 300  # iterations
_EXACT = 1e-12  # change of the objective at which SLSQP ends


@dataclass(frozen=True)
class Constraint:
    """Functions of the variables that are zero or above ("ineq"), or zero ("eq").

    Attributes:
        kind: "ineq" or "eq".
        value: gives the entries (m,).
        slope: gives their derivatives (m, k).
    """

    kind: str
    value: Callable[[Array], Array]
    slope: Callable[[Array], Array]


class Ended(NamedTuple):
    """Where a solver ended.

    Attributes:
        x: variables (k,).
        message: its last word.
    """

    x: Array
    message: str


def run_solver(
    method: Method,
    objective: Callable[[Array], float],
    slope: Callable[[Array], Array],
    start: Array,
    limits: Sequence[tuple[float, float]],
    constraints: Sequence[Constraint],
) -> Ended:
    """Minimise an objective.

    Args:
        method: the solver.
        objective: function of the variables (k,).
        slope: gives its derivatives (k,).
        start: variables to start from (k,).
        limits: least and greatest value of each variable.
        constraints: further constraints.

    Raises:
        InputError: the solver is not installed.
    """
    if method == "ipopt":
        return _by_ipopt(objective, slope, start, limits, constraints)
    from scipy.optimize import minimize  # noqa: PLC0415  slow to import

    entries = [{"type": one.kind, "fun": one.value, "jac": one.slope} for one in constraints]
    options: dict[str, float] = {"maxiter": _MOST}
    if method == "SLSQP":
        options["ftol"] = _EXACT
    ended = minimize(
        objective,
        start,
        jac=slope,
        bounds=limits,
        constraints=entries,
        method=method,
        options=options,
    )
    return Ended(np.asarray(ended.x), str(ended.message))


def _by_ipopt(
    objective: Callable[[Array], float],
    slope: Callable[[Array], Array],
    start: Array,
    limits: Sequence[tuple[float, float]],
    constraints: Sequence[Constraint],
) -> Ended:
    """The same by Ipopt, which comes with CasADi."""
    try:
        from .ipopt import Called, solve  # noqa: PLC0415  an extra
    except ModuleNotFoundError as error:
        raise InputError(
            "the method ipopt needs CasADi: pip install 'hybrid_dynamics[casadi]'"
        ) from error

    def values(x: Array) -> Array:
        parts = [one.value(x) for one in constraints]
        return np.concatenate([[objective(x)], *parts])

    def slopes(x: Array) -> Array:
        parts = [one.slope(x) for one in constraints]
        return np.vstack([slope(x), *parts])

    upper: list[float] = []
    for one in constraints:
        most = np.inf
        if one.kind == "eq":
            most = 0.0
        count = len(one.value(start))
        upper += [most] * count
    called = Called(values, slopes, len(start), len(upper) + 1)
    x, message = solve(called, start, limits, upper, _MOST)
    return Ended(x, message)
