"""Centre of mass and momentum matrix of the closed mechanism."""

from __future__ import annotations

from ..algebra.linear import transposed
from ..algebra.scalar import Scalar
from ..algebra.vector import ZERO3, Vector, add, cross, matvec, scale, sub
from ..dynamics.bilinear import body_twists, momentum
from ..dynamics.load_pattern import NOTHING, LoadPattern
from ..dynamics.spanning import TreeDynamics
from ..kernels.trace import Results
from .dynamics import Dynamics, columns_of
from .model import AT_STATE, Inputs, Model, Program, with_loads


def centroidal(pattern: LoadPattern = NOTHING) -> Program:
    """Program for mass, centre of mass, and the momentum about it per unit rate of u."""

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        tree = dynamics.tree
        mass, com = _centre_of_mass(tree)
        columns = [_momentum(tree, rates, com) for rates in columns_of(dynamics.motion)]
        momentum_now = _momentum(tree, dynamics.ds, com)
        outputs = {"mass": mass, "com": com, "A": transposed(columns), "momentum": momentum_now}
        return Results(outputs, dynamics.checks)

    return with_loads(AT_STATE, run, pattern)


def _centre_of_mass(tree: TreeDynamics) -> tuple[Scalar, Vector]:
    mass: Scalar = 0.0
    moment: Vector = ZERO3
    for body, (rotation, origin) in zip(tree.tree.bodies, tree.poses(), strict=True):
        mass = mass + body.mass
        moment = add(moment, add(scale(body.mass, origin), matvec(rotation, body.first_moment)))
    return mass, scale(1.0 / mass, moment)


def _momentum(tree: TreeDynamics, rates: list[Scalar], com: Vector) -> list[Scalar]:
    """Linear momentum and angular momentum about the centre of mass (6,), base axes."""
    linear: Vector = ZERO3
    angular: Vector = ZERO3
    poses = tree.poses()
    for body, twist, (rotation, origin) in zip(
        tree.tree.bodies, body_twists(tree, rates), poses, strict=True
    ):
        linear_of_body, about_origin = momentum(body, twist)
        of_body = matvec(rotation, linear_of_body)
        linear = add(linear, of_body)
        angular = add(angular, matvec(rotation, about_origin))
        angular = add(angular, cross(sub(origin, com), of_body))
    return [*linear, *angular]
