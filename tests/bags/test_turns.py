"""Encoders that begin anew after a whole turn, and recordings of them."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_ros.bags.analysis.collect import collect
from hybrid_dynamics_ros.bags.analysis.report_tables import facts_table
from hybrid_dynamics_ros.messages.joint_samples import Calibration
from hybrid_dynamics_ros.stream.pipeline import Pipeline
from hybrid_dynamics_ros.stream.turns import TURN, TurnCounter
from tests.bags.calling import printed
from tests.bags.messages import START, bag, joint_state
from tests.bags.test_stream import assert_same, streamed
from tests.laws.test_whole_turns import SWAYING, TRAIN
from tests.sampling import examples, swept

MS = 10**6
STEP = 0.01  # [s]


def wrapped(position, lowest, is_angle):
    """Readings of encoders that begin anew at `lowest` [rad]; lengths stay as they are."""
    anew = (position - lowest) % TURN + lowest
    return np.where(is_angle, anew, position)


def angles_of(robot):
    return np.array([robot.joint_types[name] == "revolute" for name in robot.active])


@st.composite
def motions(draw, robot, count=80):
    """Times [s], positions and velocities (count, n) that turn through many places."""
    is_angle = angles_of(robot)
    rates = [draw(st.floats(-9.0, 9.0)) for _ in robot.active]
    starts = [draw(st.floats(-3.0, 3.0)) for _ in robot.active]
    time = STEP * np.arange(count)
    turning = starts + np.outer(time, rates)
    swaying = robot.reference + 0.01 * np.sin(np.outer(time, rates))
    sway_rates = 0.01 * np.cos(np.outer(time, rates)) * rates
    position = np.where(is_angle, turning, swaying)
    velocity = np.where(is_angle, np.broadcast_to(rates, position.shape), sway_rates)
    return time, position, velocity


def messages(robot, time, position, velocity):
    """Their messages; velocity None: without."""
    pairs = []
    for k, t in enumerate(time):
        stamp = START + round(t * 1e9)
        rates = () if velocity is None else velocity[k]
        pairs.append((stamp, joint_state(stamp, robot.active, position[k], rates)))
    return pairs


def assert_alike(position, expected):
    """Coordinates that differ by whole turns."""
    turns = (position - expected) / TURN
    np.testing.assert_allclose(turns, np.rint(turns), atol=1e-9)  # rounding of a few turns


@pytest.mark.parametrize("is_measured", [True, False])
@examples(40)
@given(data=st.data())
def test_a_wrapped_stream_is_the_unwrapped_one(forging, is_measured, data):
    time, position, velocity = data.draw(motions(forging))
    velocity = velocity if is_measured else None
    is_angle = angles_of(forging)
    readings = wrapped(position, data.draw(st.sampled_from([-math.pi, 0.0])), is_angle)
    pairs = messages(forging, time, readings, velocity)
    cuts = data.draw(st.lists(st.integers(0, len(pairs)), max_size=3).map(sorted))
    found = assert_same(forging, pairs, cuts)  # node and bag agree
    plain = messages(forging, time, position, velocity)
    expected, pipeline = streamed(Pipeline(forging, 10.0, 0.5), plain)
    assert not pipeline.counts.wraps
    for (_, one), (_, other) in zip(found, expected, strict=True):
        assert_alike(one.position, other.position)
        steps = one.active.position - found[0][1].active.position
        other_steps = other.active.position - expected[0][1].active.position
        np.testing.assert_allclose(steps, other_steps, atol=1e-12)  # it goes on, without a jump
        assert (one.efforts is None) == (other.efforts is None)
        if one.efforts is not None:
            scale = 1e-7 * (1.0 + np.abs(other.efforts).max())  # rounding, differentiated twice
            np.testing.assert_allclose(one.efforts, other.efforts, atol=scale)
    _, pipeline = streamed(Pipeline(forging, 10.0, 0.5), pairs)
    jumps = (np.abs(np.diff(readings, axis=0)) > math.pi).sum(axis=0)
    counted = [pipeline.counts.wraps[name] for name in forging.active]
    assert counted == jumps.tolist()


@pytest.mark.parametrize("mode", ["counterclockwise", "clockwise"])
def test_a_loop_behind_a_gear_is_followed_over_whole_turns(mode):
    """It would not close at the angle nearest to the reference's."""
    text = TRAIN.format(ratio=0.05, second=-1.7, mode=mode, **SWAYING)
    robot = Robot(parse_description(text))
    time = STEP * np.arange(300)
    position = 0.5 + 2.0 * math.pi * time[:, None]
    velocity = np.full_like(position, 2.0 * math.pi)
    path = robot.close_path(position, velocity)
    assert (robot.close(position, check=False).status != 0).any()
    efforts = robot.inverse_dynamics(path, np.zeros_like(position))
    pairs = messages(robot, time, wrapped(position, -math.pi, [True]), velocity)
    found = assert_same(robot, pairs, [100, 200])
    assert len(found) == len(time)
    for k, (_, one) in enumerate(found):
        # rounding of times and turns
        np.testing.assert_allclose(one.position, path.s[k], atol=1e-8)
        if one.efforts is not None:
            np.testing.assert_allclose(one.efforts, efforts[k], atol=1e-6)


