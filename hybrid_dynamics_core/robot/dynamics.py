"""The dynamic part of Robot: forces from motion and motion from forces, with everything that acts on the robot."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike

from .. import programs
from ..closed_state.state import ClosedState, settle
from ..description.model import Frame
from ..dynamics.dae import SpanningTerms
from ..dynamics.energy import Energy
from ..dynamics.load_pattern import LoadPattern
from ..dynamics.loads import Loads, described_loads
from ..dynamics.mass import mass_singularity
from ..dynamics.pack_loads import pack_loads
from ..dynamics.parameters import Parameters, described_parameters
from ..dynamics.pins import Pin, find_pins
from ..dynamics.reactions import Reactions, named_reactions
from ..errors import InputError
from ..ground.arrays import Array
from ..kernels.run import Kernel
from ..kernels.status import MASS_SINGULAR
from .closure import ClosingRobot

LoadedProgram = Callable[[LoadPattern], programs.Program]
MotionFunction = Callable[[Array, Array, Array], tuple[Array, float]]


class RobotDynamics(ClosingRobot):
    """Methods of Robot. States come from `robot.close`; one state gives (n,), a batch (N, n), in the order of `active`.

    `loads` is everything that acts besides the actuators; None: what the description gives,
    `robot.loads`.
    """

    if TYPE_CHECKING:  # in Robot

        def _frame(self, frame: str | None) -> Frame: ...

    @cached_property
    def loads(self) -> Loads:
        """What the description says acts on the robot: gravity, payloads, friction, rotors, springs."""
        return described_loads(self.description, self.coordinates)

    def inverse_dynamics(
        self, state: ClosedState, ddu: ArrayLike, loads: Loads | None = None
    ) -> Array:
        """Actuator torques [N m] and forces [N], (n,) or (N, n), for active accelerations ddu; Chu (2020), Eq. 25."""
        ddu = self._like(state, "ddu", ddu)
        return self._evaluate("inverse_dynamics", programs.inverse_dynamics, state, loads, ddu=ddu)[
            "tau"
        ]

    def forward_dynamics(
        self, state: ClosedState, tau: ArrayLike, loads: Loads | None = None
    ) -> Array:
        """Active accelerations (n,) or (N, n) [rad/s^2, m/s^2] from actuator torques [N m] and forces [N].

        Raises MassSingularityError where M-bar is singular to working precision: some motion of the
        active joints moves no mass. Chu (2020), Eq. 25.
        """
        tau = self._like(state, "tau", tau)
        return self._evaluate("forward_dynamics", programs.forward_dynamics, state, loads, tau=tau)[
            "ddu"
        ]

    def inverse_dynamics_derivatives(
        self, state: ClosedState, ddu: ArrayLike, loads: Loads | None = None
    ) -> tuple[Array, Array, Array]:
        """d tau/du, d tau/du' and d tau/du'' = M-bar, each (n, n) or (N, n, n), exact; rows by tau."""
        ddu = self._like(state, "ddu", ddu)
        program = programs.inverse_dynamics_derivatives
        values = self._evaluate("inverse_dynamics_derivatives", program, state, loads, ddu=ddu)
        return values["d_u"], values["d_du"], values["d_ddu"]

    def forward_dynamics_derivatives(
        self, state: ClosedState, tau: ArrayLike, loads: Loads | None = None
    ) -> tuple[Array, Array, Array]:
        """d u''/du, d u''/du' and d u''/d tau = M-bar^-1, each (n, n) or (N, n, n), exact; rows by u''.

        Raises MassSingularityError as `forward_dynamics` does.
        """
        tau = self._like(state, "tau", tau)
        program = programs.forward_dynamics_derivatives
        values = self._evaluate("forward_dynamics_derivatives", program, state, loads, tau=tau)
        return values["d_u"], values["d_du"], values["d_tau"]

    def minimal_form(
        self, state: ClosedState, loads: Loads | None = None
    ) -> tuple[Array, Array, Array]:
        """M-bar (n, n), C-bar u' (n,) and G-bar (n,) of M-bar u'' + C-bar u' + G-bar = tau; Chu (2020), Eq. 25.

        Payloads and rotors are in them; what friction, springs and wrenches add to tau is
        `passive_forces`.
        """
        values = self._evaluate("minimal_form", programs.minimal_form, state, loads)
        return values["M"], values["h"], values["g"]

    def passive_forces(self, state: ClosedState, loads: Loads | None = None) -> Array:
        """What friction, springs and applied wrenches add to M-bar u'' + C-bar u' + G-bar = tau, (n,) or (N, n)."""
        return self._evaluate("passive_forces", programs.passive_forces, state, loads)["tau"]

    def regressor(
        self,
        state: ClosedState,
        ddu: ArrayLike,
        parameters: Parameters | None = None,
        loads: Loads | None = None,
    ) -> Array:
        """Y (n, p) or (N, n, p) of Y pi = tau: tau is linear in the parameters pi of links and joints.

        parameters: which, and in what order (None: the inertias of all links that have mass). Of
        `loads` gravity and
            the smoothing of friction count; payloads, springs and wrenches are not part of Y pi.

        Raises InputError where the result is not finite.
        """
        ddu = self._like(state, "ddu", ddu)
        parameters = described_parameters(self.description) if parameters is None else parameters
        parameters.check(self.description)
        loads = self.loads if loads is None else loads
        known = {"u": state.u, "du": state.du, "ddu": ddu, "branch": state.signs, "guess": state.s}
        known |= {"gravity": loads.gravity, "smoothing": loads.effects.smoothing}
        values, codes = self._run(
            f"regressor {parameters}", programs.regressor(parameters), None, **known
        )
        settle(state, values, codes)
        return values["Y"]

    def motion_near(self, state: ClosedState, loads: Loads | None = None) -> MotionFunction:
        """For integrators: (u, u', tau) -> (u'', power in [W]), all (n,), followed from one closed state nearby.

        The power is that of tau and of applied wrenches, less friction's; energy changes by it.
        Where the loops do not close the results are NaN. Raises MassSingularityError as
        `forward_dynamics` does.
        """
        self._own(state)
        loads = self.loads if loads is None else loads
        pattern, arrays = self._pack_loads(loads, None)
        program, key = programs.motion(pattern), pattern.key("motion")

        def motion(u: Array, du: Array, tau: Array) -> tuple[Array, float]:
            guess = state.s + state.R @ (u - state.u)
            known = {"branch": state.signs, "guess": guess, "gravity": loads.gravity, **arrays}
            values, code = self._run(key, program, None, u=u, du=du, tau=tau, **known)
            if code == 0:
                return values["ddu"], float(values["power"])
            if code == MASS_SINGULAR:
                mass = self.minimal_form(self.close(u, du, near=state), loads)[0]
                raise mass_singularity(mass, np.array(True), self.active)
            return np.full_like(u, np.nan), np.nan

        return motion

    def energy(self, state: ClosedState, loads: Loads | None = None) -> Energy:
        """Energies of motion, of gravity (zero at the base origin) and of springs [J], each a number or (N,)."""
        values = self._evaluate("energy", programs.energy, state, loads)
        return Energy(values["kinetic"], values["potential"], values["springs"])

    def coriolis_matrix(self, state: ClosedState, loads: Loads | None = None) -> Array:
        """C-bar (n, n) or (N, n, n), the Christoffel matrix of M-bar: M-bar' - 2 C-bar is skew.

        Chu (2020), Eq. 25.
        """
        return self._evaluate("coriolis_matrix", programs.coriolis_matrix, state, loads)["C"]

    def velocity_map_rate(self, state: ClosedState) -> Array:
        """R' (n_s, n) or (N, n_s, n), the rate of R along the motion: s'' = R u'' + R' u'.

        Chu (2020), Eq. 20.
        """
        return self._evaluate("coriolis_matrix", programs.coriolis_matrix, state, None)["dR"]

    def spanning_terms(
        self, state: ClosedState, ddu: ArrayLike | None = None, loads: Loads | None = None
    ) -> SpanningTerms:
        """The terms of the full DAE in all coordinates s, Chu (2020), Eq. 10.

        ddu: active accelerations (n,) or (N, n) for which the multipliers are, zero if None.
        """
        ddu = np.zeros_like(state.u) if ddu is None else self._like(state, "ddu", ddu)
        values = self._evaluate("spanning_terms", programs.spanning_terms, state, loads, ddu=ddu)
        equations = [e for step in self._model.plan.blocks for e in step.equations]
        return SpanningTerms(
            M=values["M"],
            C=values["C"],
            g=values["g"],
            extra=values["e"],
            J=values["J"],
            bias=values["bias"],
            multipliers=values["multipliers"],
            loops=tuple(e.loop.name for e in equations),
        )

    def reactions(
        self, state: ClosedState, ddu: ArrayLike | None = None, loads: Loads | None = None
    ) -> Reactions:
        """What every closure pin, joint and the foundation bear [N, N m], to size them by.

        ddu: active accelerations (n,) or (N, n), zero if None.

        Base axes. In balance link by link with weight, inertia and loads; rotors count along their
        joints only.
        """
        ddu = np.zeros_like(state.u) if ddu is None else self._like(state, "ddu", ddu)
        closures = self.description.closures

        def program(pattern: LoadPattern) -> programs.Program:
            return programs.reactions(closures, pattern)

        values = self._evaluate("reactions", program, state, loads, ddu=ddu)
        return named_reactions(values, self._pins, self._model.tree, closures)

    @cached_property
    def _pins(self) -> list[Pin]:
        return find_pins(self._model.tree, self._model.plan, self.description.closures)

    def _evaluate(
        self,
        key: str,
        program: LoadedProgram,
        state: ClosedState,
        loads: Loads | None,
        **more: Array,
    ) -> dict[str, Array]:
        """Run a program on a state; rows that `close(..., check=False)` let through stay NaN."""
        self._own(state)
        loads = self.loads if loads is None else loads
        pattern, arrays = self._pack_loads(loads, None if state.u.ndim == 1 else len(state.u))
        kernel, names = self._loaded(key, program, pattern)
        inputs = {
            "u": state.u,
            "du": state.du,
            "branch": state.signs,
            "guess": state.s,
            "gravity": loads.gravity,
        }
        inputs |= arrays | more
        values, codes = kernel(*(inputs[name] for name in names))
        if codes.any():
            singular = np.asarray(codes == MASS_SINGULAR)
            if singular.any():
                raise mass_singularity(self.minimal_form(state, loads)[0], singular, self.active)
            settle(state, values, codes)
        return values

    def _loaded(
        self, key: str, program: LoadedProgram, pattern: LoadPattern
    ) -> tuple[Kernel, tuple[str, ...]]:
        """The kernel of a program under a pattern, and the names of its inputs."""
        known = self._loaded_kernels.get((key, pattern))
        if known is None:
            made = program(pattern)
            known = self._loaded_kernels[key, pattern] = (
                self.kernel(pattern.key(key), made),
                made.inputs,
            )
        return known

    @cached_property
    def _loaded_kernels(self) -> dict[tuple[str, LoadPattern], tuple[Kernel, tuple[str, ...]]]:
        return {}

    def _pack_loads(self, loads: Loads, rows: int | None) -> tuple[LoadPattern, dict[str, Array]]:
        if not isinstance(loads, Loads):
            raise InputError(f"expected Loads, such as robot.loads, got {type(loads).__name__}")
        known = self._known_loads.get(loads)
        if known is None:
            known = pack_loads(loads, self._model.tree, self._frame, rows)
            if all(wrench.values.ndim == 1 for wrench in loads.wrenches.values()):
                self._known_loads[loads] = known
        return known

    @cached_property
    def _known_loads(self) -> WeakKeyDictionary[Loads, tuple[LoadPattern, dict[str, Array]]]:
        return WeakKeyDictionary()
