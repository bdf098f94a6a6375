"""Weighing: exact where the model is, honest where it is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.estimation.bounds import mass_bound
from benchmarks.estimation.lifts import machine, recorded
from benchmarks.estimation.weighing import CASES, FULL_SCALE, lift, weighed
from hybrid_dynamics_core import InputError, Payload, load
from hybrid_dynamics_core.control import JointTrajectory
from hybrid_dynamics_core.estimation import (
    MeasuredRun,
    SensorError,
    Tolerances,
    deviation_of,
    estimate_payload,
)
from tests.sampling import examples

EXACT = Tolerances(
    links=1e-6,
    friction=0.0,
    unlisted_friction=1e-6,
    offset=1e-7,
    scale=1e-7,
    noise=1e-6,
    friction_share=0.0,
)
COM = np.array([-0.6, 0.35, 0.0])
POINTS = [[0.0, 0.4, 1.05, 0.85], [0.5, 0.8, 1.0, 0.92], [0.8, 0.8, 0.7, 0.88]]


@pytest.fixture(scope="module")
def excavator():
    return load("excavator")


@pytest.fixture(scope="module")
def motion(excavator):
    """Times, states and accelerations of a lift."""
    time = np.arange(0.0, 6.0, 0.02)
    stops = np.zeros((3, 4))
    goal = JointTrajectory([0.0, 3.0, 6.0], POINTS, stops, stops)(time)
    return time, excavator.close(goal.u, goal.du), goal.ddu


def efforts_of(robot, motion, mass, com=COM):
    _, state, ddu = motion
    tau = robot.inverse_dynamics(state, ddu, robot.loads.with_payload(Payload(mass, com)))
    return {name: tau[..., k] for k, name in enumerate(robot.active) if k}


def run_of(robot, motion, efforts):
    time, state, _ = motion
    positions = {name: state.u[:, k] for k, name in enumerate(robot.active)}
    return MeasuredRun.from_samples(robot, time, positions, efforts)


@examples(16)
@given(mass=st.floats(50.0, 3000.0), x=st.floats(-1.0, 0.5), y=st.floats(-0.5, 0.8))
def test_exact_efforts_give_the_load_and_its_place(excavator, motion, mass, x, y):
    _, state, ddu = motion
    few = (None, state.rows(slice(None, None, 20)), ddu[::20])
    efforts = efforts_of(excavator, few, mass, np.array([x, y, 0.0]))
    run = MeasuredRun.from_state(excavator, *few[1:], efforts)
    estimate = estimate_payload(run, tolerances=EXACT)
    assert estimate.mass == pytest.approx(mass, abs=1e-3 * mass + 0.05)
    assert estimate.com[:2] == pytest.approx([x, y], abs=0.02)


def test_a_lever_is_weighed_as_by_hand(tmp_path):
    """(tau / (g cos q) - m c) / L, with the load at the end of the lever."""
    path = tmp_path / "lever.yaml"
    path.write_text(
        """
