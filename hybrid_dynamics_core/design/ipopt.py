"""Ipopt through CasADi, with exact gradients from Python and an approximate Hessian.

The module is loaded where the method is asked for: CasADi is an extra.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from ..ground.arrays import Array

_TOLERANCE = 1e-8


class Called(NamedTuple):
    """Functions of variables: the objective, then the constraints.

    Attributes:
        values: gives the entries (m,).
        slopes: gives their derivatives (m, k).
        variables: k.
        entries: m.
    """

    values: Callable[[Array], Array]
    slopes: Callable[[Array], Array]
    variables: int
    entries: int


def solve(
    called: Called,
    start: Array,
    limits: Sequence[tuple[float, float]],
    upper: Sequence[float],
    iterations: int,
) -> tuple[Array, str]:
    """Minimise the first entry.

    Args:
        called: the functions; entries after the first are zero or above.
        start: variables to start from (k,).
        limits: least and greatest value of each variable.
        upper: greatest value of each entry after the first (m - 1,).
        iterations: most iterations.

    Returns:
        Variables (k,), and the last word of the solver.
    """
    values = _Values(called)
    x = ca.MX.sym("x", called.variables)
    entries = values(x)
    problem = {"x": x, "f": entries[0], "g": entries[1:]}
    options = {
        "print_time": False,
        "ipopt.print_level": 0,
        "ipopt.sb": "yes",
        "ipopt.hessian_approximation": "limited-memory",
        "ipopt.max_iter": iterations,
        "ipopt.tol": _TOLERANCE,
    }
    solver = ca.nlpsol("design", "ipopt", problem, options)
    low, high = np.transpose(limits)
    lower = np.zeros(len(upper))
    ended = solver(x0=start, lbx=low, ubx=high, lbg=lower, ubg=upper)
    message = solver.stats()["return_status"]
    return np.asarray(ended["x"]).reshape(-1), str(message)


class _Slopes(ca.Callback):  # type: ignore[misc]
    """The derivatives, as a function of the variables and of the entries, which it ignores."""

    def __init__(self, called: Called) -> None:
        ca.Callback.__init__(self)
        self._called = called
        self.construct("slopes", {})

    def get_n_in(self) -> int:
        """Number of arguments."""
        return 2

    def get_sparsity_in(self, place: int) -> Any:
        """Shape of an argument."""
        rows = self._called.entries if place else self._called.variables
        return ca.Sparsity.dense(rows, 1)

    def get_sparsity_out(self, place: int) -> Any:  # noqa: ARG002
        """Shape of the result."""
        return ca.Sparsity.dense(self._called.entries, self._called.variables)

    def eval(self, arguments: Any) -> list[Any]:
        """The derivatives."""
        x = np.asarray(arguments[0]).reshape(-1)
        return [ca.DM(self._called.slopes(x))]


class _Values(ca.Callback):  # type: ignore[misc]
    """The entries, as a function of the variables."""

    def __init__(self, called: Called) -> None:
        ca.Callback.__init__(self)
        self._called = called
        self._slopes = _Slopes(called)  # held here: CasADi does not
        self.construct("values", {})

    def get_sparsity_in(self, place: int) -> Any:  # noqa: ARG002
        """Shape of the argument."""
        return ca.Sparsity.dense(self._called.variables, 1)

    def get_sparsity_out(self, place: int) -> Any:  # noqa: ARG002
        """Shape of the result."""
        return ca.Sparsity.dense(self._called.entries, 1)

    def eval(self, arguments: Any) -> list[Any]:
        """The entries."""
        x = np.asarray(arguments[0]).reshape(-1)
        return [ca.DM(self._called.values(x))]

    def has_jacobian(self) -> bool:
        """Whether there are derivatives."""
        return True

    def get_jacobian(self, *names: Any) -> Any:  # noqa: ARG002
        """The derivatives."""
        return self._slopes
