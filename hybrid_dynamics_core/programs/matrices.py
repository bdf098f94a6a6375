"""Matrices of the equations of motion: C-bar, R', and the terms of the full DAE of the spanning tree."""

from __future__ import annotations

from collections.abc import Sequence

from ..algebra.scalar import Scalar
from ..closure.closed_motion import ClosedMotion
from ..dynamics.bilinear import tree_forces
from ..dynamics.load_pattern import NOTHING, LoadPattern
from ..kernels.trace import Results
from .dynamics import Dynamics, columns_of
from .model import Inputs, Model, Program

Matrix = list[list[Scalar]]


def velocity_map_rate(motion: ClosedMotion, ds: Sequence[Scalar]) -> Matrix:
    """The columns of R'.

    R' x is the bias acceleration of two motions, s' and R x: symmetric and bilinear in them, since
    J_s is itself a derivative. It follows from the bias q(s') = R' u' of one motion: q(a, b) = (q(a
    + b) - q(a - b)) / 4.
    """
    none: list[Scalar] = [0.0] * len(motion.given)
    rates = []
    for column in columns_of(motion):
        plus = motion.accelerations(none, [a + b for a, b in zip(ds, column, strict=True)])
        minus = motion.accelerations(none, [a - b for a, b in zip(ds, column, strict=True)])
        rates.append([0.25 * (a - b) for a, b in zip(plus, minus, strict=True)])
    return rates


def coriolis_matrix(pattern: LoadPattern = NOTHING) -> Program:
    """Program for C-bar = R^T (M R' + C R) and R', Chu (2020), Eq. 24; M-bar' - 2 C-bar is skew-symmetric.

    C holds the Christoffel symbols of M, hence C-bar those of M-bar.
    """

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        rates = velocity_map_rate(dynamics.motion, dynamics.ds)
        columns = []
        for column, rate in zip(columns_of(dynamics.motion), rates, strict=True):
            forces = tree_forces(dynamics.tree, dynamics.ds, column, rate)
            columns.append(dynamics.project(dynamics.laden.with_rotors(forces, rate)))
        return Results({"C": _rows(columns), "dR": _rows(rates)}, dynamics.checks)

    return Program(("u", "du", "branch", "guess", *pattern.inputs), run, pattern.sizes)


def spanning_terms(pattern: LoadPattern = NOTHING) -> Program:
    """Program for the terms of  M s'' + C s' + g + e + J_s^T lambda = [tau; 0],  J_s s'' + J_s' s' = 0.

    Chu (2020), Eq. 10 and 18; e: friction, springs and wrenches.
    """

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        motion, tree, ds = dynamics.motion, dynamics.tree, dynamics.ds
        units = [[1.0 if i == j else 0.0 for i in range(motion.size)] for j in range(motion.size)]
        still: list[Scalar] = [0.0] * motion.size
        jacobian = [
            [row.get(k, 0.0) for k in range(motion.size)]
            for block in motion.blocks
            for row in block.rows
        ]
        drift = motion.accelerations([0.0] * dynamics.n, ds)
        dds = motion.accelerations(x.ddu, ds)
        multipliers = motion.project(dynamics.laden.forces(dynamics.gravity, ds, dds))[1]
        outputs = {
            "M": _rows(
                [dynamics.laden.with_rotors(tree_forces(tree, still, still, e), e) for e in units]
            ),
            "C": _rows([tree_forces(tree, ds, e, still) for e in units]),
            "g": tree.inverse_dynamics(dynamics.gravity, still, still),
            "e": dynamics.laden.passive_forces(ds),
            "J": jacobian,
            "bias": [_minus_dot(row, drift) for row in jacobian],
            "multipliers": [-m for step in multipliers for m in step],
        }
        return Results(outputs, dynamics.checks)

    return Program(
        ("u", "du", "ddu", "branch", "guess", "gravity", *pattern.inputs), run, pattern.sizes
    )


def _rows(columns: Matrix) -> Matrix:
    return [list(row) for row in zip(*columns, strict=True)]


def _minus_dot(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    total: Scalar = 0.0
    for x, y in zip(a, b, strict=True):
        total = total - x * y
    return total
