"""Base parameters, and estimates with the confidence they claim."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np
import pytest
from hypothesis import given, settings
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

FRICTION = {"viscous": [30.0, 500.0, 300.0, 3.0], "coulomb": [20.0, 300.0, 200.0, 2.0]}


@pytest.mark.parametrize("name", ROBOTS)
class TestBaseParameters:
    def test_they_give_tau_like_all_parameters(self, name: str) -> None:
        """On states and for parameters they were not found with."""
        machine = robot(name)
        base = base_parameters(machine)
        state, ddu = random_motion(machine, 10, seed=99)
        regressor = machine.regressor(state, ddu)
        values = np.random.default_rng(5).uniform(-1, 1, len(base.parameters.names))
        whole = regressor @ values
        assert (
            scaled(
                regressor[..., base.kept] @ base.values(values) - whole,
                np.abs(regressor) @ np.abs(values),
            )
            < 1e-7
        )

    def test_none_is_a_combination_of_the_others(self, name: str) -> None:
        machine = robot(name)
        base = base_parameters(machine)
        assert np.isfinite(base.condition)
        assert base.combine[:, base.kept] == pytest.approx(np.eye(base.size))
        assert len(base.names) == base.size == np.linalg.matrix_rank(base.combine)


def test_base_parameters_of_a_plane_arm_are_the_known_six() -> None:
    """Two links in a vertical plane, the second joint at 0.5 m.

    What every textbook finds by hand.
    """
    rows = [
        ("a", "revolute", "base", "l1", (0, 0, 0), "y"),
        ("b", "revolute", "l1", "l2", (0.5, 0, 0), "y"),
    ]
    base = base_parameters(Robot(describe("plane_arm", rows, [], ["a", "b"], {})))
    by_hand = [{"l1.Jyy": 1, "l2.m": 0.25}, {"l1.mx": 1, "l2.m": 0.5}]
    by_hand += [{name: 1} for name in ("l1.mz", "l2.Jyy", "l2.mx", "l2.mz")]
    span = np.array([[parts.get(name, 0.0) for name in base.parameters.names] for parts in by_hand])
    assert base.size == 6
    assert np.linalg.matrix_rank(np.vstack([base.combine, span]), tol=1e-9) == 6  # the same space


def noisy(machine: Robot, count: int, noise: float, seed: int) -> tuple:
    """Motion and efforts of the forging robot with friction, measured with `noise` of the efforts'
    size.
    """
    state, ddu = random_motion(machine, count, seed)
    size = len(machine.coordinates)
    effects = {kind: np.pad(values, (0, size - 4)) for kind, values in FRICTION.items()}
    truth = machine.loads.with_effects(smoothing=np.full(size, 0.01), **effects)
    tau = machine.inverse_dynamics(state, ddu, truth)
    deviation = noise * np.sqrt((tau**2).mean(axis=0))
    return (
        state,
        ddu,
        tau + deviation * np.random.default_rng(seed + 1).normal(size=tau.shape),
        truth,
    )


def parameters_of(machine: Robot) -> Parameters:
    return Parameters(
        described_parameters(machine.description).links, machine.active, machine.active
    )


def estimated(
    machine: Robot, count: int, noise: float, seed: int
) -> tuple[Identification, np.ndarray]:
    """The estimate, from a description with other masses and no friction, and the true values."""
    state, ddu, tau, truth = noisy(machine, count, noise, seed)
    rng = np.random.default_rng(3)
    links = {
        name: random_link(name, rng, 0.2) if link.mass else link
        for name, link in machine.description.links.items()
    }
    wrong = changed(machine, links=MappingProxyType(links))
    known = wrong.loads.with_effects(smoothing=truth.effects.smoothing)
    found = identify(wrong, wrong.close(state.u, state.du), ddu, tau, parameters_of(machine), known)
    return found, parameters_of(machine).values(machine.description, truth.effects)


class TestEstimate:
    def test_without_noise_the_truth_comes_back(self, forging: Robot) -> None:
        found, truth = estimated(forging, 200, 0.0, 1)
        expected = found.base.values(truth)
        assert found.estimate == pytest.approx(expected, abs=1e-7 * np.abs(expected).max())
        assert (found.explained > 1 - 1e-12).all()

    def test_intervals_hold_the_truth_as_often_as_they_say(self, forging: Robot) -> None:
        """51 base parameters, 6 data sets: 95 % of 306 intervals, give or take four deviations."""
        inside = []
        for seed in range(6):
            found, truth = estimated(forging, 150, 0.02, 10 * seed)
            expected = found.base.values(truth)
            inside.append((expected > found.interval[:, 0]) & (expected < found.interval[:, 1]))
        assert 0.90 < np.mean(inside) < 1.0

    def test_noise_of_each_joint_is_told(self, forging: Robot) -> None:
        found, _ = estimated(forging, 400, 0.02, 2)
        _, _, tau, _ = noisy(forging, 400, 0.0, 2)
        assert found.noise == pytest.approx(0.02 * np.sqrt((tau**2).mean(axis=0)), rel=0.15)

    def test_estimates_are_physical_however_poor_the_data(self, forging: Robot) -> None:
        """Plain least squares are not: some base parameters alone belong to no body."""
        found, _ = estimated(forging, 20, 0.3, 3)
        for k in range(len(found.parameters.links)):
            assert np.linalg.eigvalsh(pseudo_inertia(found.values[10 * k : 10 * k + 10]))[0] > 0.0
        assert (found.values[found.parameters.inertial_size :] > 0.0).all()
        assert not (found.estimate[-8:] > 0.0).all()  # friction

    def test_physical_values_predict_new_motion(self, forging: Robot) -> None:
        found, _ = estimated(forging, 300, 0.01, 4)
        again = Robot(found.described(forging.description))
        state, ddu, tau, truth = noisy(forging, 100, 0.0, 77)
        loads = again.loads.with_effects(smoothing=truth.effects.smoothing)
        predicted = again.inverse_dynamics(again.close(state.u, state.du), ddu, loads)
        error = np.sqrt(((predicted - tau) ** 2).mean(axis=0))
        assert (error < 0.02 * np.sqrt((tau**2).mean(axis=0))).all()

    def test_table_names_what_was_found(self, forging: Robot) -> None:
        found, _ = estimated(forging, 200, 0.01, 5)
        table = found.table()
        value, low, high = table["q12.viscous"]
        assert low < value < high
        assert low < 500.0 < high
        assert len(table) == found.base.size

    def test_from_a_simulated_log(self) -> None:
        """An excavator under computed torque with friction, logged at 100 Hz with noise."""
        excavator = load("excavator")
        n, size = 4, len(excavator.coordinates)
        friction = np.array([3000.0, 20000.0, 8000.0, 5000.0])
        truth = excavator.loads.with_effects(viscous=np.pad(friction, (0, size - n)))
        rng = np.random.default_rng(0)
        times = np.linspace(0.0, 12.0, 13)
        points = excavator.reference + rng.uniform(-1, 1, (13, 4)) * [0.6, 0.2, 0.2, 0.2]
        points[0] = excavator.reference
        follow = ComputedTorque(excavator, JointTrajectory(times, points), 100.0, 20.0, truth)
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
        parameters = Parameters(described_parameters(excavator.description).links, excavator.active)
        found = identify(excavator, log.state, log.ddu, tau, parameters)
        expected = found.base.values(parameters.values(excavator.description, truth.effects))
        inside = (expected > found.interval[:, 0]) & (expected < found.interval[:, 1])
        assert inside.mean() > 0.85
        assert found.values[-n:] == pytest.approx(friction, rel=0.05)


class TestBadInput:
    def test_too_few_samples(self, forging: Robot) -> None:
        state, ddu = random_motion(forging, 5)
        with pytest.raises(InputError, match="20 equations cannot tell 43 base parameters"):
            identify(forging, state, ddu, forging.inverse_dynamics(state, ddu))

    def test_shapes_and_names(self, forging: Robot) -> None:
        state, ddu = random_motion(forging, 20)
        with pytest.raises(InputError, match="batch"):
            identify(forging, forging.close(forging.reference), np.zeros(4), np.zeros(4))
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
                told = {"tau": tau, "ddu": ddu} | {name: spoilt}
                with pytest.raises(
                    InputError, match=rf"{name}: q22 in row 7 is {bad}; expected finite numbers"
                ):
                    identify(forging, state, told["ddu"], told["tau"])
        u = state.u.copy()
        u[3], u[12] = [0, 0.9, 0.1, 0], [0, 0.7, 0.1, 0]
        torn = forging.close(u, state.du, check=False)
        with pytest.raises(
            InputError, match=r"2 of 20 states do not close, row 3 the first \(unreachable\)"
        ):
            identify(forging, torn, ddu, tau)

    def test_motion_that_shows_nothing_is_refused(self, forging: Robot) -> None:
        """The same sample many times over.

        As many equations as one likes, four of them independent.
        """
        state, ddu = random_motion(forging, 1)
        many = forging.close(np.tile(state.u, (30, 1)), np.tile(state.du, (30, 1)))
        ddu = np.tile(ddu, (30, 1))
        with pytest.raises(InputError, match="shows 4 of 43 base parameters"):
            identify(forging, many, ddu, forging.inverse_dynamics(many, ddu))


class TestConsistency:
    def test_pseudo_inertia_is_of_the_body(self) -> None:
        """Sum over point masses of m [c; 1][c; 1]^T."""
        rng = np.random.default_rng(0)
        points, masses = rng.normal(size=(5, 3)), rng.uniform(1, 2, 5)
        ones = np.hstack([points, np.ones((5, 1))])
        about = sum(
            m * (c @ c * np.eye(3) - np.outer(c, c)) for m, c in zip(masses, points, strict=True)
        )
        values = np.array([masses.sum(), *(masses @ points), *about[np.triu_indices(3)]])
        assert pseudo_inertia(values) == pytest.approx(ones.T @ (masses[:, None] * ones), rel=1e-12)

    def test_physical_measurements_are_kept(self) -> None:
        body = np.array([2.0, 0.1, 0.0, 0.2, 0.3, 0.01, 0.0, 0.3, 0.0, 0.2])
        prior = np.array([1.0, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.1, 0.0, 0.1])
        found = consistent(1e3 * np.eye(10), 1e3 * body, prior, 1, 1e-3)
        assert found == pytest.approx(body, abs=1e-6)

    def test_impossible_measurements_go_to_the_nearest_body(self) -> None:
        """A negative mass and a triangle inequality broken by measurement."""
        prior = np.array([1.0, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.1, 0.0, 0.1])
        target = np.array([-1.0, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.1, 0.0, 0.9])
        found = consistent(10.0 * np.eye(10), 10.0 * target, prior, 1, 1e-4)
        assert np.linalg.eigvalsh(pseudo_inertia(found))[0] > 0.0
        assert found[0] == pytest.approx(0.0, abs=1e-2)
        assert found[4] + found[7] == pytest.approx(found[9], abs=1e-2)  # on the border

    def test_what_is_not_measured_stays_at_the_prior(self) -> None:
        prior = np.array([1.0, 0.1, 0.0, 0.0, 0.1, 0.0, 0.0, 0.1, 0.0, 0.1, 4.0])
        row = np.zeros((1, 11))
        row[0, 10] = 1.0
        found = consistent(row, np.array([7.0]), prior, 1, 1e-6)
        assert found[:10] == pytest.approx(prior[:10], rel=1e-9)
        assert found[10] == pytest.approx(7.0, rel=1e-4)

    @settings(deadline=None, max_examples=60)
    @given(st.integers(0, 2**32 - 1), st.integers(5, 24), st.integers(0, 7))
    def test_bodies_stay_physical_however_sharp_the_measurements(
        self, seed: int, rank: int, sharpness: int
    ) -> None:
        """Of masses and inertias that no body has, weighted by up to 1e7.

        The prior is never better.
        """
        rng = np.random.default_rng(seed)
        prior = np.tile([2.0, 0.0, 0.0, 0.2, 0.05, 0.0, 0.0, 0.06, 0.0, 0.05], 3)
        matrix = 10.0**sharpness * rng.normal(size=(200, rank)) @ rng.normal(size=(rank, 30))
        target = matrix @ (prior * (1 + 0.5 * rng.normal(size=30)))
        found = consistent(matrix, target, prior, 3, 1e-3)
        for body in found.reshape(3, 10):
            assert np.linalg.eigvalsh(pseudo_inertia(body))[0] > 0.0
        assert np.linalg.norm(matrix @ found - target) <= np.linalg.norm(matrix @ prior - target)

    @pytest.mark.parametrize("noise", [0.0, 3.0, 30.0, 300.0])
    def test_nothing_near_by_costs_less(self, noise: float) -> None:
        """The problem is convex: a local minimum is the minimum.

        From 30 on the best fit is no body.
        """
        rng = np.random.default_rng(0)
        prior = np.tile([2.0, 0.0, 0.0, 0.2, 0.05, 0.0, 0.0, 0.06, 0.0, 0.05], 3)
        matrix = 10.0 * rng.normal(size=(40, 24)) @ rng.normal(size=(24, 30))
        target = matrix @ (prior * np.where(np.arange(30) == 0, 1.3, 1.0)) + noise * rng.normal(
            size=40
        )
        at_prior = np.linalg.inv(pseudo_inertia(prior[:10]))

        def cost(values: np.ndarray) -> float:
            ratios = [at_prior @ pseudo_inertia(body) for body in values.reshape(3, 10)]
            divergence = sum(np.trace(r) - np.linalg.slogdet(r)[1] for r in ratios)
            return float(0.5 * np.square(matrix @ values - target).sum() + 1e-3 * divergence)

        found = consistent(matrix, target, prior, 3, 1e-3)
        least = cost(found)
        # Newton's decrement, half of it what is left to gain, is below 1e-6 of the weight, or 1e-5
        # of the misfit
        slack = 1e-5 * max(1e-3, least)
        for size in (1e-2, 1e-4, 1e-6):
            for direction in rng.normal(size=(50, 30)):
                step = size * direction
                physical = all(
                    np.linalg.eigvalsh(pseudo_inertia(b))[0] > 0.0
                    for b in (found + step).reshape(3, 10)
                )
                assert not physical or cost(found + step) >= least - slack
