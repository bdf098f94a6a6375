"""Base parameters, and estimates with the confidence they claim."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import InputError, Parameters, Robot, load
from hybrid_dynamics_core.control import ComputedTorque, JointTrajectory
from hybrid_dynamics_core.dynamics.parameters import described_parameters
from hybrid_dynamics_core.identification import (
    Identification,
    base_parameters,
    identify,
    random_motion,
)
from hybrid_dynamics_core.identification.consistency import consistent, pseudo_inertia
from hybrid_dynamics_core.simulation import Settings, simulate
from tests.mechanisms import changed, describe, random_link
from tests.robots import ROBOTS, robot, scaled
from tests.sampling import examples, swept

FRICTION = {
    "viscous": [30.0, 500.0, 300.0, 3.0],
    "coulomb": [20.0, 300.0, 200.0, 2.0],
}
# Ten parameters each: a body, and one a little off its link's origin.
BODY = [1.0, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.1, 0.0, 0.1]
ROD = [2.0, 0.0, 0.0, 0.2, 0.05, 0.0, 0.0, 0.06, 0.0, 0.05]


def root_mean_square(values: np.ndarray) -> np.ndarray:
    """Of each column."""
    return np.sqrt((values**2).mean(axis=0))


def inside(values: np.ndarray, result: Identification) -> np.ndarray:
    """Which values lie within their intervals."""
    low, high = result.interval.T
    return (values > low) & (values < high)


def is_physical(values: np.ndarray) -> bool:
    """Whether some body has ten parameters."""
    return bool(np.linalg.eigvalsh(pseudo_inertia(values))[0] > 0.0)


@pytest.mark.parametrize("name", swept(ROBOTS, ("delta", "forging_chu2020")))
class TestBaseParameters:
    def test_they_give_tau_like_all_parameters(self, name: str) -> None:
        """On states and for parameters they were not found with."""
        machine = robot(name)
        base = base_parameters(machine)
        state, ddu = random_motion(machine, 10, seed=99)
        regressor = machine.regressor(state, ddu)
        count = len(base.parameters.names)
        values = np.random.default_rng(5).uniform(-1, 1, count)
        efforts = regressor @ values
        by_base = regressor[..., base.kept] @ base.values(values)
        size = np.abs(regressor) @ np.abs(values)
        assert scaled(by_base - efforts, size) < 1e-7

    def test_none_is_a_combination_of_the_others(self, name: str) -> None:
        machine = robot(name)
        base = base_parameters(machine)
        assert np.isfinite(base.condition)
        leads = base.combine[:, base.kept]
        assert leads == pytest.approx(np.eye(base.size))
        rank = np.linalg.matrix_rank(base.combine)
        assert len(base.names) == base.size == rank


def test_base_parameters_of_a_plane_arm_are_the_six_of_the_literature() -> None:
    """Two links in a vertical plane, the second joint at 0.5 m: a textbook example."""
    rows = [
        ("a", "revolute", "base", "l1", (0, 0, 0), "y"),
        ("b", "revolute", "l1", "l2", (0.5, 0, 0), "y"),
    ]
    description = describe("plane_arm", rows, [], ["a", "b"], {})
    base = base_parameters(Robot(description))
    by_hand = [
        {"l1.Jyy": 1, "l2.m": 0.25},
        {"l1.mx": 1, "l2.m": 0.5},
        {"l1.mz": 1},
        {"l2.Jyy": 1},
        {"l2.mx": 1},
        {"l2.mz": 1},
    ]
    names = base.parameters.names
    span = np.zeros((6, len(names)))
    for row, parts in zip(span, by_hand, strict=True):
        for name, factor in parts.items():
            row[names.index(name)] = factor
    assert base.size == 6
    both = np.vstack([base.combine, span])
    assert np.linalg.matrix_rank(both, tol=1e-9) == 6  # the same space


def noisy(machine: Robot, count: int, noise: float, seed: int) -> tuple:
    """Motion and efforts of the forging robot with friction, with `noise` of the efforts' size."""
    state, ddu = random_motion(machine, count, seed)
    size = len(machine.coordinates)
    effects = {kind: np.pad(values, (0, size - 4)) for kind, values in FRICTION.items()}
    truth = machine.loads.with_effects(smoothing=np.full(size, 0.01), **effects)
    tau = machine.inverse_dynamics(state, ddu, truth)
    deviation = noise * root_mean_square(tau)
    errors = np.random.default_rng(seed + 1).normal(size=tau.shape)
    return state, ddu, tau + deviation * errors, truth


