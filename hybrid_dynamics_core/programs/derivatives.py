"""Derivatives of inverse and forward dynamics: exact, from the text of the programs themselves."""

from __future__ import annotations

from collections.abc import Sequence

from ..algebra.scalar import Scalar
from ..dynamics.load_pattern import NOTHING, LoadPattern
from ..kernels.differentiate import jacobian, substitute
from ..kernels.graph import Graph, Symbol
from ..kernels.trace import Results
from .dynamics import Dynamics, solve_motion
from .model import Inputs, Model, Program

Matrix = list[list[Scalar]]


def inverse_dynamics_derivatives(pattern: LoadPattern = NOTHING) -> Program:
    """Program for tau and d tau / d(u, u', u''); the last is M-bar. On symbols only."""

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        tau = dynamics.inverse(list(x.ddu))
        d_u, d_du = _split(jacobian(tau, [*x.u, *x.du]), dynamics.n)
        return Results(
            {"tau": tau, "d_u": d_u, "d_du": d_du, "d_ddu": dynamics.mass_matrix()}, dynamics.checks
        )

    return Program(
        ("u", "du", "ddu", "branch", "guess", "gravity", *pattern.inputs), run, pattern.sizes
    )


def forward_dynamics_derivatives(pattern: LoadPattern = NOTHING) -> Program:
    """Program for u'' and d u'' / d(u, u', tau). On symbols only.

    From tau = ID(u, u', u''):  d u''/d(u, u') = -M-bar^-1 d ID/d(u, u') at the u'' found,  d u''/d
    tau = M-bar^-1.
    """

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        ddu, mass, checks = solve_motion(model, dynamics, list(x.tau))
        held = _held(x.u, dynamics.n)
        slopes = jacobian(dynamics.inverse(held), [*x.u, *x.du])
        found = substitute(
            [slope for row in slopes for slope in row], dict(zip(held, ddu, strict=True))
        )
        rows = [found[2 * dynamics.n * i : 2 * dynamics.n * (i + 1)] for i in range(dynamics.n)]
        columns = [mass.solve([-value for value in column]) for column in zip(*rows, strict=True)]
        d_u, d_du = _split([list(row) for row in zip(*columns, strict=True)], dynamics.n)
        units = [[1.0 if i == j else 0.0 for i in range(dynamics.n)] for j in range(dynamics.n)]
        outputs = {
            "ddu": ddu,
            "d_u": d_u,
            "d_du": d_du,
            "d_tau": [mass.solve(unit) for unit in units],
        }
        return Results(outputs, dynamics.checks + checks)

    return Program(
        ("u", "du", "tau", "branch", "guess", "gravity", *pattern.inputs), run, pattern.sizes
    )


def _held(u: Sequence[Scalar], count: int) -> list[Symbol]:
    """Symbols that stand for accelerations which do not change with u: inputs that no kernel has."""
    graph: Graph = next(x.graph for x in u)
    return [graph.input(-1, k) for k in range(count)]


def _split(rows: Matrix, n: int) -> tuple[Matrix, Matrix]:
    return [row[:n] for row in rows], [row[n:] for row in rows]
