"""Controllers do in simulation what theory says of them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.linalg import expm

from hybrid_dynamics_core import ClosureError, InputError, Payload, Robot, load
from hybrid_dynamics_core.control import (
    ComputedTorque,
    FeedForward,
    GravityCompensation,
    JointTrajectory,
    efforts_along,
)
from hybrid_dynamics_core.simulation import Settings, Simulation, simulate
from tests.sampling import swept

SPAN = (0.0, 1.2)  # [s]
STARTS = {  # from where to where
    "forging_chu2020": ([0.0, 0.15, 0.1, 0.0], [0.5, 0.25, 0.14, 1.0]),
    "excavator": ([0.0, 0.7, 0.7, 0.6], [0.4, 0.8, 0.6, 0.7]),
    "palletizer": (None, [0.2, 0.15, -0.1, 0.3]),
    "gough": (None, [0.03, -0.02, 0.03, 0.01, -0.02, 0.02]),
}


def motion_of(name: str) -> tuple[Robot, JointTrajectory]:
    robot = load(name)
    start, end = STARTS[name]
    if start is None:
        start, end = robot.reference, robot.reference + end
    return robot, JointTrajectory.between(start, end, 1.0, begin=0.1)


def errors(motion: Simulation, trajectory: JointTrajectory) -> np.ndarray:
    return trajectory(motion.t).u - motion.u


@pytest.mark.parametrize("name", swept(STARTS))
def test_computed_torque_makes_the_error_a_linear_one(name: str) -> None:
    """From a start off the trajectory e'' + kd e' + kp e = 0, to the integrator's accuracy."""
    robot, trajectory = motion_of(name)
    kp, kd = 60.0, 12.0
    offset = 0.01 * np.cos(np.arange(len(robot.active)))
    settings = Settings(rate=50.0)
    motion = simulate(
        robot,
        trajectory.positions[0] - offset,
        None,
        ComputedTorque(robot, trajectory, kp, kd),
        (0, 1.2),
        settings,
    )
    assert motion.completed
    matrix = np.array([[0.0, 1.0], [-kp, -kd]])
    flow = np.array([expm(matrix * t)[0, 0] for t in motion.t])
    expected = flow[:, None] * offset
    assert errors(motion, trajectory) == pytest.approx(expected, abs=1e-7)


@pytest.mark.parametrize("name", swept(["forging_chu2020", "excavator"]))
def test_computed_torque_needs_the_payload(name: str) -> None:
    robot, trajectory = motion_of(name)
    laden = robot.loads.with_payload(Payload(60.0, [0.1, 0.0, 0.0]))
    runs = {}
    for label, loads in (("told", laden), ("not told", robot.loads)):
        controller = ComputedTorque(robot, trajectory, 100.0, 20.0, loads)
        start = trajectory.positions[0]
        runs[label] = simulate(robot, start, None, controller, SPAN, Settings(loads=laden))
    assert np.abs(errors(runs["told"], trajectory)).max() < 1e-7
    assert np.abs(errors(runs["not told"], trajectory)).max() > 1e-4


@pytest.mark.parametrize("name", swept(STARTS))
def test_gravity_compensation_leaves_the_arm_where_it_is(name: str) -> None:
    robot, trajectory = motion_of(name)
    wrench = [10.0, -20.0, 15.0, 1.0, 2.0, -1.0]
    laden = robot.loads.with_payload(Payload(5.0)).with_wrench(wrench)
    start = trajectory.positions[0]
    span, settings = (0.0, 0.5), Settings(loads=laden)
    controller = GravityCompensation(robot, loads=laden)
    held = simulate(robot, start, None, controller, span, settings)
    assert np.abs(held.u - start).max() < 1e-9
    fallen = simulate(robot, start, None, GravityCompensation(robot), span, settings)
    assert np.abs(fallen.u - start).max() > 1e-5


def test_gravity_compensation_moves_as_without_weight(forging: Robot) -> None:
    start = ([0.0, 0.2, 0.1, 0.0], [0.3, 0.1, 0.05, 0.5])
    here = simulate(forging, *start, GravityCompensation(forging), (0.0, 0.3))
    weightless = Settings(loads=forging.loads.with_gravity([0, 0, 0]))
    space = simulate(forging, *start, t_span=(0.0, 0.3), settings=weightless)
    assert here.u == pytest.approx(space.u, abs=1e-8)
    energy = space.energy.kinetic
    assert np.ptp(energy) < 1e-6 * energy[0]  # it only coasts


def test_damping_brings_it_to_a_standstill(forging: Robot) -> None:
    controller = GravityCompensation(forging, damping=[400.0, 20000.0, 20000.0, 5.0])
    start, rates = [0.0, 0.2, 0.1, 0.0], [0.3, 0.05, 0.02, 0.5]
    motion = simulate(forging, start, rates, controller, (0.0, 2.0))
    assert motion.completed
    assert (np.diff(motion.energy.kinetic) <= 1e-9).all()
    assert motion.energy.kinetic[-1] < 1e-3 * motion.energy.kinetic[0]


@pytest.mark.parametrize("name", swept(STARTS))
def test_feed_forward_follows_without_feedback(name: str) -> None:
    """On the trajectory from the start, without any feedback: only the integrator's error grows."""
    robot, trajectory = motion_of(name)
    controller = FeedForward(robot, trajectory)
    motion = simulate(robot, trajectory.positions[0], None, controller, SPAN)
    assert np.abs(errors(motion, trajectory)).max() < 1e-6


