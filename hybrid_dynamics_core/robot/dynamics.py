"""Inverse and forward dynamics of a robot under loads, and related quantities."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import programs
from ..closed_state.state import ClosedState, mark_open_rows
from ..dynamics.centroidal import Centroidal
from ..dynamics.dae import SpanningTerms
from ..dynamics.energy import Energy
from ..dynamics.load_pattern import LoadPattern
from ..dynamics.loads import Loads
from ..dynamics.mass import mass_singularity
from ..dynamics.parameters import Parameters, described_parameters
from ..dynamics.pins import Pin, find_pins
from ..dynamics.reactions import Reactions, named_reactions
from ..errors import InputError, MassSingularityError
from ..ground.arrays import Array
from ..ground.check_arguments import require_type
from ..ground.lazy import lazy
from ..kernels.status import MASS_SINGULAR, any_failed
from ..mechanism.total_inertia import total_mass
from .closure import Closure
from .kernel_store import KernelStore
from .loaded_programs import LoadedProgram, LoadedPrograms, Packed
from .model import RobotModel


class Dynamics:
    """Dynamics of a robot in its active coordinates, from closed states.

    Results are (n,) for one state and (N, n) for a batch, in the order of `active`. Loads are all
    forces besides the actuators. If they are None, those of the description act.

    Attributes:
        programs: its programs under loads.
    """

    def __init__(self, model: RobotModel, kernels: KernelStore, closure: Closure) -> None:
        self._model = model
        self._kernels = kernels
        self._closure = closure
        self.programs = LoadedPrograms(model, kernels)

    @property
    def loads(self) -> Loads:
        """Loads of the description: all forces besides the actuators."""
        return self.programs.described

    def pack(self, loads: Loads) -> Packed:
        """The pattern of loads, and their values as inputs of a program on one state."""
        return self.programs.pack(loads)

    def inverse_dynamics(
        self, state: ClosedState, ddu: ArrayLike, loads: Loads | None = None
    ) -> Array:
        """Actuator efforts for active accelerations, by the minimal form; Chu (2020), Eq. 17.

        Args:
            state: closed state, or a batch of N.
            ddu: active accelerations (n,) or (N, n) [rad/s^2, m/s^2].
            loads: loads besides the actuators; `robot.loads` if None.

        Returns:
            tau (n,) or (N, n) [N m, N].

        Raises:
            InputError: a shape is wrong, or the input or the result is not finite.
        """
        program = programs.inverse_dynamics
        return self._evaluate_with("inverse_dynamics", program, state, loads, ddu=ddu)["tau"]

    def forward_dynamics(
        self, state: ClosedState, tau: ArrayLike, loads: Loads | None = None
    ) -> Array:
        """Active accelerations from actuator efforts, by the minimal form; Chu (2020), Eq. 17.

        Args:
            state: closed state, or a batch of N.
            tau: actuator efforts (n,) or (N, n) [N m, N].
            loads: loads besides the actuators; `robot.loads` if None.

        Returns:
            u'' (n,) or (N, n) [rad/s^2, m/s^2].

        Raises:
            MassSingularityError: M-bar is singular to working precision, since a motion of the
                active joints moves no mass. A massless motion of idle coordinates only is no error,
                unless a force acts along it: their acceleration is zero.
            InputError: a shape is wrong, or the input or the result is not finite.
        """
        program = programs.forward_dynamics
        return self._evaluate_with("forward_dynamics", program, state, loads, tau=tau)["ddu"]

    def inverse_dynamics_derivatives(
        self, state: ClosedState, ddu: ArrayLike, loads: Loads | None = None
    ) -> tuple[Array, Array, Array]:
        """Exact derivatives of the actuator efforts.

        Args:
            state: closed state, or a batch of N.
            ddu: active accelerations (n,) or (N, n) [rad/s^2, m/s^2].
            loads: loads besides the actuators; `robot.loads` if None.

        Returns:
            d tau/du, d tau/du' and d tau/du'' = M-bar, each (n, n) or (N, n, n), rows by tau.
        """
        program = programs.inverse_dynamics_derivatives
        values = self._evaluate_with("inverse_dynamics_derivatives", program, state, loads, ddu=ddu)
        return values["d_u"], values["d_du"], values["d_ddu"]

    def forward_dynamics_derivatives(
        self, state: ClosedState, tau: ArrayLike, loads: Loads | None = None
    ) -> tuple[Array, Array, Array]:
        """Exact derivatives of the active accelerations.

        Args:
            state: closed state, or a batch of N.
            tau: actuator efforts (n,) or (N, n) [N m, N].
            loads: loads besides the actuators; `robot.loads` if None.

        Returns:
            d u''/du, d u''/du' and d u''/d tau = M-bar^-1, each (n, n) or (N, n, n), rows by u''.

        Raises:
            MassSingularityError: as in `forward_dynamics`.
        """
        program = programs.forward_dynamics_derivatives
        values = self._evaluate_with("forward_dynamics_derivatives", program, state, loads, tau=tau)
        return values["d_u"], values["d_du"], values["d_tau"]

    def minimal_form(
        self, state: ClosedState, loads: Loads | None = None
    ) -> tuple[Array, Array, Array]:
        """Terms of M-bar u'' + C-bar u' + G-bar = tau; Chu (2020), Eq. 17.

        Payloads and rotors are included. Friction, springs and wrenches add `passive_forces` to
        tau.

        Args:
            state: closed state, or a batch of N.
            loads: loads besides the actuators; `robot.loads` if None.

        Returns:
            M-bar (n, n), C-bar u' (n,) and G-bar (n,), with a leading N for a batch.
        """
        values = self._evaluate("minimal_form", programs.minimal_form, state, loads)
        return values["M"], values["h"], values["g"]

    def passive_forces(self, state: ClosedState, loads: Loads | None = None) -> Array:
        """Efforts of friction, springs and applied wrenches, which `minimal_form` leaves out.

        Args:
            state: closed state, or a batch of N.
            loads: loads besides the actuators; `robot.loads` if None.

        Returns:
            Efforts (n,) or (N, n) [N m, N].
        """
        return self._evaluate("passive_forces", programs.passive_forces, state, loads)["tau"]

    def regressor(
        self,
        state: ClosedState,
        ddu: ArrayLike,
        parameters: Parameters | None = None,
        loads: Loads | None = None,
    ) -> Array:
        """Regressor Y of Y pi = tau: tau is linear in the parameters pi of links and joints.

        Args:
            state: closed state, or a batch of N.
            ddu: active accelerations (n,) or (N, n) [rad/s^2, m/s^2].
            parameters: the parameters, in order; the inertias of all links with mass if None.
            loads: only gravity and the smoothing of friction are used, since payloads, springs and
                wrenches are not part of Y pi. `robot.loads` if None.

        Returns:
            Y (n, p) or (N, n, p).

        Raises:
            InputError: a shape is wrong, or the input or the result is not finite.
        """
        ddu = self._closure.vector_like(state, "ddu", ddu)
        if parameters is None:
            parameters = described_parameters(self._model.description)
        require_type("parameters", parameters, Parameters, "hybrid_dynamics_core.Parameters(...)")
        parameters.check(self._model.description)
        if loads is None:
            loads = self.loads
        require_type("loads", loads, Loads, "robot.loads")
        inputs = {"u": state.u, "du": state.du, "ddu": ddu}
        inputs |= {"branch": state.signs, "guess": state.s}
        inputs |= {"gravity": loads.gravity, "smoothing": loads.effects.smoothing}
        key, program = f"regressor {parameters}", programs.regressor(parameters)
        values, codes = self._kernels.run(key, program, inputs)
        mark_open_rows(state, values, codes)
        return values["Y"]

    def energy(self, state: ClosedState, loads: Loads | None = None) -> Energy:
        """Kinetic energy, potential energy of gravity (zero at the base origin) and spring energy.

        Args:
            state: closed state, or a batch of N.
            loads: loads besides the actuators; `robot.loads` if None.

        Returns:
            The energies [J], each a number or (N,).
        """
        values = self._evaluate("energy", programs.energy, state, loads)
        return Energy(values["kinetic"], values["potential"], values["springs"])

    def centroidal(self, state: ClosedState, loads: Loads | None = None) -> Centroidal:
        """Centre of mass with its Jacobian, and momentum with its matrix, in base axes.

        Args:
            state: closed state, or a batch of N.
            loads: only payloads are used; `robot.loads` if None.

        Raises:
            InputError: no moving link has a mass.
        """
        payloads = (self.loads if loads is None else loads).payloads
        if not payloads and not total_mass(self._model.tree):
            raise InputError("no moving link has a mass, so there is no centre of mass")
        values = self._evaluate("centroidal", programs.centroidal, state, loads)
        mass = float(np.max(values["mass"]))
        return Centroidal(mass, values["com"], values["A"], values["momentum"])

    def coriolis_matrix(self, state: ClosedState, loads: Loads | None = None) -> Array:
        """C-bar, Chu (2020), below Eq. 17: M-bar' - 2 C-bar is skew.

        It is the matrix of the Christoffel symbols of M-bar.

        Args:
            state: closed state, or a batch of N.
            loads: loads besides the actuators; `robot.loads` if None.

        Returns:
            C-bar (n, n) or (N, n, n).
        """
        return self._evaluate("coriolis_matrix", programs.coriolis_matrix, state, loads)["C"]

    def velocity_map_rate(self, state: ClosedState) -> Array:
        """Rate of R along the motion: s'' = R u'' + R' u'; Chu (2020), Eq. 15.

        Args:
            state: closed state, or a batch of N.

        Returns:
            R' (n_s, n) or (N, n_s, n).
        """
        return self._evaluate("coriolis_matrix", programs.coriolis_matrix, state, None)["dR"]

    def spanning_terms(
        self, state: ClosedState, ddu: ArrayLike | None = None, loads: Loads | None = None
    ) -> SpanningTerms:
        """Terms of the full DAE in all coordinates s; Chu (2020), Eq. 10.

        Args:
            state: closed state, or a batch of N.
            ddu: active accelerations (n,) or (N, n) for the multipliers; zero if None.
            loads: loads besides the actuators; `robot.loads` if None.
        """
        ddu = self._accelerations(state, ddu)
        values = self._evaluate("spanning_terms", programs.spanning_terms, state, loads, ddu=ddu)
        loops: list[str] = []
        for block in self._model.plan.blocks:
            loops += block.row_loops
        return SpanningTerms(
            M=values["M"],
            C=values["C"],
            g=values["g"],
            extra=values["e"],
            J=values["J"],
            bias=values["bias"],
            multipliers=values["multipliers"],
            loops=tuple(loops),
        )

    def reactions(
        self, state: ClosedState, ddu: ArrayLike | None = None, loads: Loads | None = None
    ) -> Reactions:
        """Reactions in all closures, joints and the foundation, for their design.

        They balance weight, inertia and loads of each link. Rotors act along their joints only.

        Args:
            state: closed state, or a batch of N.
            ddu: active accelerations (n,) or (N, n) [rad/s^2, m/s^2]; zero if None.
            loads: loads besides the actuators; `robot.loads` if None.

        Returns:
            Forces [N] and moments [N m] by name, in base axes.
        """
        ddu = self._accelerations(state, ddu)
        closures = self._model.description.closures

        def program(pattern: LoadPattern) -> programs.Program:
            return programs.reactions(closures, pattern)

        values = self._evaluate("reactions", program, state, loads, ddu=ddu)
        return named_reactions(values, self._pins, self._model.tree, closures)

    @lazy
    def _pins(self) -> list[Pin]:
        model = self._model
        return find_pins(model.tree, model.plan, model.description.closures)

    def _accelerations(self, state: ClosedState, ddu: ArrayLike | None) -> Array:
        if ddu is None:
            return np.zeros_like(state.u)
        return self._closure.vector_like(state, "ddu", ddu)

    def _evaluate_with(
        self,
        key: str,
        program: LoadedProgram,
        state: ClosedState,
        loads: Loads | None,
        **vector: ArrayLike,
    ) -> dict[str, Array]:
        """Run a program on a state with one vector over the active coordinates."""
        if loads is None and self._closure.owns_one(state):
            values = self.programs.one_described(key, program, state, vector)
            if values is not None:
                return values
        ((name, value),) = vector.items()
        checked = self._closure.vector_like(state, name, value)
        return self._evaluate(key, program, state, loads, **{name: checked})

    def _evaluate(
        self,
        key: str,
        program: LoadedProgram,
        state: ClosedState,
        loads: Loads | None,
        **inputs: Array,
    ) -> dict[str, Array]:
        """Run a program on a state; rows that did not close stay NaN."""
        self._closure.check_state(state)
        if loads is None:
            loads = self.programs.described
        rows = len(state.u) if state.u.ndim == 2 else None
        pattern, values_of_loads = self.programs.pack(loads, rows)
        kernel, names = self.programs.kernel(key, program, pattern)
        inputs |= values_of_loads
        inputs |= {"u": state.u, "du": state.du, "branch": state.signs, "guess": state.s}
        inputs["gravity"] = loads.gravity
        values, codes = kernel(*[inputs[name] for name in names])
        if any_failed(codes):
            singular = np.asarray(codes == MASS_SINGULAR)
            if singular.any():
                raise self._mass_singularity(state, singular, inputs["tau"], loads)
            mark_open_rows(state, values, codes)
        return values

    def _mass_singularity(
        self, state: ClosedState, singular: NDArray[np.bool_], tau: Array, loads: Loads
    ) -> MassSingularityError:
        """The error for the first state at which M-bar is singular."""
        mass, _, _ = self.minimal_form(state, loads)
        forces = tau - self.inverse_dynamics(state, np.zeros_like(tau), loads)
        return mass_singularity(mass, singular, self._model.active, self._model.idle, forces)