format: 1
name: lever
links: {base: {}, arm: {mass: 12, com: [0.4, 0, 0], inertia: {rod: {axis: x, length: 0.8}}}}
joints: {q: {type: revolute, parent: base, child: arm, origin: {rpy: [pi/2, 0, 0]}, axis: z}}
active: [q]
end_effector: {link: arm, xyz: [0.9, 0, 0]}
""",
        encoding="utf-8",
    )
    lever = load(path)
    torque = 9.80665 * np.cos(0.5) * (12.0 * 0.4 + 7.5 * 0.9)
    gravity = np.linalg.norm(lever.loads.gravity)
    torque *= gravity / 9.80665
    run = MeasuredRun.from_state(lever, lever.close([0.5]), efforts={"q": torque})
    estimate = estimate_payload(run, com=[0.0, 0.0, 0.0], tolerances=EXACT)
    assert estimate.mass == pytest.approx(7.5, rel=1e-3)
    # 1 % of 4.8 kg m is off, along the lever and across it
    links = Tolerances(0.01, 0.0, 0.0, 0.0, 0.0, 1e-9, friction_share=0.0)
    honest = estimate_payload(run, com=[0.0, 0.0, 0.0], tolerances=links)
    assert honest.deviation == pytest.approx(0.01 * 4.8 / 0.9 / np.cos(0.5), rel=0.02)


def test_any_coordinates_that_determine_the_motion_weigh_alike(excavator, motion):
    time, state, _ = motion
    efforts = efforts_of(excavator, motion, 900.0)
    angles = ("slew", "boom_pitch", "stick_pitch", "bucket_pitch")
    columns = {name: state.s[:, excavator.coordinates.index(name)] for name in angles}
    by_angles = MeasuredRun.from_samples(excavator, time, columns, efforts)
    assert by_angles.state.u == pytest.approx(state.u, abs=1e-4)
    first = estimate_payload(by_angles)
    second = estimate_payload(run_of(excavator, motion, efforts))
    assert first.mass == pytest.approx(second.mass, abs=0.2)


def test_a_static_pose_is_weighed_by_pressures_too(excavator):
    state = excavator.close([0.0, 0.7, 0.7, 0.6])
    tau = excavator.inverse_dynamics(
        state, np.zeros(4), excavator.loads.with_payload(Payload(800.0, COM))
    )
    cylinders = excavator.hydraulics(state, tau)
    pressures = {
        name: (float(one.cap_pressure), float(one.rod_pressure)) for name, one in cylinders.items()
    }
    run = MeasuredRun.from_state(excavator, state, pressures=pressures)
    estimate = estimate_payload(run, com=COM)
    assert estimate.mass == pytest.approx(800.0, abs=1.0)
    low, high = estimate.interval
    assert high - low > 20.0  # one pose at rest shows no friction


def test_an_empty_run_cancels_what_the_model_is_off_by():
    """Links 3 % too heavy and twice the friction: told by the empty run alone."""
    rng = np.random.default_rng(7)
    both = machine(rng)
    links = {
        name: replace(link, mass=1.03 * link.mass)
        for name, link in both.model.description.links.items()
    }
    heavy = type(both.model)(replace(both.model.description, links=links))
    loaded = recorded(both.true, rng, 1000.0).run(heavy)
    empty = recorded(both.true, rng, 0.0).run(heavy)
    tolerances = Tolerances(links=0.03)
    zeroed = estimate_payload(loaded, empty, tolerances=tolerances)
    assert abs(zeroed.mass - 1000.0) < 0.0025 * FULL_SCALE
    assert abs(estimate_payload(loaded, tolerances=tolerances).mass - 1000.0) > 15.0


def test_friction_that_grows_with_the_force_is_found_from_the_motion(excavator, motion):
    """The file has none; seals have 5 % of the force. Loads are found to 0.25 % of full scale."""
    _, state, _ = motion
    runs = []
    for mass in (1200.0, 0.0):
        efforts = efforts_of(excavator, motion, mass)
        for name, force in efforts.items():
            rate = state.ds[:, excavator.coordinates.index(name)]
            efforts[name] = force + 0.05 * np.abs(force) * np.sign(rate)
        runs.append(run_of(excavator, motion, efforts))
    loaded, empty = runs
    estimate = estimate_payload(loaded, empty)
    assert abs(estimate.mass - 1200.0) < 0.0025 * FULL_SCALE
    assert estimate.interval[0] < 1200.0 < estimate.interval[1]
    alone = estimate_payload(loaded)
    assert alone.interval[0] < 1200.0 < alone.interval[1]


def test_a_large_share_of_friction_is_found_beyond_first_order(excavator, motion):
    """12 % of the force; an estimate that is not linearised again is off by the square of it."""
    _, state, _ = motion
    efforts = efforts_of(excavator, motion, 0.0)
    for name, force in efforts.items():
        rate = state.ds[:, excavator.coordinates.index(name)]
        efforts[name] = force + 0.12 * np.abs(force) * np.sign(rate)
    run = run_of(excavator, motion, efforts)
    shares = deviation_of(run, excavator.loads, Tolerances()).values[-len(efforts) :]
    assert np.abs(shares - 0.12).max() < 0.12**2


@pytest.mark.parametrize("seed", [11, 12])
def test_noisy_lifts_are_weighed_within_their_intervals(seed):
    for mass, estimate in lift(seed):
        low, high = estimate.interval
        assert low < mass < high
        assert estimate.quality == "good"


def test_no_method_is_better_than_the_mass_of_the_bucket_without_an_empty_run():
    """1 % of 850 kg cannot be told from the load; a bound of Cramer and Rao says no less."""
    assert 8.5 < mass_bound() < 9.5


@pytest.mark.sweep(sample="test_noisy_lifts_are_weighed_within_their_intervals")
def test_errors_and_intervals_of_lifts_are_those_of_the_docs():
    results = weighed(24)
    zeroed, alone = (results[case] for case in CASES)
    assert zeroed.within(0.9) < 0.0025 * FULL_SCALE
    assert alone.within(0.9) < 0.01 * FULL_SCALE
    assert zeroed.width.max() < 0.01 * FULL_SCALE
    assert min(zeroed.coverage, alone.coverage) > 0.83


def test_of_a_whole_cycle_the_loaded_part_is_weighed(excavator, motion):
    """The bucket fills, is carried and is dumped: the load that stays is weighed."""
    _, state, ddu = motion
    share = np.interp(motion[0], [1.0, 2.0, 4.5, 5.2], [0.0, 1.0, 1.0, 0.0])
    full, none = efforts_of(excavator, motion, 1200.0), efforts_of(excavator, motion, 0.0)
    soil = excavator.loads.with_wrench([2e4, 0.0, 1e4, 0.0, 0.0, 0.0])
    pull = excavator.inverse_dynamics(state, ddu, soil)
    efforts = {}
    for k, name in enumerate(excavator.active):
        if k:
            digging = np.where((share > 0.0) & (motion[0] < 2.0), pull[:, k] - none[name], 0.0)
            efforts[name] = none[name] + share * (full[name] - none[name]) + digging
    estimate = estimate_payload(run_of(excavator, motion, efforts))
    assert estimate.interval[0] < 1200.0 < estimate.interval[1]
    begin, end = estimate.span
    assert 1.9 < begin < 2.6
    assert 4.0 < end < 4.6


def test_runs_that_cannot_be_weighed_are_refused(excavator, motion):
    state = excavator.close([0.0, 0.7, 0.7, 0.6])
    with pytest.raises(InputError, match="no effort is measured"):
        MeasuredRun.from_state(excavator, state)
    with pytest.raises(InputError, match="no drive 'boom'"):
        MeasuredRun.from_state(excavator, state, efforts={"boom": 1.0})
    run = run_of(excavator, motion, efforts_of(excavator, motion, 500.0))
    with pytest.raises(InputError, match="no frame 'teeth'"):
        estimate_payload(run, frame="teeth")
    with pytest.raises(InputError, match="where no drive feels a load"):
        estimate_payload(run, frame="base")
    boom = run_of(excavator, motion, {"boom_cylinder": run.efforts[:, 0]})
    with pytest.raises(InputError, match="empty: no effort of stick_cylinder, bucket_cylinder"):
        estimate_payload(run, boom)
    lighter = run_of(excavator, motion, efforts_of(excavator, motion, 0.0))
    laden = run_of(excavator, motion, efforts_of(excavator, motion, 100.0))
    with pytest.raises(SensorError, match="below zero"):
        estimate_payload(lighter, laden)
    with pytest.raises(InputError, match="4 independent coordinates"):
        MeasuredRun.from_samples(excavator, motion[0], {"slew": motion[1].u[:, 0]})