@pytest.mark.parametrize(
    ("smooth", "is_measured"),
    swept([("causal", False), ("spline", False), ("savgol", False), ("spline", True)], ("spline",)),
)
def test_a_wrapped_recording_gives_the_efforts_of_the_unwrapped_one(smooth, is_measured, tmp_path):
    robot = load("excavator")
    time = STEP * np.arange(200)
    rates = np.where(angles_of(robot), 3.0, 0.0)
    shape = 0.3 * np.sin(4.0 * time)[:, None] * (rates > 0.0)
    position = robot.reference + rates * time[:, None] + shape
    velocity = rates + 1.2 * np.cos(4.0 * time)[:, None] * (rates > 0.0)
    tracks = []
    for name, readings in (
        ("whole", position),
        ("wrapped", wrapped(position, -math.pi, angles_of(robot))),
    ):
        pairs = messages(robot, time, readings, velocity if is_measured else None)
        path = bag(tmp_path / name, pairs)
        tracks.append(collect(path, "excavator", smooth=smooth))
    whole, found = tracks
    assert found.counts.wraps
    assert not whole.counts.wraps
    assert not found.outliers
    assert_alike(found.state.s, whole.state.s)
    np.testing.assert_allclose(found.acceleration, whole.acceleration, atol=1e-6)
    scale = 1e-7 * np.nanmax(np.abs(whole.efforts))
    np.testing.assert_allclose(found.efforts, whole.efforts, atol=scale)


def test_reports_and_identification_count_the_turns(forging, tmp_path):
    time = STEP * np.arange(300)
    position = np.array([0.0, 0.1, 0.15, 0.0]) + 0.02 * np.sin(np.outer(time, [3.0, 4.0, 5.0, 6.0]))
    position[:, 0] += 3.0 * time
    pairs = []
    for k, (log, _) in enumerate(messages(forging, time, position, None)):
        readings = wrapped(position[k], -math.pi, angles_of(forging))
        efforts = [1.0, 800.0, -4000.0, 0.1 * k]
        pairs.append((log, joint_state(log, forging.active, readings, (), efforts)))
    path = bag(tmp_path / "in", pairs)
    words = ("--robot", "forging_chu2020", "--links", "l4")
    text = printed("identify", path, *words)
    assert "1 whole turn of q1 continued" in text
    assert json.loads(printed("identify", path, *words, "--json"))["summary"] in text
    assert "1 whole turn of q1 continued" in facts_table(collect(path, "forging_chu2020"))


def test_a_turn_in_a_sample_is_motion_where_a_velocity_says_so():
    turns = TurnCounter(["spindle"], [True], 0.5)
    state = None
    position = 400.0 * STEP * np.arange(20)[:, None]  # more than half a turn a sample
    for k, angle in enumerate(position):
        state, continued = turns.step(state, 10 * MS * k, angle, np.array([400.0]))
        assert np.array_equal(continued, angle)
    rows = turns.run(None, 10 * MS * np.arange(20), position, np.full((20, 1), 400.0))
    assert np.array_equal(rows.position, position)
    assert not rows.wraps


def test_readings_are_taken_as_they_are_after_a_gap_and_back_in_time():
    turns = TurnCounter(["a", "slide"], [True, False], 0.5)
    state, _ = turns.step(None, 0, np.array([3.0, 0.0]), None)
    state, at = turns.step(state, 10 * MS, np.array([-3.0, 7.0]), None)
    np.testing.assert_allclose(at, [TURN - 3.0, 7.0])  # a slide may jump
    for stamp in (700 * MS, 5 * MS):
        _, at = turns.step(state, stamp, np.array([-2.9, 7.0]), None)
        assert np.array_equal(at, [-2.9, 7.0])


def test_calibrated_sensors_wrap_too(forging):
    degrees = Calibration(np.array([30.0, 0, 0, 0]), np.array([math.pi / 180.0, 1, 1, 1]))
    time = STEP * np.arange(60)
    q1 = 170.0 + 100.0 * time  # degrees, beyond 180
    readings = np.tile([0.0, 0.1, 0.15, 0.2], (60, 1))
    readings[:, 0] = (q1 + 180.0) % 360.0 - 180.0
    found = assert_same(forging, messages(forging, time, readings, None), calibration=degrees)
    angle = [result.active.position[0] for _, result in found]
    np.testing.assert_allclose(angle, np.deg2rad(q1 - 30.0), atol=1e-12)
