"""Matrices of the equations of motion: C-bar, R', and the terms of the full DAE of the tree."""

from __future__ import annotations

from ..algebra.linear import transposed, unit_vectors
from ..algebra.scalar import Scalar, Scalars
from ..algebra.vector import add, scale, sub
from ..closure.closed_motion import ClosedMotion
from ..dynamics.bilinear import tree_forces
from ..dynamics.load_pattern import NOTHING, LoadPattern
from ..kernels.trace import Results
from .dynamics import Dynamics, columns_of
from .model import AT_ACCELERATION, AT_STATE, Inputs, Model, Program, with_loads

Matrix = list[list[Scalar]]


def velocity_map_rate(motion: ClosedMotion, ds: Scalars) -> Matrix:
    """The columns of R'.

    The bias q(s') = R' u' is a quadratic form of s', and R' x is its bilinear form of s' and R x.
    Polarisation gives it: q(a, b) = (q(a + b) - q(a - b)) / 4.
    """
    still: list[Scalar] = [0.0] * len(motion.given)
    rates: Matrix = []
    for column in columns_of(motion):
        plus = motion.accelerations(still, add(ds, column))
        minus = motion.accelerations(still, sub(ds, column))
        rates.append(list(scale(0.25, sub(plus, minus))))
    return rates


def coriolis_matrix(pattern: LoadPattern = NOTHING) -> Program:
    """Program for C-bar = R^T (M R' + C R), Chu (2020), below Eq. 17, and R'.

    C holds the Christoffel symbols of M, hence C-bar those of M-bar: M-bar' - 2 C-bar is
    skew-symmetric.
    """

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        rates = velocity_map_rate(dynamics.motion, dynamics.ds)
        columns: Matrix = []
        for column, rate in zip(columns_of(dynamics.motion), rates, strict=True):
            forces = tree_forces(dynamics.tree, dynamics.ds, column, rate)
            forces = dynamics.loaded.with_rotors(forces, rate, dynamics.ds, column)
            columns.append(dynamics.project(forces))
        outputs = {"C": transposed(columns), "dR": transposed(rates)}
        return Results(outputs, dynamics.checks)

    return with_loads(AT_STATE, run, pattern)


def spanning_terms(pattern: LoadPattern = NOTHING) -> Program:
    """Program for the terms of the spanning tree with its loops as constraints.

    M s'' + C s' + g + e + J_s^T lambda = [tau; 0],  J_s s'' + J_s' s' = 0: the DAE of
    Chu (2020), Eq. 10, with J_s of Eq. 16. e: friction, springs and wrenches.
    """

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        motion = dynamics.motion
        jacobian = constraint_jacobian(motion)
        drift = dynamics.drift()
        dds = motion.accelerations(x.ddu, dynamics.ds)
        forces = dynamics.loaded.forces(dynamics.gravity, dynamics.ds, dds)
        still: list[Scalar] = [0.0] * motion.size
        outputs = {
            "M": _mass_matrix(dynamics),
            "C": _coriolis_matrix(dynamics),
            "g": dynamics.tree.inverse_dynamics(dynamics.gravity, still, still),
            "e": dynamics.loaded.passive_forces(dynamics.ds),
            "J": jacobian,
            "bias": [_minus_dot(row, drift) for row in jacobian],
            "multipliers": _multipliers(motion, forces),
        }
        return Results(outputs, dynamics.checks)

    return with_loads(AT_ACCELERATION, run, pattern)


def constraint_jacobian(motion: ClosedMotion) -> Matrix:
    """J_s of the equations that are solved, (n_z, n_s)."""
    jacobian: Matrix = []
    for block in motion.blocks:
        jacobian += block.square_rows(motion.size)
    return jacobian


def _mass_matrix(dynamics: Dynamics) -> Matrix:
    """M of the open tree (n_s, n_s), rotors included."""
    still: list[Scalar] = [0.0] * dynamics.motion.size
    columns: Matrix = []
    for unit in unit_vectors(dynamics.motion.size):
        forces = tree_forces(dynamics.tree, still, still, unit)
        columns.append(dynamics.loaded.with_rotors(forces, unit, still, still))
    return transposed(columns)


def _coriolis_matrix(dynamics: Dynamics) -> Matrix:
    """C of the open tree (n_s, n_s)."""
    still: list[Scalar] = [0.0] * dynamics.motion.size
    columns: Matrix = []
    for unit in unit_vectors(dynamics.motion.size):
        forces = tree_forces(dynamics.tree, dynamics.ds, unit, still)
        columns.append(dynamics.loaded.with_rotors(forces, still, dynamics.ds, unit))
    return transposed(columns)


def _multipliers(motion: ClosedMotion, forces: list[Scalar]) -> list[Scalar]:
    """lambda of all rows of J_s (n_z,)."""
    _, by_block = motion.project(forces)
    multipliers: list[Scalar] = []
    for block, of_equations in zip(motion.blocks, by_block, strict=True):
        multipliers += [-m for m in block.square_multipliers(of_equations)]
    return multipliers


def _minus_dot(a: Scalars, b: Scalars) -> Scalar:
    total: Scalar = 0.0
    for x, y in zip(a, b, strict=True):
        total = total - x * y
    return total
