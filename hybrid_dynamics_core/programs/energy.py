"""Energy, and the power that changes it: what a simulation is watched with."""

from __future__ import annotations

from ..algebra.scalar import Scalar
from ..algebra.vector import Vector, add, dot, matvec, scale
from ..dynamics.bilinear import body_twists, momentum
from ..dynamics.load_pattern import NOTHING, LoadPattern
from ..kernels.trace import Results
from .dynamics import Dynamics, solve_motion
from .model import Inputs, Model, Program


def energy(pattern: LoadPattern = NOTHING) -> Program:
    """Program for kinetic energy, potential energy of gravity (zero at the base origin) and energy of the springs."""

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        outputs = {
            "kinetic": kinetic_energy(dynamics),
            "potential": gravity_energy(dynamics),
            "springs": dynamics.laden.spring_energy(),
        }
        return Results(outputs, dynamics.checks)

    return Program(("u", "du", "branch", "guess", "gravity", *pattern.inputs), run, pattern.sizes)


def motion(pattern: LoadPattern = NOTHING) -> Program:
    """Program for u'' from tau, and for the power in: of actuators and applied wrenches, less that of friction."""

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        ddu, _, checks = solve_motion(model, dynamics, list(x.tau))
        power: Scalar = 0.0
        for effort, rate in zip(x.tau, x.du, strict=True):
            power = power + effort * rate
        for force, rate in zip(
            dynamics.laden.dissipative_forces(dynamics.ds), dynamics.ds, strict=True
        ):
            power = power - force * rate
        return Results({"ddu": ddu, "power": power}, dynamics.checks + checks)

    return Program(
        ("u", "du", "tau", "branch", "guess", "gravity", *pattern.inputs), run, pattern.sizes
    )


def kinetic_energy(dynamics: Dynamics) -> Scalar:
    """Half of V . I V over the bodies, and of the rotors."""
    tree, total = dynamics.tree, dynamics.laden.rotor_energy(dynamics.ds)
    for body, twist in zip(tree.tree.bodies, body_twists(tree, dynamics.ds), strict=True):
        linear, angular = momentum(body, twist)
        total = total + 0.5 * (dot(twist[0], angular) + dot(twist[1], linear))
    return total


def gravity_energy(dynamics: Dynamics) -> Scalar:
    """-m g . c over the bodies."""
    moment: Vector = (0.0, 0.0, 0.0)
    for body, (rotation, origin) in zip(
        dynamics.tree.tree.bodies, dynamics.tree.poses(), strict=True
    ):
        moment = add(moment, add(scale(body.mass, origin), matvec(rotation, body.first_moment)))
    return -dot(dynamics.gravity, moment)
