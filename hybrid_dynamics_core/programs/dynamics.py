"""Dynamics in minimal form, by projection of the spanning tree's forces with R."""

from __future__ import annotations

from ..algebra.definite import Definite
from ..algebra.scalar import Scalar
from ..algebra.vector import Vector
from ..closure.closed_motion import ClosedMotion
from ..dynamics.load_pattern import NOTHING, LoadedTree, LoadPattern
from ..kernels.trace import Check, Results
from .closure import closed_motion, closed_outputs
from .model import Inputs, Model, Program
from .outcome import Outcome, OutcomeKind

SINGULAR_MASS = (
    1e-13  # share of the robot's own scale of inertia below which a pivot of M-bar is rounding
)
NO_GRAVITY: Vector = (0.0, 0.0, 0.0)


class Dynamics:
    """The closed mechanism at a state, with its loads: what all dynamic programs start from."""

    def __init__(self, model: Model, x: Inputs, pattern: LoadPattern = NOTHING) -> None:
        self.motion, self.checks, self.distances = closed_motion(model, x)
        self.ds = self.motion.rates(x.du)
        self.gravity = tuple(x.gravity)
        self.laden = LoadedTree(model.tree, pattern, x, self.motion.configuration)
        self.tree = self.laden.tree
        self.n = len(x.u)

    def inverse(self, ddu: list[Scalar]) -> list[Scalar]:
        """tau for active accelerations."""
        return self.project(
            self.laden.forces(self.gravity, self.ds, self.motion.accelerations(ddu, self.ds))
        )

    def project(self, forces: list[Scalar]) -> list[Scalar]:
        """R^T f."""
        return self.motion.project(forces)[0]

    def mass_matrix(self) -> list[list[Scalar]]:
        """M-bar = R^T M R, column by column; of each pair of equal entries one is computed."""
        columns = [
            self.project(self.laden.inertial_forces(column)) for column in columns_of(self.motion)
        ]
        return [[columns[min(i, j)][max(i, j)] for j in range(self.n)] for i in range(self.n)]


def columns_of(motion: ClosedMotion) -> list[list[Scalar]]:
    """The columns of R, Chu (2020), Eq. 20."""
    return [list(column) for column in zip(*motion.velocity_map(), strict=True)]


def inverse_dynamics(pattern: LoadPattern = NOTHING) -> Program:
    """Program for tau = R^T (M s'' + C s' + g + loads), Chu (2020), Eq. 22 to 25."""

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        return Results({"tau": dynamics.inverse(list(x.ddu))}, dynamics.checks)

    return Program(
        ("u", "du", "ddu", "branch", "guess", "gravity", *pattern.inputs), run, pattern.sizes
    )


def closed_inverse_dynamics(pattern: LoadPattern = NOTHING) -> Program:
    """Program for tau and all that a closed state is made of: what one sample of a motion says."""

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        closed = closed_outputs(dynamics.motion, dynamics.n, dynamics.ds, dynamics.distances)
        return Results({"tau": dynamics.inverse(list(x.ddu)), **closed}, dynamics.checks)

    return Program(
        ("u", "du", "ddu", "branch", "guess", "gravity", *pattern.inputs), run, pattern.sizes
    )


def minimal_form(pattern: LoadPattern = NOTHING) -> Program:
    """Program for M-bar, C-bar u' and G-bar of  M-bar u'' + C-bar u' + G-bar + loads = tau, Chu (2020), Eq. 25."""

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        motion, tree, ds = dynamics.motion, dynamics.tree, dynamics.ds
        still: list[Scalar] = [0.0] * motion.size
        drift = motion.accelerations([0.0] * dynamics.n, ds)
        bias = dynamics.laden.with_rotors(tree.inverse_dynamics(NO_GRAVITY, ds, drift), drift)
        gravity = tree.inverse_dynamics(dynamics.gravity, still, still)
        outputs = {
            "M": dynamics.mass_matrix(),
            "h": dynamics.project(bias),
            "g": dynamics.project(gravity),
        }
        return Results(outputs, dynamics.checks)

    return Program(("u", "du", "branch", "guess", "gravity", *pattern.inputs), run, pattern.sizes)


def passive_forces(pattern: LoadPattern = NOTHING) -> Program:
    """Program for what friction, springs and wrenches take of tau at rest or in motion."""

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        forces = dynamics.laden.passive_forces(dynamics.ds)
        return Results({"tau": dynamics.project(forces)}, dynamics.checks)

    return Program(("u", "du", "branch", "guess", *pattern.inputs), run, pattern.sizes)


def forward_dynamics(pattern: LoadPattern = NOTHING) -> Program:
    """Program for u'' from tau: M-bar u'' = tau - (C-bar u' + G-bar + loads)."""

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        ddu, _, checks = solve_motion(model, dynamics, list(x.tau))
        return Results({"ddu": ddu}, dynamics.checks + checks)

    return Program(
        ("u", "du", "tau", "branch", "guess", "gravity", *pattern.inputs), run, pattern.sizes
    )


def solve_motion(
    model: Model, dynamics: Dynamics, tau: list[Scalar]
) -> tuple[list[Scalar], Definite, list[Check]]:
    """u'' from tau, M-bar ready to solve with, and the checks that it is regular."""
    mass = Definite(dynamics.mass_matrix())
    bias = dynamics.inverse([0.0] * dynamics.n)
    ddu = mass.solve([t - b for t, b in zip(tau, bias, strict=True)])
    sizes = inertia_scales(model, dynamics.motion)
    code = Outcome(OutcomeKind.MASS_SINGULAR).encode()
    checks = [
        Check(pivot / size, SINGULAR_MASS, code)
        for pivot, size in zip(mass.pivots, sizes, strict=True)
    ]
    return ddu, mass, checks


def inertia_scales(model: Model, motion: ClosedMotion) -> list[Scalar]:
    """What M-bar's diagonal would be, were the whole robot moved by each coordinate: the scale of its rounding."""
    bodies = model.tree.bodies
    mass = sum(b.mass for b in bodies) or 1.0
    lengths = sum(float(x) ** 2 for b in bodies for x in b.translation)
    inertia = (
        sum(b.inertia[0][0] + b.inertia[1][1] + b.inertia[2][2] for b in bodies) + mass * lengths
    )
    own = [(inertia or 1.0) if model.tree.is_revolute(k) else mass for k in range(motion.size)]
    scales = []
    for column in columns_of(motion):
        total: Scalar = 0.0
        for size, factor in zip(own, column, strict=True):
            total = total + size * (factor * factor)
        scales.append(total)
    return scales


INVERSE_DYNAMICS = inverse_dynamics()
MINIMAL_FORM = minimal_form()
FORWARD_DYNAMICS = forward_dynamics()
