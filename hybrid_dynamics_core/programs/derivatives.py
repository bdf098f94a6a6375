"""Exact derivatives of inverse and forward dynamics, by differentiation of their programs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain, islice

from ..algebra.linear import transposed, unit_vectors
from ..algebra.scalar import Scalar, Scalars
from ..dynamics.load_pattern import NOTHING, LoadPattern
from ..kernels.differentiate import along, short_jacobian, substitute
from ..kernels.graph import Graph, Operand, Symbol
from ..kernels.trace import Check, Results, flatten
from .dynamics import Dynamics
from .forward import is_regrouped, solve_motion
from .model import AT_ACCELERATION, AT_EFFORT, Inputs, Model, Program, with_loads

Matrix = list[list[Scalar]]


def inverse_dynamics_derivatives(pattern: LoadPattern = NOTHING) -> Program:
    """Program for tau and d tau / d(u, u', u''), on symbols only. The last one is M-bar."""

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern, minimal=True)
        tau = dynamics.inverse(list(x.ddu))
        d_u, d_du = _halves(short_jacobian(tau, [*x.u, *x.du]))
        outputs = {"tau": tau, "d_u": d_u, "d_du": d_du, "d_ddu": dynamics.mass_matrix()}
        return Results(outputs, dynamics.checks)

    return with_loads(AT_ACCELERATION, run, pattern)


def forward_dynamics_derivatives(pattern: LoadPattern = NOTHING) -> Program:
    """Program for u'' and d u'' / d(u, u', tau), on symbols only.

    From tau = ID(u, u', u''):  d u''/d(u, u') = -M-bar^-1 d ID/d(u, u')  at the solution u'', and
    d u''/d tau = M-bar^-1.
    """

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern, minimal=is_regrouped(model))
        ddu, mass, checks = solve_motion(model, dynamics, list(x.tau))
        held = _constants(x.u, dynamics.n)
        of_efforts = short_jacobian(dynamics.inverse(held), [*x.u, *x.du])
        at_solution = _substituted(of_efforts, dict(zip(held, ddu, strict=True)))
        columns: Matrix = []
        for column in transposed(at_solution):
            opposite = [-entry for entry in column]
            columns.append(mass.solve(opposite))
        d_u, d_du = _halves(transposed(columns))
        outputs = {
            "ddu": ddu,
            "d_u": d_u,
            "d_du": d_du,
            "d_tau": [mass.solve(unit) for unit in unit_vectors(dynamics.n)],
        }
        return Results(outputs, dynamics.checks + checks)

    return with_loads(AT_EFFORT, run, pattern)


def slopes(program: Program, results: Sequence[str], by: Sequence[str]) -> Program:
    """Program for derivatives of the flat results of another one, on symbols only.

    Args:
        program: the program.
        results: names of its results, in order.
        by: names of inputs. The derivative by `u` is called `d_u`: rows by the results.
    """

    def run(model: Model, x: Inputs) -> Results:
        outputs = program.run(model, x)
        flat = flatten([outputs.outputs[name] for name in results])
        matrices = {f"d_{name}": short_jacobian(flat, list(getattr(x, name))) for name in by}
        return Results(matrices, outputs.checks)

    return Program(program.inputs, run, program.sizes)


def directional(parts: Sequence[Program], by: Sequence[str]) -> Program:
    """Program for the derivatives of all results in one direction, on symbols only.

    Args:
        parts: programs, with results of different names.
        by: names of inputs. The change of `u` is the input `seed_u`, that of `tau` `seed_tau`.

    Returns:
        The program. The derivative of the result `ddu` is called `d_ddu`, and is flat.
    """
    inputs = dict.fromkeys(chain.from_iterable(part.inputs for part in parts))
    seeds = [f"seed_{name}" for name in by]
    sizes = dict(chain.from_iterable(part.sizes.items() for part in parts))

    def run(model: Model, x: Inputs) -> Results:
        varied = list(chain.from_iterable(getattr(x, name) for name in by))
        changes = list(chain.from_iterable(getattr(x, name) for name in seeds))
        values: dict[str, Scalars] = {}
        checks: list[Check] = []
        for part in parts:
            results = part.run(model, x)
            checks += results.checks
            values |= {name: flatten([value]) for name, value in results.outputs.items()}
        changed = iter(along(flatten([*values.values()]), varied, changes))
        outputs = {f"d_{name}": list(islice(changed, len(value))) for name, value in values.items()}
        return Results(outputs, list(dict.fromkeys(checks)))

    return Program((*inputs, *seeds), run, sizes)


def _constants(u: Scalars, count: int) -> list[Symbol]:
    """Placeholder symbols for accelerations, held constant while differentiating by u."""
    graph: Graph = next(x.graph for x in u)
    return [graph.input(-1, k) for k in range(count)]


def _substituted(rows: Matrix, values: Mapping[Operand, Scalar]) -> Matrix:
    """A matrix with symbols replaced by values."""
    size = len(rows[0])
    entries = substitute(list(chain.from_iterable(rows)), values)
    return [entries[size * i : size * (i + 1)] for i in range(len(rows))]


def _halves(rows: Matrix) -> tuple[Matrix, Matrix]:
    """The left and the right half of a matrix."""
    n = len(rows[0]) // 2
    return [row[:n] for row in rows], [row[n:] for row in rows]