def parameters_of(machine: Robot) -> Parameters:
    links = described_parameters(machine.description).links
    return Parameters(links, machine.active, machine.active)


def estimated(
    machine: Robot, count: int, noise: float, seed: int
) -> tuple[Identification, np.ndarray]:
    """The estimate, from a description with other masses and no friction, and the true values."""
    state, ddu, tau, truth = noisy(machine, count, noise, seed)
    rng = np.random.default_rng(3)
    links = dict(machine.description.links)
    for name, link in links.items():
        if link.mass:
            links[name] = random_link(name, rng, 0.2)
    wrong = changed(machine, links=MappingProxyType(links))
    loads = wrong.loads.with_effects(smoothing=truth.effects.smoothing)
    measured = wrong.close(state.u, state.du)
    parameters = parameters_of(machine)
    result = identify(wrong, measured, ddu, tau, parameters, loads)
    return result, parameters.values(machine.description, truth.effects)


class TestEstimate:
    def test_without_noise_the_truth_comes_back(self, forging: Robot) -> None:
        result, truth = estimated(forging, 200, 0.0, 1)
        expected = result.base.values(truth)
        rounding = 1e-7 * np.abs(expected).max()
        assert result.estimate == pytest.approx(expected, abs=rounding)
        assert (result.explained > 1 - 1e-12).all()

    @pytest.mark.sweep(sample="test_without_noise_the_truth_comes_back")
    def test_intervals_hold_the_truth_as_often_as_they_say(self, forging: Robot) -> None:
        """51 base parameters, 6 data sets: 95 % of 306 intervals, give or take four deviations."""
        held = []
        for seed in range(6):
            result, truth = estimated(forging, 150, 0.02, 10 * seed)
            expected = result.base.values(truth)
            held.append(inside(expected, result))
        assert 0.90 < np.mean(held) < 1.0

    def test_noise_of_each_joint_is_estimated(self, forging: Robot) -> None:
        result, _ = estimated(forging, 400, 0.02, 2)
        _, _, tau, _ = noisy(forging, 400, 0.0, 2)
        assert result.noise == pytest.approx(0.02 * root_mean_square(tau), rel=0.15)

    def test_estimates_are_physical_however_poor_the_data(self, forging: Robot) -> None:
        """Plain least squares are not: some base parameters alone belong to no body."""
        result, _ = estimated(forging, 20, 0.3, 3)
        inertial = result.parameters.inertial_size
        for body in result.values[:inertial].reshape(-1, 10):
            assert is_physical(body)
        assert (result.values[inertial:] > 0.0).all()
        assert not (result.estimate[-8:] > 0.0).all()  # friction

    def test_physical_values_predict_new_motion(self, forging: Robot) -> None:
        result, _ = estimated(forging, 300, 0.01, 4)
        estimated_robot = Robot(result.described(forging.description))
        state, ddu, tau, truth = noisy(forging, 100, 0.0, 77)
        loads = estimated_robot.loads.with_effects(smoothing=truth.effects.smoothing)
        closed = estimated_robot.close(state.u, state.du)
        predicted = estimated_robot.inverse_dynamics(closed, ddu, loads)
        error = root_mean_square(predicted - tau)
        assert (error < 0.02 * root_mean_square(tau)).all()

    def test_table_names_the_estimates(self, forging: Robot) -> None:
        result, _ = estimated(forging, 200, 0.01, 5)
        table = result.table()
        value, low, high = table["q12.viscous"]
        assert low < value < high
        assert low < 500.0 < high
        assert len(table) == result.base.size

    @pytest.mark.sweep(sample="test_without_noise_the_truth_comes_back")
    def test_from_a_simulated_log(self) -> None:
        """An excavator under computed torque with friction, logged at 100 Hz with noise."""
        excavator = load("excavator")
        n, size = 4, len(excavator.coordinates)
        friction = np.array([3000.0, 20000.0, 8000.0, 5000.0])
        viscous = np.pad(friction, (0, size - n))
        truth = excavator.loads.with_effects(viscous=viscous)
        rng = np.random.default_rng(0)
        times = np.linspace(0.0, 12.0, 13)
        steps = rng.uniform(-1, 1, (13, 4)) * [0.6, 0.2, 0.2, 0.2]
        points = excavator.reference + steps
        points[0] = excavator.reference
        path = JointTrajectory(times, points)
        follow = ComputedTorque(excavator, path, 100.0, 20.0, truth)
        log = simulate(
            excavator,
            excavator.reference,
            None,
            follow,
            (0.0, 12.0),
            Settings(loads=truth, rtol=1e-7),
        )
        assert log.completed
        deviation = 0.01 * log.tau.std(axis=0)
        tau = log.tau + deviation * rng.normal(size=log.tau.shape)
        links = described_parameters(excavator.description).links
        parameters = Parameters(links, excavator.active)
        result = identify(excavator, log.state, log.ddu, tau, parameters)
        values = parameters.values(excavator.description, truth.effects)
        expected = result.base.values(values)
        assert inside(expected, result).mean() > 0.85
        assert result.values[-n:] == pytest.approx(friction, rel=0.05)


