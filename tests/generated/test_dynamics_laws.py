"""Laws of the dynamics, on robots and states nobody has seen, with everything acting that can act.

Tolerances: R is good to 1e-13 / margin^2 and R' to 1e-13 / margin^3, where the margin is the
smallest singular value of the passive Jacobian (at least 0.01 here, see test_closure_laws),
relative to terms that may cancel; differences say their own.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from hypothesis import assume, given

from hybrid_dynamics_core import ClosedState, Loads
from hybrid_dynamics_core.dynamics.parameters import described_parameters
from hybrid_dynamics_core.simulation import Settings, simulate
from tests.generated.case import Case
from tests.generated.class_three import class_three
from tests.generated.robots import STATES, examples, robots
from tests.laws.test_loads import heavy_loads
from tests.robots import scaled

# step of central differences of fourth order: they leave H^4 of the fifth derivative, and 1e-12 of
# rounding
H = 1e-4


def at(case: Case, seed: int) -> ClosedState:
    """A closed state, in motion."""
    return case.robot.close(case.somewhere(seed)[: case.n], case.rates(seed))


def efforts(case: Case, seed: int) -> np.ndarray:
    """Random efforts of the size of the weights."""
    return 30.0 * case.rates(seed + 50)


def slope(function: Callable[[float], np.ndarray]) -> tuple[np.ndarray, float]:
    """The derivative at 0, by differences of fourth order, and how far two steps of it disagree."""
    fine, coarse = (
        (8.0 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12.0 * h)
        for f in (function,)
        for h in (H, 2 * H)
    )
    return fine, float(np.abs(fine - coarse).max(initial=0.0))


@examples(8)
@given(robots(), STATES)
def test_inverse_of_forward_dynamics(case: Case, seed: int) -> None:
    state, tau = at(case, seed), efforts(case, seed)
    for loads in (case.robot.loads, heavy_loads(case.robot)):
        again = case.robot.inverse_dynamics(
            state, case.robot.forward_dynamics(state, tau, loads), loads
        )
        rest = case.robot.inverse_dynamics(state, np.zeros(case.n), loads)
        assert scaled(again - tau, tau, rest) < 1e-9


@examples(8)
@given(robots(), STATES)
def test_mass_matrix_is_positive_definite_and_its_rate_less_twice_coriolis_skew(
    case: Case, seed: int
) -> None:
    state, robot = at(case, seed), case.robot
    mass, bias, _ = robot.minimal_form(state)
    assert np.array_equal(mass, mass.T)
    assert np.linalg.eigvalsh(mass)[0] > 0.0
    matrix = robot.coriolis_matrix(state)
    assert (
        scaled(matrix @ state.du - bias, np.abs(matrix) @ np.abs(state.du), bias, np.ones(1))
        < 1e-10
    )

    def later(t: float) -> np.ndarray:
        return robot.minimal_form(robot.close(state.u + t * state.du, near=state))[0]

    rate, unsure = slope(later)
    twist = rate - 2.0 * matrix
    assert np.abs(twist + twist.T).max() < 2.0 * unsure + 1e-9 * np.abs(mass).max()
    power = abs(state.du @ twist @ state.du)
    largest = max(np.abs(a).max() for a in (mass, rate, matrix))
    assert power < 1e-6 * largest + unsure * np.abs(state.du).sum() ** 2


@examples(8)
@given(robots(), STATES)
def test_regressor_times_parameters_is_tau(case: Case, seed: int) -> None:
    state, ddu = at(case, seed), case.rates(seed + 1)
    parameters = described_parameters(case.description)
    terms = case.robot.regressor(state, ddu, parameters) * parameters.values(case.description)
    tau = case.robot.inverse_dynamics(state, ddu)
    assert scaled(terms.sum(axis=1) - tau, np.abs(terms).sum(axis=1)) < 1e-10


@examples(4)
@given(class_three(max_links=2, max_loops=2), STATES)
def test_derivatives_are_those_of_differences(case: Case, seed: int) -> None:
    """Along one random direction of u and one of u', with all loads.

    D/du'' and d/d tau are M-bar and its inverse.
    """
    robot, state, loads = case.robot, at(case, seed), heavy_loads(case.robot)
    way, ddu, tau = case.rates(seed + 1), case.rates(seed + 2), efforts(case, seed)
    for function, exact, given_one in (
        (robot.inverse_dynamics, robot.inverse_dynamics_derivatives, ddu),
        (robot.forward_dynamics, robot.forward_dynamics_derivatives, tau),
    ):
        d_u, d_du, d_last = exact(state, given_one, loads)

        def moved(t: float, f: Callable = function, last: np.ndarray = given_one) -> np.ndarray:
            return f(robot.close(state.u + t * way, state.du, near=state), last, loads)

        def hurried(t: float, f: Callable = function, last: np.ndarray = given_one) -> np.ndarray:
            return f(robot.close(state.u, state.du + t * way, near=state), last, loads)

        size = max(1.0, float(np.abs(moved(0.0)).max()))
        for matrix, motion in ((d_u, moved), (d_du, hurried)):
            rate, unsure = slope(motion)
            assert np.abs(matrix @ way - rate).max() < unsure + 1e-8 * max(size, np.abs(rate).max())
        mass = robot.minimal_form(state, loads)[0]
        expected = mass if function == robot.inverse_dynamics else np.linalg.inv(mass)
        assert scaled(d_last - expected, expected) < 1e-8


@examples(8)
@given(robots(), STATES)
def test_energy_changes_by_the_power_put_in(case: Case, seed: int) -> None:
    """At a random acceleration.

    Tau' u' less friction, plus that of the wrenches, told apart by leaving them out.
    """
    robot, state, ddu = case.robot, at(case, seed), case.rates(seed + 1)
    loads = heavy_loads(robot)

    def energy(t: float) -> np.ndarray:
        there = robot.close(
            state.u + t * state.du + 0.5 * t * t * ddu, state.du + t * ddu, near=state
        )
        return np.array([robot.energy(there, loads).total])

    kept = _springs_and_rotors_only(loads)
    power = float(robot.inverse_dynamics(state, ddu, kept) @ state.du)
    rate, unsure = slope(energy)
    size = float(np.abs(energy(0.0)).max())
    assert abs(rate[0] - power) < unsure + 1e-7 * max(1.0, size, abs(power))


def _springs_and_rotors_only(loads: Loads) -> Loads:
    """The same without what takes energy out or brings it in."""
    still = np.zeros_like(loads.effects.viscous)
    return Loads(
        loads.gravity, loads.with_effects(viscous=still, coulomb=still).effects, loads.payloads
    )


@examples(5)
@given(robots(), STATES)
def test_energy_along_a_simulated_motion_is_the_work_done(case: Case, seed: int) -> None:
    """Pushed, loaded and rubbing, as far as it goes in a fifth of a second.

    Loops closed throughout.
    """
    robot, state = case.robot, at(case, seed)
    assume(
        float(state.singularity) > 0.05
    )  # others meet a singular place at once, where a simulation ends
    loads = heavy_loads(robot)
    tau = robot.inverse_dynamics(state, np.zeros(case.n), loads) + efforts(case, seed)
    motion = simulate(
        robot, state.u, 0.3 * state.du, tau, (0.0, 0.2), Settings(loads=loads, rate=200.0)
    )
    assume(len(motion.t) > 5)
    assert abs(motion.work[-1]) > 0.0
    assert motion.relative_energy_error < 1e-6
    assert motion.residual < 1e-10
