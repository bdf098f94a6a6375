"""Accelerations from efforts, without the idle coordinates that move no mass.

A rod between two ball joints can spin about its own axis. A thin rod has no inertia about it, so
this acceleration is undetermined and has no effect. It is set to zero, and its equation is left
out.
"""

from __future__ import annotations

from collections.abc import Collection

from ..algebra.definite import Definite
from ..algebra.scalar import Scalar, Scalars, absolute, rint
from ..algebra.vector import dot, sub
from ..closure.closed_motion import ClosedMotion
from ..dynamics.load_pattern import NOTHING, LoadPattern
from ..kernels.trace import Check, Results
from ..mechanism.total_inertia import total_inertia, total_mass
from .dynamics import Dynamics, columns_of
from .model import AT_EFFORT, Inputs, Model, Program, with_loads
from .outcome import Outcome, OutcomeKind

# a pivot of M-bar below this share of the robot's scale of inertia is rounding
SINGULAR_MASS = 1e-13
MASS_SINGULAR = Outcome(OutcomeKind.MASS_SINGULAR).encode()
# a force below this share of the robot's scale of force is rounding
NO_FORCE = 1e-9
# least share of a coordinate in a motion, in scales of inertia; below it is rounding
NO_PART = 1e-6
TINY = 1e-300  # a robot without any force or inertia has no scale


def forward_dynamics(pattern: LoadPattern = NOTHING) -> Program:
    """Program for u'' from tau: M-bar u'' = tau - (C-bar u' + G-bar + loads)."""

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern, minimal=is_regrouped(model))
        ddu, _, checks = solve_motion(model, dynamics, list(x.tau))
        return Results({"ddu": ddu}, dynamics.checks + checks, ("ddu",), dynamics.closed)

    return with_loads(AT_EFFORT, run, pattern)


def is_regrouped(model: Model) -> bool:
    """Whether forward dynamics uses regrouped parameters.

    With regrouped parameters, the inertia of an idle coordinate that moves no mass would be a
    rounding error in place of zero.
    """
    return not model.idle


def solve_motion(
    model: Model, dynamics: Dynamics, tau: list[Scalar]
) -> tuple[list[Scalar], Definite, list[Check]]:
    """Solve for u''.

    Args:
        model: the robot.
        dynamics: its dynamics at a state.
        tau: active efforts (n,).

    Returns:
        u'' (n,), M-bar ready to solve with, and the checks that it is regular. Idle coordinates
        that move no mass have no acceleration, and are left out of M-bar.
    """
    scales = InertiaScales(model, dynamics.motion)

    def keep(i: int, pivot: Scalar) -> Scalar:
        if i not in model.idle:
            return 1.0
        return _is_above(pivot / scales.active[i], SINGULAR_MASS)

    mass = Definite(dynamics.mass_matrix(), keep=keep)
    forces = dynamics.loaded.forces(dynamics.gravity, dynamics.ds, dynamics.drift())
    rhs = sub(tau, dynamics.project(list(forces)))
    ddu = mass.solve(rhs)
    checks: list[Check] = []
    for i, (pivot, scale) in enumerate(zip(mass.pivots, scales.active, strict=True)):
        least = -SINGULAR_MASS if i in model.idle else SINGULAR_MASS
        checks.append(Check(pivot - least * scale, 0.0, MASS_SINGULAR))
    if model.idle:
        size = _square_of_forces(dynamics, scales, forces, tau)
        for i, force in enumerate(mass.remainders(rhs)):
            if i in model.idle:
                limit = NO_FORCE**2 * size * scales.active[i]
                checks.append(_moves_no_other(mass, i, model.idle, scales.active))
                checks.append(_has_no_force(mass.mask[i], force, limit))
    return ddu, mass, checks


class InertiaScales:
    """Scale of the inertia of each coordinate: as if it moved the whole robot.

    Rounding of M-bar is judged by these scales.

    Attributes:
        mass: mass of all moving links [kg].
        along_s: scales of all coordinates (n_s,) [kg m^2, kg].
        active: scales of the active coordinates (n,), with the passive joints that they move.
    """

    def __init__(self, model: Model, motion: ClosedMotion) -> None:
        self.mass = total_mass(model.measured) or 1.0
        inertia = total_inertia(model.measured, model.plan.reference) or 1.0
        self.along_s: list[float] = []
        for k in range(motion.size):
            is_angle = model.tree.is_revolute(k)
            self.along_s.append(inertia if is_angle else self.mass)
        self.active: list[Scalar] = []
        for column in columns_of(motion):
            total: Scalar = 0.0
            for size, factor in zip(self.along_s, column, strict=True):
                total = total + size * (factor * factor)
            self.active.append(total)


def _is_above(value: Scalar, limit: float) -> Scalar:
    """1 where a value is above a limit, 0 where it is not."""
    share = value / (absolute(value) + limit)  # above a half if the value is above the limit
    return rint(0.5 * (share + absolute(share)))


def _moves_no_other(mass: Definite, i: int, idle: Collection[int], scales: Scalars) -> Check:
    """Check that the massless motion of a dropped coordinate moves no driven coordinate.

    Args:
        mass: M-bar.
        i: the coordinate.
        idle: the coordinates that may be dropped.
        scales: scales of the inertia of the active coordinates (n,).
    """
    part: Scalar = 0.0
    for k, share in enumerate(mass.dependence(i)):
        if k not in idle:
            part = part + scales[k] * (share * share)
    part = (1.0 - mass.mask[i]) * part
    return Check(NO_PART**2 * scales[i] - part, 0.0, MASS_SINGULAR)


def _has_no_force(mask: Scalar, force: Scalar, limit: Scalar) -> Check:
    """Check that no force acts along a dropped coordinate: its square is below the limit."""
    excess = (1.0 - mask) * (force * force)
    return Check(limit + TINY - excess, 0.0, MASS_SINGULAR)


def _square_of_forces(
    dynamics: Dynamics, scales: InertiaScales, forces: Scalars, tau: Scalars
) -> Scalar:
    """Sum of squared forces on a robot, each over the inertia that it acts on.

    Weight and inertia also count separately, since they may cancel in the sum.
    """
    pairs = [*zip(forces, scales.along_s, strict=True), *zip(tau, scales.active, strict=True)]
    total: Scalar = scales.mass * dot(dynamics.gravity, dynamics.gravity)
    for force, scale in pairs:
        total = total + force * force / scale
    for rate, scale in zip(dynamics.ds, scales.along_s, strict=True):
        square = rate * rate
        total = total + scale * (square * square)
    return total