class TestBadInput:
    def test_too_short_recordings(self, forging: Robot) -> None:
        state, ddu = random_motion(forging, 5)
        with pytest.raises(InputError, match="20 equations cannot tell 43 base parameters"):
            identify(forging, state, ddu, forging.inverse_dynamics(state, ddu))

    def test_shapes_and_names(self, forging: Robot) -> None:
        state, ddu = random_motion(forging, 20)
        one = forging.close(forging.reference)
        with pytest.raises(InputError, match="batch"):
            identify(forging, one, np.zeros(4), np.zeros(4))
        with pytest.raises(InputError, match="tau has shape"):
            identify(forging, state, ddu, np.zeros((20, 3)))
        with pytest.raises(InputError, match="no moving link 'base'"):
            base_parameters(forging, Parameters(("base",)))
        with pytest.raises(InputError, match="no joint 'q99'"):
            base_parameters(forging, Parameters((), ("q99",)))

    def test_rows_that_are_no_measurements_are_named(self, forging: Robot) -> None:
        state, ddu = random_motion(forging, 20)
        tau = forging.inverse_dynamics(state, ddu)
        for name, values in (("tau", tau), ("ddu", ddu)):
            for bad in (np.nan, np.inf):
                spoilt = values.copy()
                spoilt[7, 2] = bad
                arguments = {"tau": tau, "ddu": ddu} | {name: spoilt}
                with pytest.raises(
                    InputError, match=rf"{name}: q22 in row 7 is {bad}; expected finite numbers"
                ):
                    identify(forging, state, arguments["ddu"], arguments["tau"])
        u = state.u.copy()
        u[3] = [0, 0.9, 0.1, 0]
        u[12] = [0, 0.7, 0.1, 0]
        torn = forging.close(u, state.du, check=False)
        with pytest.raises(
            InputError, match=r"2 of 20 states do not close, row 3 the first \(unreachable\)"
        ):
            identify(forging, torn, ddu, tau)

    def test_motion_that_shows_nothing_is_refused(self, forging: Robot) -> None:
        """The same sample thirty times: many equations, four of them independent."""
        state, ddu = random_motion(forging, 1)
        u, du = np.tile(state.u, (30, 1)), np.tile(state.du, (30, 1))
        repeated = forging.close(u, du)
        ddu = np.tile(ddu, (30, 1))
        with pytest.raises(InputError, match="shows 4 of 43 base parameters"):
            identify(forging, repeated, ddu, forging.inverse_dynamics(repeated, ddu))


