"""Forces at the tool: exact where the model is, honest where it is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.estimation.forces import CASES, push, pushed
from benchmarks.estimation.lifts import machine, recorded
from hybrid_dynamics_core import InputError, Robot, load
from hybrid_dynamics_core.control import JointTrajectory
from hybrid_dynamics_core.estimation import (
    MeasuredRun,
    SensorError,
    ToolForceModel,
    ToolForceObserver,
    ToolForceOptions,
    tool_force,
)
from hybrid_dynamics_core.estimation.wrench import DriveEfforts
from tests.mechanisms import describe

CYLINDERS = ("boom_cylinder", "stick_cylinder", "bucket_cylinder")
QUICK = ToolForceOptions(cutoff=10.0)


@pytest.fixture(scope="module")
def excavator():
    return load("excavator")


@pytest.fixture(scope="module")
def motion(excavator):
    """Times, states and accelerations of a motion."""
    time = np.arange(0.0, 2.0, 0.01)
    path = JointTrajectory.between([0.0, 0.5, 0.9, 0.7], [0.5, 0.7, 0.7, 0.8], 2.0)
    goal = path(time)
    return time, excavator.close(goal.u, goal.du), goal.ddu


def efforts_of(robot, motion, wrench, drives):
    """Efforts (N, k) of drives under a constant wrench (6,) in the axes of the tool."""
    _, state, ddu = motion
    loads = robot.loads.with_wrench(wrench, axes="frame")
    forces = robot.drive_forces(state, robot.inverse_dynamics(state, ddu, loads))
    return np.stack([forces[name] for name in drives], axis=1)


def test_exact_efforts_give_the_force_and_tell_the_blind_axes(excavator, motion):
    """Cylinders in a plane sense no force across it."""
    time, state, _ = motion
    wrench = np.array([3e4, -1e4, 0.0, 0.0, 0.0, 0.0])
    efforts = efforts_of(excavator, motion, wrench, CYLINDERS)
    observer = ToolForceObserver(ToolForceModel(excavator, CYLINDERS, QUICK))
    answer = observer.run(time, state, efforts)
    late = answer.is_ready
    assert late.sum() > 100
    assert answer.blind == ("fz",)
    assert answer.wrench[late][:, :2] == pytest.approx(
        np.tile(wrench[:2], (late.sum(), 1)), rel=1e-3
    )
    assert answer.wrench[late][:, 3:] == pytest.approx(np.zeros((late.sum(), 3)))
    assert answer.contact[late].all()
    assert np.isnan(answer.wrench[~late]).all()
    variance = np.diagonal(answer.covariance[late], axis1=1, axis2=2)
    assert (variance[:, :2] > 0.0).all()
    assert np.isnan(variance[:, 2]).all()


def test_some_drives_are_enough_where_they_sense_the_force(excavator, motion):
    time, state, _ = motion
    wrench = np.array([2e4, 2e4, 0.0, 0.0, 0.0, 0.0])
    for drives in (CYLINDERS[:2], ("slew", *CYLINDERS)):
        efforts = efforts_of(excavator, motion, wrench, drives)
        answer = ToolForceObserver(ToolForceModel(excavator, drives, QUICK)).run(
            time, state, efforts
        )
        assert answer.wrench[-1, :2] == pytest.approx(wrench[:2], rel=2e-3)
        assert answer.blind == (("fz",) if "slew" not in drives else ())
    one = ToolForceObserver(ToolForceModel(excavator, CYLINDERS[:1], QUICK))
    answer = one.run(time, state, efforts_of(excavator, motion, wrench, CYLINDERS[:1]))
    assert answer.blind == ("fx", "fy", "fz")
    direction = answer.visible[-1, :3, :3] @ wrench[:3]
    assert answer.visible_part[-1, :3] == pytest.approx(direction, rel=2e-3)


def six_axes():
    """A serial arm of six joints."""
    rows = [
        ("a", "revolute", "base", "l1", (0, 0, 0.2), "z"),
        ("b", "revolute", "l1", "l2", (0.1, 0, 0.3), "y"),
        ("c", "revolute", "l2", "l3", (0.5, 0, 0.0), "y"),
        ("d", "revolute", "l3", "l4", (0.2, 0, 0.1), "x"),
        ("e", "revolute", "l4", "l5", (0.3, 0, 0.0), "y"),
        ("f", "revolute", "l5", "l6", (0.1, 0, 0.0), "x"),
    ]
    start = {"a": 0.3, "b": 0.4, "c": 0.5, "d": -0.2, "e": 0.7, "f": 0.1}
    return Robot(describe("arm", rows, [], list(start), start))


def test_six_drives_give_the_moments_too():
    robot = six_axes()
    time = np.arange(0.0, 1.0, 0.01)
    start = robot.reference
    goal = JointTrajectory.between(start, start + 0.2, 1.0)(time)
    motion = time, robot.close(goal.u, goal.du), goal.ddu
    wrench = np.array([300.0, -200.0, 500.0, 20.0, 30.0, -10.0])
    efforts = efforts_of(robot, motion, wrench, robot.drives)
    model = ToolForceModel(robot, robot.drives, QUICK)
    answer = ToolForceObserver(model).run(time, motion[1], efforts)
    assert answer.blind == ()
    assert answer.wrench[-1] == pytest.approx(wrench, rel=5e-3, abs=0.5)


@pytest.mark.parametrize("size", [1e-4, 1.0, 1e4])
def test_what_drives_sense_does_not_depend_on_the_unit_of_length(size):
    """A force acts on drives by levers, a moment directly: small machines sense both as well."""
    rng = np.random.default_rng(3)
    effect = rng.normal(size=(1, 6, 6))
    effect[..., :3] *= size
    wrench = np.array([300.0, -200.0, 500.0, 20.0 * size, 30.0 * size, -10.0 * size])
    along = (effect @ wrench).reshape(1, 6)
    covariance = 1e-6 * size**2 * np.eye(6)[None]
    sensed = DriveEfforts(along, covariance, effect, np.array([True]), length=size)
    answer = sensed.force("tool", 1.0)
    assert answer.blind == ()
    assert answer.wrench[0] == pytest.approx(wrench, rel=1e-9)
    assert answer.visible[0] == pytest.approx(np.eye(6), abs=1e-9)


def test_samples_one_by_one_give_the_same_bits(excavator, motion):
    time, state, _ = motion
    efforts = efforts_of(excavator, motion, np.array([2e4, 0, 0, 0, 0, 0.0]), CYLINDERS)
    efforts = efforts + 50.0 * np.sin(30.0 * time)[:, None]
    model = ToolForceModel(excavator, CYLINDERS, QUICK)
    expected = ToolForceObserver(model).run(time, state, efforts)
    observer = ToolForceObserver(model)
    for k in range(len(time)):
        one = observer.step(time[k], state.rows(k), efforts[k])
        assert one.visible_part[0].tobytes() == expected.visible_part[k].tobytes()
        assert one.level[0].tobytes() == expected.level[k].tobytes()


def test_noise_alone_is_no_contact_and_twice_the_threshold_is():
    """The threshold follows the noise: a force is found as soon as it stands out."""
    rng = np.random.default_rng(5)
    both = machine(rng)
    run = recorded(both.true, rng, 0.0).run(both.model)
    free = tool_force(run)
    assert free.contact.mean() < 0.01
    level = free.level[free.is_ready]
    assert 0.1 < np.median(level) < 5.0
    noisy = np.random.default_rng(6).normal(0.0, 4e3, run.efforts.shape)
    loud = MeasuredRun(run.robot, run.state, run.ddu, run.efforts + noisy, run.drives, run.time)
    assert tool_force(loud).contact.mean() < 0.02


@pytest.mark.parametrize("seed", [3])
def test_forces_of_noisy_machines_are_within_the_goal(seed):
    """Direction within 5 degrees, size within 2 %, and better than 383 N."""
    judged = push(seed)
    for case in CASES:
        digging = judged["20 to 80 kN", case]
        assert np.rad2deg(np.quantile(digging.angle, 0.95)) < 2.0
        assert np.quantile(digging.size, 0.95) < 0.03
        assert digging.detected == 1.0
        for name in ("2 kN", "10 kN"):
            assert np.sqrt(np.mean(judged[name, case].error ** 2)) < 383.0


@pytest.mark.sweep(sample="test_forces_of_noisy_machines_are_within_the_goal")
def test_errors_of_forces_are_those_of_the_docs():
    results = pushed(12)
    for case in CASES:
        runs = results["20 to 80 kN", case]
        size = np.concatenate([run.size for run in runs])
        angle = np.concatenate([run.angle for run in runs])
        assert np.quantile(size, 0.95) < 0.02
        assert np.rad2deg(np.quantile(angle, 0.95)) < 5.0
        assert np.mean([run.alarmed for run in runs]) < 0.01


def test_pressures_in_bar_and_exchanged_chambers_are_no_force():
    rng = np.random.default_rng(5)
    both = machine(rng)
    lift = recorded(both.true, rng, 0.0)
    for words, change in (
        ("seem to be in bar", lambda cap, rod: (1e-5 * cap, 1e-5 * rod)),
        ("cap and rod side exchanged", lambda cap, rod: (rod, cap)),
    ):
        sides = {name: change(*pair) for name, pair in lift.pressures.items()}
        wrong = replace(lift, pressures=sides).run(both.model)
        with pytest.raises(SensorError, match=words):
            tool_force(wrong)


def test_what_shows_no_force_is_refused(excavator, motion):
    time, state, _ = motion
    with pytest.raises(InputError, match="no drive is measured"):
        ToolForceModel(excavator, ())
    with pytest.raises(InputError, match="no drive 'boom'"):
        ToolForceModel(excavator, ("boom",))
    with pytest.raises(InputError, match="no frame 'teeth'"):
        ToolForceModel(excavator, CYLINDERS, ToolForceOptions(frame="teeth"))
    with pytest.raises(InputError, match="false_alarms is 2"):
        ToolForceOptions(false_alarms=2.0)
    observer = ToolForceObserver(ToolForceModel(excavator, CYLINDERS))
    with pytest.raises(InputError, match=r"efforts has shape \(200, 2\)"):
        observer.run(time, state, np.zeros((200, 2)))
    with pytest.raises(InputError, match="boom_cylinder"):
        observer.run(time, state, np.full((200, 3), np.nan))
    pose = MeasuredRun.from_state(excavator, state.rows(0), efforts={"boom_cylinder": 1e5})
    with pytest.raises(InputError, match="run has no times"):
        tool_force(pose)
