"""Energy and power, for the balance of a simulation."""

from __future__ import annotations

from dataclasses import replace

from ..algebra.scalar import Scalar
from ..algebra.vector import ZERO3, Vector, add, dot, matvec, scale, sub
from ..dynamics.bilinear import body_twists, momentum
from ..dynamics.load_pattern import NOTHING, LoadPattern
from ..kernels.trace import Results
from .dynamics import Dynamics
from .forward import solve_motion
from .model import AT_EFFORT, UNDER_GRAVITY, Inputs, Model, Program, with_loads
from .warm_start import next_start


def energy(pattern: LoadPattern = NOTHING) -> Program:
    """Program for kinetic energy, potential energy of gravity and energy of the springs.

    The potential energy is zero at the base origin.
    """

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        outputs = {
            "kinetic": kinetic_energy(dynamics),
            "potential": gravity_energy(dynamics),
            "springs": dynamics.loaded.spring_energy(),
        }
        return Results(outputs, dynamics.checks)

    return with_loads(UNDER_GRAVITY, run, pattern)


def motion(pattern: LoadPattern = NOTHING) -> Program:
    """Program for u'' from tau, and for the power that is put in.

    The power is that of actuators and applied wrenches, less that of friction.
    """

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        ddu, _, checks = solve_motion(model, dynamics, list(x.tau))
        power: Scalar = 0.0
        for effort, rate in zip(x.tau, x.du, strict=True):
            power = power + effort * rate
        dissipated = dynamics.loaded.dissipative_forces(dynamics.ds)
        for force, rate in zip(dissipated, dynamics.ds, strict=True):
            power = power - force * rate
        return Results({"ddu": ddu, "power": power}, dynamics.checks + checks)

    return with_loads(AT_EFFORT, run, pattern)


def motion_and_configuration(pattern: LoadPattern = NOTHING) -> Program:
    """The program `motion`, with all coordinates and R row by row as further outputs."""
    program = motion(pattern)

    def run(model: Model, x: Inputs) -> Results:
        results = program.run(model, x)
        return replace(results, outputs={**results.outputs, **next_start(model, x).outputs})

    return replace(program, run=run)


def kinetic_energy(dynamics: Dynamics) -> Scalar:
    """Half of V . I V over the bodies, and of the rotors."""
    tree = dynamics.tree
    total = dynamics.loaded.rotor_energy(dynamics.ds)
    for body, twist in zip(tree.tree.bodies, body_twists(tree, dynamics.ds), strict=True):
        linear, angular = momentum(body, twist)
        omega, v = twist
        total = total + 0.5 * (dot(omega, angular) + dot(v, linear))
    return total


def gravity_energy(dynamics: Dynamics) -> Scalar:
    """-m g . c over the bodies, of the mass whose weight is felt."""
    tree = dynamics.tree
    moment: Vector = ZERO3
    for body, (rotation, origin) in zip(tree.tree.bodies, tree.poses(), strict=True):
        felt = sub(body.first_moment, body.compensated_moment)
        mass = body.mass - body.compensated_mass
        of_body = add(scale(mass, origin), matvec(rotation, felt))
        moment = add(moment, of_body)
    return -dot(dynamics.gravity, moment)