@pytest.mark.parametrize("name", swept(["forging_chu2020", "excavator"]))
def test_feed_forward_is_worth_more_than_gains(name: str) -> None:
    robot, trajectory = motion_of(name)
    start = trajectory.positions[0]
    mass, _, _ = robot.minimal_form(robot.close(start))
    weight = np.diag(mass)
    laden = Settings(loads=robot.loads.with_payload(Payload(10.0)))  # which neither knows
    worst = {}
    for model in (True, False):
        controller = FeedForward(robot, trajectory, 400.0 * weight, 40.0 * weight, model=model)
        motion = simulate(robot, start, None, controller, SPAN, laden)
        assert motion.completed
        worst[model] = np.abs(errors(motion, trajectory)).max()
    assert worst[True] < 0.1 * worst[False]


def test_digital_controller_is_worse_the_slower_it_is(forging: Robot) -> None:
    _, trajectory = motion_of("forging_chu2020")
    worst = []
    for hold in (0.02, 0.005):
        controller = ComputedTorque(forging, trajectory, 100.0, 20.0)
        settings = Settings(hold=hold)
        motion = simulate(forging, trajectory.positions[0], None, controller, SPAN, settings)
        worst.append(np.abs(errors(motion, trajectory)).max())
    assert 1e-7 < worst[1] < 0.5 * worst[0] < 0.01


def test_efforts_along_a_trajectory_are_its_inverse_dynamics(forging: Robot) -> None:
    _, trajectory = motion_of("forging_chu2020")
    times = np.linspace(0.0, 1.2, 25)
    tau = efforts_along(forging, trajectory, times)
    for t, row in zip(times, tau, strict=True):
        goal = trajectory(t)
        state = forging.close(goal.u, goal.du)
        expected = forging.inverse_dynamics(state, goal.ddu)
        assert row == pytest.approx(expected, rel=1e-10)
    beyond = JointTrajectory.between([0, 0.3, 0.1, 0], [0, 0.8, 0.1, 0], 1.0)
    with pytest.raises(ClosureError) as caught:
        efforts_along(forging, beyond, np.linspace(0, 1, 11))
    assert caught.value.index == 7


def test_what_does_not_fit_the_robot_is_refused(forging: Robot) -> None:
    _, path = motion_of("forging_chu2020")
    other = JointTrajectory.between([0.0], [1.0], 1.0)
    calls: dict[str, Callable] = {
        r"damping has shape \(2,\); expected a number or \(4,\)": lambda: GravityCompensation(
            forging, [1.0, 2.0]
        ),
        r"kp has shape \(4, 4\)": lambda: ComputedTorque(forging, path, np.eye(4), 1.0),
        r"kd is -1\.0; expected finite numbers": lambda: ComputedTorque(forging, path, 1.0, -1.0),
        "kp is nan": lambda: FeedForward(forging, path, np.nan),
        "has 1 joint; forging_chu2020 has 4": lambda: FeedForward(forging, other),
        "the trajectory has 1 joint;": lambda: efforts_along(forging, other, [0.0]),
    }
    for words, call in calls.items():
        with pytest.raises(InputError, match=words):
            call()


class TestTrajectory:
    @pytest.mark.parametrize("order", [1, 2, 3])
    def test_passes_its_points(self, order: int) -> None:
        rng = np.random.default_rng(order)
        times = [0.0, 0.4, 1.0, 1.5]
        points = rng.normal(size=(3, 4, 2))
        trajectory = JointTrajectory(times, *points[:order])
        for k, t in enumerate(times):
            goal = trajectory(t)
            for part, wanted in zip(goal[:order], points[:order, k], strict=True):
                assert part == pytest.approx(wanted, abs=1e-12)

    def test_rates_are_derivatives(self) -> None:
        points = np.random.default_rng(0).normal(size=(3, 2))
        trajectory = JointTrajectory([0.0, 0.4, 1.0], points)
        t, h = np.linspace(0.05, 0.95, 7), 1e-5
        ahead, behind = trajectory(t + h), trajectory(t - h)
        here = trajectory(t)
        du = (ahead.u - behind.u) / (2 * h)
        ddu = (ahead.du - behind.du) / (2 * h)
        assert du == pytest.approx(here.du, abs=1e-7)
        assert ddu == pytest.approx(here.ddu, abs=1e-6)

    def test_stands_before_and_after(self) -> None:
        trajectory = JointTrajectory([1.0, 2.0], [[0.0], [1.0]], [[1.0], [1.0]])
        for t, u in ((0.0, 0.0), (3.0, 1.0)):
            goal = trajectory(t)
            assert goal.u[0] == u
            assert goal.du[0] == goal.ddu[0] == 0.0
        assert trajectory([0.0, 1.5, 3.0]).u.shape == (3, 1)
        assert trajectory.duration == 1.0

    @pytest.mark.parametrize(
        ("parts", "words"),
        [
            (([0.0], [[1.0]]), "two or more ascending"),
            (([0.0, 0.0], [[1.0], [2.0]]), "ascending"),
            (([0.0, 1.0], [[1.0]]), "one row for each"),
            (([0.0, 1.0], [[1.0], [2.0]], [[1.0, 2.0], [1.0, 2.0]]), "velocities has shape"),
            (([0.0, 1.0], [[1.0], [np.nan]]), "not finite"),
            (([0.0, 1.0], [[1.0], [2.0]], None, [[0.0], [0.0]]), "without velocities"),
        ],
    )
    def test_bad_points_are_refused(self, parts: tuple, words: str) -> None:
        with pytest.raises(InputError, match=words):
            JointTrajectory(*parts)
