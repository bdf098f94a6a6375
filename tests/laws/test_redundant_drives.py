"""More drives than freedoms: together they give the load, within limits and with least effort."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from hybrid_dynamics_core import InputError, Robot, load
from hybrid_dynamics_core.dynamics.distribution import Drives, distribute
from hybrid_dynamics_core.formats.reader import parse_description
from tests.sampling import examples

ROUNDING = 1e-9  # relative, of loads through pseudo-inverses


def random_problem(seed: int, spread: float) -> tuple[np.ndarray, np.ndarray, Drives]:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 4))
    m = n + int(rng.integers(1, 4))
    rates = rng.normal(size=(m, n))
    weight = rng.uniform(0.5, 3.0, size=m)
    lower = np.where(rng.random(m) < 0.3, 0.0, -weight)  # some only pull
    preload = np.clip(rng.normal(size=m) * 0.2, lower, weight)
    return rates, spread * rng.normal(size=n), Drives(lower, weight, weight, preload)


@given(st.integers(0, 100_000))
@examples(200)
def test_forces_are_the_nearest_to_the_preload_that_give_the_load(seed: int) -> None:
    """Against a general optimiser, which knows nothing of null spaces."""
    rates, tau, drives = random_problem(seed, 1.0)
    forces = distribute(rates, tau, drives)
    assert (forces >= drives.lower).all()
    assert (forces <= drives.upper).all()
    missing = tau - rates.T @ forces
    other = minimize(
        lambda f: (((f - drives.preload) / drives.weight) ** 2).sum(),
        np.clip(forces, drives.lower, drives.upper),
        jac=lambda f: 2.0 * (f - drives.preload) / drives.weight**2,
        bounds=list(zip(drives.lower, drives.upper, strict=True)),
        constraints={
            "type": "eq",
            "fun": lambda f: rates.T @ f - tau + missing,
            "jac": lambda _: rates.T,
        },
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 500},
    )
    cost = (((forces - drives.preload) / drives.weight) ** 2).sum()
    assert cost <= other.fun + 1e-6


@given(st.integers(0, 100_000))
@examples(200)
def test_only_what_no_forces_can_give_is_missing(seed: int) -> None:
    """A load of forces within the limits is given whole; of others, none nearer is found."""
    rates, tau, drives = random_problem(seed, 3.0)
    rng = np.random.default_rng(seed)
    possible = rates.T @ rng.uniform(drives.lower, drives.upper)
    assert rates.T @ distribute(rates, possible, drives) == pytest.approx(possible, abs=ROUNDING)
    scale = np.linalg.norm(rates.T * drives.weight, axis=1)
    left = np.linalg.norm((tau - rates.T @ distribute(rates, tau, drives)) / scale)
    for _ in range(50):
        others = rng.uniform(drives.lower, drives.upper)
        assert left <= np.linalg.norm((tau - rates.T @ others) / scale) + ROUNDING


BAR = {"xx": 0.001, "yy": 0.02, "zz": 0.02}
FOUR_BAR: dict[str, Any] = {
    "format": 1,
    "name": "two_motors",
    "links": {
        "crank": {
            "mass": 1.0,
            "com": [0.1, 0, 0],
            "inertia": {"zz": 0.01, "yy": 0.01, "xx": 0.001},
        },
        "rocker": {
            "mass": 2.0,
            "com": [0.2, 0, 0],
            "inertia": {"zz": 0.03, "yy": 0.03, "xx": 0.001},
        },
        "coupler": {
            "mass": 1.5,
            "com": [0.2, 0, 0],
            "inertia": {"zz": 0.02, "yy": 0.02, "xx": 0.001},
        },
    },
    "joints": {
        "a": {
            "type": "revolute",
            "parent": "base",
            "child": "crank",
            "origin": {"rpy": ["pi/2", 0, 0]},
            "axis": "z",
            "effort_limit": 12,
        },
        "b": {
            "type": "revolute",
            "parent": "base",
            "child": "rocker",
            "origin": {"xyz": [0.5, 0, 0], "rpy": ["pi/2", 0, 0]},
            "axis": "z",
            "effort_limit": 30,
        },
        "c": {
            "type": "revolute",
            "parent": "crank",
            "child": "coupler",
            "origin": {"xyz": [0.2, 0, 0]},
            "axis": "z",
        },
    },
    "closures": {
        "pin": {"kind": "planar", "between": {"coupler": [0.5, 0, 0], "rocker": [0.4, 0, 0]}}
    },
    "active": ["a", "b"],
    "active_set": "motors",
    "end_effector": {"link": "coupler"},
    "reference": {"a": 1.0, "b": 1.4},
}


def four_bar() -> Robot:
    return Robot(parse_description(yaml.safe_dump(FOUR_BAR)))


def test_two_motors_on_one_freedom_share_it_by_their_limits() -> None:
    robot = four_bar()
    assert robot.all_drives == ("a", "b")
    assert len(robot.active) == 1
    assert len(robot.dependent_motors) == 1
    state = robot.close(robot.reference)
    rates = state.R[[robot.coordinates.index(name) for name in ("a", "b")], 0]
    tau = np.array([5.0])
    shared = robot.distribute(state, tau)
    forces = np.array([shared.forces["a"], shared.forces["b"]])
    weights = np.array([12.0, 30.0])
    expected = weights**2 * rates * tau / (weights**2 @ rates**2)  # Lagrange
    assert forces == pytest.approx(expected)
    assert shared.is_possible
    assert shared.missing == pytest.approx([0.0], abs=1e-12)
    assert robot.generalised_forces(state, shared.forces) == pytest.approx(tau)


def test_what_is_beyond_all_limits_is_told() -> None:
    robot = four_bar()
    state = robot.close(robot.reference)
    rates = state.R[[robot.coordinates.index(name) for name in ("a", "b")], 0]
    most = np.abs(rates) @ [12.0, 30.0]
    shared = robot.distribute(state, [most + 7.0])
    assert not shared.is_possible
    assert shared.missing == pytest.approx([7.0])
    assert all(shared.at_limit.values())
    batch = robot.close(np.repeat(state.u[None], 3, axis=0))
    several = robot.distribute(batch, [[most + 7.0], [0.9 * most], [1.0]])
    assert several.is_possible.tolist() == [False, True, True]
    assert several.forces["a"].shape == (3,)
    back = robot.generalised_forces(batch, several.forces)
    assert back[1:] == pytest.approx(np.array([[0.9 * most], [1.0]]))


def test_a_preload_stays_in_the_null_space() -> None:
    robot = four_bar()
    state = robot.close(robot.reference)
    plain = robot.distribute(state, [3.0])
    tight = robot.distribute(state, [3.0], preload={"a": 4.0})
    assert tight.forces["a"] != pytest.approx(plain.forces["a"])
    assert robot.generalised_forces(state, tight.forces) == pytest.approx([3.0])
    for wrong, words in (({"c": 1.0}, "no drive 'c'"), ({"a": np.nan}, "not finite")):
        with pytest.raises(InputError, match=words):
            robot.distribute(state, [3.0], preload=wrong)
    with pytest.raises(InputError, match="above zero"):
        robot.distribute(state, [3.0], weights={"a": 0.0})


@pytest.mark.parametrize("name", ["excavator", "forging_chu2020"])
def test_without_redundant_drives_it_is_drive_forces(name: str) -> None:
    robot = load(name)
    state = robot.close(robot.reference)
    tau = 1e-3 * robot.inverse_dynamics(state, np.zeros(state.n))
    single = robot.drive_forces(state, tau)
    shared = robot.distribute(state, tau)
    if shared.forces.keys() == single.keys():
        for drive, force in single.items():
            assert shared.forces[drive] == pytest.approx(force, rel=1e-9, abs=1e-9)
    assert robot.generalised_forces(state, shared.forces) == pytest.approx(tau)


def test_a_state_that_does_not_close_has_no_forces() -> None:
    robot = load("excavator")
    far = robot.reference + np.array([[0, 0, 0, 0], [0, 9, 0, 0]])
    batch = robot.close(far[:, : len(robot.active)], check=False)
    shared = robot.distribute(batch, np.ones(batch.u.shape))
    assert shared.is_possible.tolist() == [True, False]
    assert all(np.isnan(force[1]) for force in shared.forces.values())
