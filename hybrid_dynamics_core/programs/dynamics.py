"""Dynamics in minimal form, by projection of the spanning tree's forces with R."""

from __future__ import annotations

from ..algebra.scalar import Scalar
from ..algebra.vector import Vector
from ..dynamics.spanning import TreeKinematics
from ..kernels.trace import Results
from .closure import closed_motion
from .model import Inputs, Model, Program


def _inverse_dynamics(model: Model, x: Inputs) -> Results:
    """tau = R^T (M s'' + C s' + g), Chu (2020), Eq. 22 to 25."""
    motion, checks, _ = closed_motion(model, x)
    ds = motion.rates(x.du)
    tree = TreeKinematics(model.tree, motion.posture)
    forces = tree.inverse_dynamics(tuple(x.gravity), ds, motion.accelerations(x.ddu, ds))
    return Results({"tau": motion.project(forces)[0]}, checks)


def _minimal_form(model: Model, x: Inputs) -> Results:
    """M-bar, C-bar u' and G-bar of  M-bar u'' + C-bar u' + G-bar = tau, Chu (2020), Eq. 25."""
    motion, checks, _ = closed_motion(model, x)
    tree = TreeKinematics(model.tree, motion.posture)
    still: list[Scalar] = [0.0] * motion.size
    ds = motion.rates(x.du)
    no_gravity: Vector = (0.0, 0.0, 0.0)
    n = len(x.u)

    def tau(g: Vector, rates: list[Scalar], dds: list[Scalar]) -> list[Scalar]:
        return motion.project(tree.inverse_dynamics(g, rates, dds))[0]

    columns = [tau(no_gravity, still, list(column)) for column in zip(*motion.velocity_map(), strict=True)]
    mass = [[columns[min(i, j)][max(i, j)] for j in range(n)] for i in range(n)]
    bias = tau(no_gravity, ds, motion.accelerations([0.0] * n, ds))
    return Results({"M": mass, "h": bias, "g": tau(tuple(x.gravity), still, still)}, checks)


INVERSE_DYNAMICS = Program(("u", "du", "ddu", "branch", "guess", "gravity"), _inverse_dynamics)
MINIMAL_FORM = Program(("u", "du", "branch", "guess", "gravity"), _minimal_form)
