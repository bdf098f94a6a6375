"""The load at the tool over a stream: as weighed by the library, and in bags to the last bit."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.estimation.lifts import machine, recorded
from hybrid_dynamics_core import load
from hybrid_dynamics_ros.bags.input_topic import INPUT
from hybrid_dynamics_ros.bags.job import Job
from hybrid_dynamics_ros.bags.process import process
from hybrid_dynamics_ros.bags.recorded_pressures import PRESSURE_INPUT
from hybrid_dynamics_ros.messages.interfaces import JOINT_STATE, deserialize
from hybrid_dynamics_ros.messages.joint_samples import JointSample, RejectedError
from hybrid_dynamics_ros.messages.pressures import PRESSURES, PressureSample
from hybrid_dynamics_ros.parameters import TOPIC_RATES, NodeSettings
from hybrid_dynamics_ros.stream.estimates.topics import Payload
from hybrid_dynamics_ros.stream.frames import frame_names
from hybrid_dynamics_ros.stream.pipeline import Pipeline
from tests.bags.messages import START, joint_state
from tests.bags.test_pressures import messages_on, pressures, write

STEP = 20 * 10**6  # [ns]
ALL = NodeSettings({TOPIC_RATES["payload"].name: 0.2})


@pytest.fixture(scope="module")
def excavator():
    return load("excavator")


@pytest.fixture(scope="module")
def lifts():
    """A lift of 1000 kg and one of the empty bucket, by the same machine."""
    rng = np.random.default_rng(21)
    both = machine(rng)
    return both.model, recorded(both.true, rng, 1000.0), recorded(both.true, rng, 0.0)


def samples_of(robot, lift, first=0, count=None, scale=1.0):
    """Joint states with pressures of a lift at 25 Hz; stamps from a first one on."""
    names = list(lift.pressures)
    for k in range(0, count or len(lift.time), 2):
        stamp = START + STEP * (first + k)
        u = np.array([lift.positions[name][k] for name in robot.active])
        cap, rod = np.array([[side[k] for side in lift.pressures[name]] for name in names]).T
        yield stamp, u, names, scale * cap, scale * rod


def streamed(pipeline, samples):
    """The newest result."""
    result = None
    for stamp, u, names, cap, rod in samples:
        pipeline.pressures.take(PressureSample(stamp, tuple(names), cap, rod))
        result = pipeline.process(JointSample(stamp, pipeline.evaluator.robot.active, u))
    return result


def answer(robot, result):
    topic = Payload(robot, frame_names(robot, NodeSettings({})))
    return deserialize(topic.fill(result), topic.kind)


def test_a_stream_weighs_the_load_and_an_empty_tool_zeroes_it(lifts):
    robot, loaded, empty = lifts
    pipeline = Pipeline(robot, 10.0, 0.5)
    message = answer(robot, streamed(pipeline, samples_of(robot, empty, count=20)))
    assert "s of motion; expected 3 or more" in message.problem
    assert np.isnan(message.mass)
    assert message.quality == 0
    alone = answer(robot, streamed(pipeline, samples_of(robot, loaded, first=2000)))
    assert alone.interval[0] < 1000.0 < alone.interval[1]
    assert not alone.zeroed
    assert alone.quality == 3
    streamed(pipeline, samples_of(robot, empty, first=4000))
    pipeline.scale.zero()
    zeroed = answer(robot, streamed(pipeline, samples_of(robot, loaded, first=6000)))
    assert zeroed.zeroed
    assert zeroed.mass == pytest.approx(1000.0, abs=0.0025 * 2000.0)
    assert np.ptp(zeroed.interval) < 0.3 * np.ptp(alone.interval)
    covariance = np.reshape(zeroed.covariance, (4, 4))
    half = 0.5 * np.ptp(zeroed.interval)
    assert 1.9 < half / np.sqrt(covariance[0, 0]) < 2.6
    assert zeroed.com[0] == pytest.approx(-0.6, abs=0.3)
    pipeline.scale.clear()
    result = streamed(pipeline, samples_of(robot, loaded, first=8000, count=8))
    assert not answer(robot, result).zeroed


def test_what_no_sensor_can_have_measured_is_no_mass(lifts):
    robot, loaded, _ = lifts
    pipeline = Pipeline(robot, 10.0, 0.5)
    samples = []
    for sample in samples_of(robot, loaded):
        samples.append(sample)
        if len(samples) > 150:
            for side in (3, 4):
                sample[side][1] = samples[150][side][1]
    message = answer(robot, streamed(pipeline, samples))
    assert "stuck" in message.problem
    assert np.isnan(message.mass)
    assert np.isnan(message.covariance).all()


def test_pressures_in_bar_are_not_taken(lifts):
    robot, loaded, _ = lifts
    pipeline = Pipeline(robot, 10.0, 0.5)
    with pytest.raises(RejectedError, match="in bar"):
        streamed(pipeline, samples_of(robot, loaded, scale=1e-5, count=3))
    assert pipeline.pressures.newest == ()


def test_a_clock_that_jumps_starts_anew(lifts):
    robot, loaded, _ = lifts
    pipeline = Pipeline(robot, 10.0, 0.5)
    streamed(pipeline, samples_of(robot, loaded, count=200))
    assert pipeline.scale.duration == pytest.approx(3.9, abs=0.1)
    streamed(pipeline, samples_of(robot, loaded, first=400, count=50))
    assert pipeline.scale.duration == pytest.approx(0.9, abs=0.07)
    streamed(pipeline, samples_of(robot, loaded, first=0, count=40))
    assert pipeline.scale.duration == pytest.approx(0.7, abs=0.07)


@pytest.mark.sweep(sample="test_a_stream_weighs_the_load_and_an_empty_tool_zeroes_it")
def test_recordings_have_the_load_of_the_stream(excavator, lifts, tmp_path):
    _, loaded, _ = lifts
    pipeline = Pipeline(excavator, 10.0, 0.5)
    topic = Payload(excavator, frame_names(excavator, NodeSettings({})))
    entries, results = [], {}
    for stamp, u, names, cap, rod in samples_of(excavator, loaded, count=400):
        data = pressures(stamp, names, cap, rod)
        entries.append((PRESSURE_INPUT, PRESSURES, stamp, data))
        entries.append((INPUT, JOINT_STATE, stamp + 1, joint_state(stamp, excavator.active, u)))
        results[stamp] = streamed(pipeline, [(stamp, u, names, cap, rod)])
    job = Job(write(tmp_path / "in", entries), tmp_path / "out", "excavator", settings=ALL)
    process(job)
    sent = messages_on(tmp_path / "out", "/hybrid_dynamics/payload")
    assert sent
    for data in sent:
        stamp = deserialize(data, topic.kind).header.stamp
        assert data == topic.fill(results[stamp.sec * 10**9 + stamp.nanosec])
    assert deserialize(sent[-1], topic.kind).quality > 0
