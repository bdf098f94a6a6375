"""Dynamics in minimal form, by projection of the spanning tree's forces with R."""

from __future__ import annotations

from ..algebra.definite import Definite
from ..algebra.linear import Rows, transposed
from ..algebra.scalar import Scalar
from ..algebra.vector import ZERO3, sub, trace
from ..closure.closed_motion import ClosedMotion
from ..dynamics.load_pattern import NOTHING, LoadedTree, LoadPattern
from ..kernels.trace import Check, Results
from .closure import closed_motion, closed_outputs
from .model import (
    AT_ACCELERATION,
    AT_EFFORT,
    AT_STATE,
    UNDER_GRAVITY,
    Inputs,
    Model,
    Program,
    with_loads,
)
from .outcome import Outcome, OutcomeKind

# share of the robot's own scale of inertia below which a pivot of M-bar is rounding
SINGULAR_MASS = 1e-13
MASS_SINGULAR = Outcome(OutcomeKind.MASS_SINGULAR).encode()


class Dynamics:
    """The closed mechanism at a state, with its loads: what all dynamic programs start from.

    Attributes:
        motion: the closed motion.
        checks: what the state must meet.
        distances: distance of each block to a singularity.
        ds: s' (n_s,).
        gravity: (3,) [m/s^2].
        loaded: the tree with its loads.
        tree: the tree, payloads added to its links.
        n: number of active coordinates.
    """

    def __init__(self, model: Model, x: Inputs, pattern: LoadPattern = NOTHING) -> None:
        self.motion, self.checks, self.distances = closed_motion(model, x)
        self.ds = self.motion.rates(x.du)
        self.gravity = tuple(x.gravity)
        self.loaded = LoadedTree(model.tree, pattern, x, self.motion.configuration)
        self.tree = self.loaded.tree
        self.n = len(x.u)

    def inverse(self, ddu: list[Scalar]) -> list[Scalar]:
        """tau (n,) for active accelerations."""
        dds = self.motion.accelerations(ddu, self.ds)
        return self.project(self.loaded.forces(self.gravity, self.ds, dds))

    def project(self, forces: list[Scalar]) -> list[Scalar]:
        """R^T f (n,)."""
        projected, _ = self.motion.project(forces)
        return projected

    def drift(self) -> list[Scalar]:
        """R' u' (n_s,): the accelerations with u'' = 0."""
        return self.motion.accelerations([0.0] * self.n, self.ds)

    def mass_matrix(self) -> list[list[Scalar]]:
        """M-bar = R^T M R (n, n), column by column; of each pair of equal entries one is taken."""
        columns: Rows = []
        for column in columns_of(self.motion):
            forces = self.loaded.inertial_forces(column)
            columns.append(self.project(forces))
        rows = [list(column) for column in columns]
        for i in range(self.n):
            for j in range(i):
                rows[i][j] = columns[j][i]
        return rows


def columns_of(motion: ClosedMotion) -> list[list[Scalar]]:
    """The columns of R, Chu (2020), Eq. 25."""
    return transposed(motion.velocity_map())


def inverse_dynamics(pattern: LoadPattern = NOTHING) -> Program:
    """Program for tau = R^T (M s'' + C s' + g + loads); tau_q: Chu (2020), below Eq. 17."""

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        tau = dynamics.inverse(list(x.ddu))
        return Results({"tau": tau}, dynamics.checks)

    return with_loads(AT_ACCELERATION, run, pattern)


def closed_inverse_dynamics(pattern: LoadPattern = NOTHING) -> Program:
    """Program for tau and all that a closed state is made of: what one sample of a motion says."""

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        closed = closed_outputs(dynamics.motion, dynamics.n, dynamics.ds, dynamics.distances)
        tau = dynamics.inverse(list(x.ddu))
        return Results({"tau": tau, **closed}, dynamics.checks)

    return with_loads(AT_ACCELERATION, run, pattern)


def minimal_form(pattern: LoadPattern = NOTHING) -> Program:
    """Program for M-bar, C-bar u' and G-bar of the minimal form.

    M-bar u'' + C-bar u' + G-bar + loads = tau, Chu (2020), Eq. 17.
    """

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        tree = dynamics.tree
        ds = dynamics.ds
        still: list[Scalar] = [0.0] * dynamics.motion.size
        drift = dynamics.drift()
        bias = dynamics.loaded.with_rotors(tree.inverse_dynamics(ZERO3, ds, drift), drift)
        gravity = tree.inverse_dynamics(dynamics.gravity, still, still)
        outputs = {
            "M": dynamics.mass_matrix(),
            "h": dynamics.project(bias),
            "g": dynamics.project(gravity),
        }
        return Results(outputs, dynamics.checks)

    return with_loads(UNDER_GRAVITY, run, pattern)


def passive_forces(pattern: LoadPattern = NOTHING) -> Program:
    """Program for what friction, springs and wrenches take of tau at rest or in motion."""

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        forces = dynamics.loaded.passive_forces(dynamics.ds)
        return Results({"tau": dynamics.project(forces)}, dynamics.checks)

    return with_loads(AT_STATE, run, pattern)


def forward_dynamics(pattern: LoadPattern = NOTHING) -> Program:
    """Program for u'' from tau: M-bar u'' = tau - (C-bar u' + G-bar + loads)."""

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        ddu, _, checks = solve_motion(model, dynamics, list(x.tau))
        return Results({"ddu": ddu}, dynamics.checks + checks)

    return with_loads(AT_EFFORT, run, pattern)


def solve_motion(
    model: Model, dynamics: Dynamics, tau: list[Scalar]
) -> tuple[list[Scalar], Definite, list[Check]]:
    """Solve for u''.

    Args:
        model: the robot.
        dynamics: its dynamics at a state.
        tau: active efforts (n,).

    Returns:
        u'' (n,), M-bar ready to solve with, and the checks that it is regular.
    """
    mass = Definite(dynamics.mass_matrix())
    bias = dynamics.inverse([0.0] * dynamics.n)
    ddu = mass.solve(sub(tau, bias))
    checks: list[Check] = []
    scales = inertia_scales(model, dynamics.motion)
    for pivot, scale in zip(mass.pivots, scales, strict=True):
        checks.append(Check(pivot / scale, SINGULAR_MASS, MASS_SINGULAR))
    return ddu, mass, checks


def inertia_scales(model: Model, motion: ClosedMotion) -> list[Scalar]:
    """What the diagonal of M-bar would be if each coordinate moved the whole robot.

    This is the scale of its rounding.
    """
    mass, inertia = _mass_and_inertia(model)
    sizes: list[float] = []
    for k in range(motion.size):
        size = mass
        if model.tree.is_revolute(k):
            size = inertia
        sizes.append(size)
    scales: list[Scalar] = []
    for column in columns_of(motion):
        total: Scalar = 0.0
        for size, factor in zip(sizes, column, strict=True):
            total = total + size * (factor * factor)
        scales.append(total)
    return scales


def _mass_and_inertia(model: Model) -> tuple[float, float]:
    """Mass [kg] of all bodies, and a bound of their inertia about any of their joints [kg m^2].

    1 where there is none.
    """
    bodies = model.tree.bodies
    mass = sum(body.mass for body in bodies) or 1.0
    squares: list[float] = []
    for body in bodies:
        squares += [float(length) ** 2 for length in body.translation]
    inertia = sum(trace(body.inertia) for body in bodies) + mass * sum(squares)
    return mass, inertia or 1.0