class TestConsistency:
    def test_pseudo_inertia_is_of_the_body(self) -> None:
        """Sum over point masses of m [c; 1][c; 1]^T."""
        rng = np.random.default_rng(0)
        points = rng.normal(size=(5, 3))
        masses = rng.uniform(1, 2, 5)
        ones = np.hstack([points, np.ones((5, 1))])
        inertia = np.zeros((3, 3))
        for mass, c in zip(masses, points, strict=True):
            inertia += mass * (c @ c * np.eye(3) - np.outer(c, c))
        first_moment = masses @ points
        values = np.array([masses.sum(), *first_moment, *inertia[np.triu_indices(3)]])
        expected = ones.T @ (masses[:, None] * ones)
        assert pseudo_inertia(values) == pytest.approx(expected, rel=1e-12)

    def test_physical_measurements_stay(self) -> None:
        body = np.array([2.0, 0.1, 0.0, 0.2, 0.3, 0.01, 0.0, 0.3, 0.0, 0.2])
        prior = np.array(BODY)
        result = consistent(1e3 * np.eye(10), 1e3 * body, prior, 1, 1e-3)
        assert result == pytest.approx(body, abs=1e-6)

    @pytest.mark.parametrize("size", [1e-8, 1e-3])
    def test_they_stay_however_small_the_body(self, size: float) -> None:
        body = size * np.array([2.0, 0.1, 0.0, 0.2, 0.3, 0.01, 0.0, 0.3, 0.0, 0.2])
        result = consistent(1e3 / size * np.eye(10), 1e3 / size * body, np.array(BODY), 1, 1e-3)
        assert result == pytest.approx(body, abs=1e-6 * size)

    def test_impossible_measurements_go_to_the_nearest_body(self) -> None:
        """A negative mass and a triangle inequality broken by measurement."""
        prior = np.array(BODY)
        target = np.array([-1.0, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.1, 0.0, 0.9])
        result = consistent(10.0 * np.eye(10), 10.0 * target, prior, 1, 1e-4)
        assert is_physical(result)
        assert result[0] == pytest.approx(0.0, abs=1e-2)
        assert result[4] + result[7] == pytest.approx(result[9], abs=1e-2)  # on the border

    def test_what_is_not_measured_stays_at_the_prior(self) -> None:
        prior = np.array([1.0, 0.1, 0.0, 0.0, 0.1, 0.0, 0.0, 0.1, 0.0, 0.1, 4.0])
        row = np.zeros((1, 11))
        row[0, 10] = 1.0
        result = consistent(row, np.array([7.0]), prior, 1, 1e-6)
        assert result[:10] == pytest.approx(prior[:10], rel=1e-9)
        assert result[10] == pytest.approx(7.0, rel=1e-4)

    @examples(60)
    @given(st.integers(0, 2**32 - 1), st.integers(5, 24), st.integers(0, 7))
    def test_bodies_stay_physical_however_sharp_the_measurements(
        self, seed: int, rank: int, sharpness: int
    ) -> None:
        """Masses and inertias of no body, weighted by up to 1e7: the prior is never better."""
        rng = np.random.default_rng(seed)
        prior = np.tile(ROD, 3)
        tall = 10.0**sharpness * rng.normal(size=(200, rank))
        matrix = tall @ rng.normal(size=(rank, 30))
        target = matrix @ (prior * (1 + 0.5 * rng.normal(size=30)))
        result = consistent(matrix, target, prior, 3, 1e-3)
        for body in result.reshape(3, 10):
            assert is_physical(body)
        error = np.linalg.norm(matrix @ result - target)
        assert error <= np.linalg.norm(matrix @ prior - target)

    @pytest.mark.parametrize("weight", [1e-3, 1e-7])
    @pytest.mark.parametrize("noise", [0.0, 3.0, 30.0, 300.0])
    def test_nothing_near_by_costs_less(self, noise: float, weight: float) -> None:
        """The problem is convex: a local minimum is the minimum.

        From 30 on the best fit is no body.
        """
        rng = np.random.default_rng(0)
        prior = np.tile(ROD, 3)
        tall = 10.0 * rng.normal(size=(40, 24))
        matrix = tall @ rng.normal(size=(24, 30))
        heavier = prior * np.where(np.arange(30) == 0, 1.3, 1.0)
        target = matrix @ heavier + noise * rng.normal(size=40)
        at_prior = np.linalg.inv(pseudo_inertia(prior[:10]))

        def cost(values: np.ndarray) -> float:
            divergence = 0.0
            for body in values.reshape(3, 10):
                ratio = at_prior @ pseudo_inertia(body)
                divergence += np.trace(ratio) - np.linalg.slogdet(ratio)[1]
            misfit = np.square(matrix @ values - target).sum()
            return float(0.5 * misfit + weight * divergence)

        result = consistent(matrix, target, prior, 3, weight)
        least = cost(result)
        # Newton's decrement, of which half may be gained, is below 1e-6 of the weight, or 1e-5 of
        # the misfit.
        slack = 1e-5 * max(weight, least)
        for size in (1e-2, 1e-4, 1e-6):
            for direction in rng.normal(size=(50, 30)):
                other = result + size * direction
                physical = all(map(is_physical, other.reshape(3, 10)))
                assert not physical or cost(other) >= least - slack
