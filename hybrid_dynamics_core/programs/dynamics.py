"""Dynamics in minimal form, by projection of the spanning tree's forces with R."""

from __future__ import annotations

from ..algebra.linear import Rows, transposed
from ..algebra.scalar import Scalar, Scalars
from ..algebra.vector import ZERO3
from ..closure.closed_motion import ClosedMotion
from ..dynamics.load_pattern import NOTHING, LoadedTree, LoadPattern
from ..kernels.differentiate import symmetric_matrix
from ..kernels.trace import Results
from .closure import closed_motion, closed_outputs
from .model import (
    AT_ACCELERATION,
    AT_STATE,
    UNDER_GRAVITY,
    Inputs,
    Model,
    Program,
    with_loads,
)


class Dynamics:
    """The closed mechanism at a state, with its loads; all dynamic programs start from it.

    Attributes:
        motion: the closed motion.
        checks: conditions on the state.
        distances: distance of each block to a singularity.
        ds: s' (n_s,).
        gravity: (3,) [m/s^2].
        loaded: the tree with its loads.
        tree: the tree, payloads added to its links.
        n: number of active coordinates.
    """

    def __init__(
        self, model: Model, x: Inputs, pattern: LoadPattern = NOTHING, *, minimal: bool = False
    ) -> None:
        """Close the mechanism and load its tree.

        Args:
            model: the robot.
            x: inputs of the program.
            pattern: pattern of the loads.
            minimal: whether only forces along the active coordinates are asked for: inertial
                parameters are then regrouped, and links with parallel joints have common axes.
        """
        self.motion, self.checks, self.distances = closed_motion(model, x)
        self.ds = self.motion.rates(x.du)
        self.gravity = pattern.gravity_of(x.gravity)
        tree, layout = model.tree, None
        if minimal:
            tree, layout = model.regrouped, model.layout
        self.loaded = LoadedTree(tree, pattern, x, self.motion.configuration, layout)
        self.tree = self.loaded.tree
        self.n = len(x.u)
        self._u = x.u
        self._dds: list[Scalar] = []

    @property
    def closed(self) -> list[Scalar]:
        """Results of the closure, which are the same to the last bit in all programs."""
        configuration = self.motion.configuration
        values = [*configuration.q, *configuration.c, *configuration.s, *self.ds]
        values += [check.value for check in self.checks]
        return [value for value in [*values, *self._dds] if value is not None]

    def inverse(self, ddu: list[Scalar]) -> list[Scalar]:
        """tau (n,) for active accelerations."""
        self._dds = dds = self.motion.accelerations(ddu, self.ds)
        return self.project(self.loaded.forces(self.gravity, self.ds, dds))

    def project(self, forces: list[Scalar]) -> list[Scalar]:
        """R^T f (n,)."""
        projected, _ = self.motion.project(forces)
        return projected

    def drift(self) -> list[Scalar]:
        """R' u' (n_s,): the accelerations with u'' = 0."""
        return self.motion.accelerations([0.0] * self.n, self.ds)

    def mass_matrix(self) -> Rows:
        """M-bar = R^T M R (n, n), the matrix of u'' -> R^T M R u''; M has no term of rates."""

        def along_active(ddu: Scalars) -> list[Scalar]:
            return self.project(self.loaded.inertial_forces(self.motion.rates(ddu)))

        return symmetric_matrix(along_active, self._u)


def columns_of(motion: ClosedMotion) -> list[list[Scalar]]:
    """The columns of R, Chu (2020), Eq. 25."""
    return transposed(motion.velocity_map())


def inverse_dynamics(pattern: LoadPattern = NOTHING) -> Program:
    """Program for tau = R^T (M s'' + C s' + g + loads); tau_q: Chu (2020), below Eq. 17."""

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern, minimal=True)
        tau = dynamics.inverse(list(x.ddu))
        return Results({"tau": tau}, dynamics.checks, ("tau",), dynamics.closed)

    return with_loads(AT_ACCELERATION, run, pattern)


def closed_inverse_dynamics(pattern: LoadPattern = NOTHING) -> Program:
    """Program for tau and the outputs of a closed state, for samples of a motion."""

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern, minimal=True)
        closed = closed_outputs(dynamics.motion, dynamics.n, dynamics.ds, dynamics.distances)
        tau = dynamics.inverse(list(x.ddu))
        outputs = {"tau": tau, **closed}
        return Results(outputs, dynamics.checks, ("tau",), dynamics.closed)

    return with_loads(AT_ACCELERATION, run, pattern)


def minimal_form(pattern: LoadPattern = NOTHING) -> Program:
    """Program for M-bar, C-bar u' and G-bar of the minimal form.

    M-bar u'' + C-bar u' + G-bar + loads = tau, Chu (2020), Eq. 17.
    """

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern, minimal=True)
        loaded = dynamics.loaded
        ds = dynamics.ds
        still: list[Scalar] = [0.0] * dynamics.motion.size
        drift = dynamics.drift()
        inertial = loaded.without_loads(ZERO3, ds, drift)
        bias = loaded.with_rotors(inertial, drift, ds, ds)
        gravity = loaded.without_loads(dynamics.gravity, still, still)
        outputs = {
            "M": dynamics.mass_matrix(),
            "h": dynamics.project(bias),
            "g": dynamics.project(gravity),
        }
        return Results(outputs, dynamics.checks, tuple(outputs), dynamics.closed)

    return with_loads(UNDER_GRAVITY, run, pattern)


def passive_forces(pattern: LoadPattern = NOTHING) -> Program:
    """Program for the part of tau that balances friction, springs and wrenches."""

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        forces = dynamics.loaded.passive_forces(dynamics.ds)
        return Results({"tau": dynamics.project(forces)}, dynamics.checks)

    return with_loads(AT_STATE, run, pattern)
