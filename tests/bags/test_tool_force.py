"""The force at the tool over a stream: as by the library, and in bags to the last bit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import load
from hybrid_dynamics_core.control import JointTrajectory
from hybrid_dynamics_core.dynamics.hydraulics import chamber_pressures
from hybrid_dynamics_core.estimation import ToolForceModel, ToolForceObserver
from hybrid_dynamics_ros.bags.input_topic import INPUT
from hybrid_dynamics_ros.bags.job import Job
from hybrid_dynamics_ros.bags.process import process
from hybrid_dynamics_ros.bags.recorded_pressures import PRESSURE_INPUT
from hybrid_dynamics_ros.messages.interfaces import JOINT_STATE, deserialize
from hybrid_dynamics_ros.messages.joint_samples import JointSample, RejectedError
from hybrid_dynamics_ros.messages.pressures import PRESSURES, PressureSample
from hybrid_dynamics_ros.parameters import TOPIC_RATES, NodeSettings
from hybrid_dynamics_ros.stream.estimates.topics import Contact, ToolWrench
from hybrid_dynamics_ros.stream.frames import frame_names
from hybrid_dynamics_ros.stream.pipeline import Pipeline
from tests.bags.messages import START, joint_state
from tests.bags.test_pressures import CYLINDERS, messages_on, pressures, write
from tests.sampling import examples

STEP = 10 * 10**6  # [ns]
COUNT = 260
ALL = NodeSettings({TOPIC_RATES[name].name: 0.0 for name in ("tool_wrench", "contact")})
PUSH = np.array([2e4, -3e4, 0.0, 0.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def excavator():
    return load("excavator")


@pytest.fixture(scope="module")
def digging(excavator):
    """Motion with a force from its middle on, and pressures (3, N) of both sides."""
    time = 1e-9 * STEP * np.arange(COUNT)
    path = JointTrajectory.between([0.0, 0.5, 0.9, 0.7], [0.5, 0.7, 0.7, 0.8], time[-1])
    goal = path(time)
    state = excavator.close(goal.u, goal.du)
    share = np.interp(time, [1.2, 1.4], [0.0, 1.0])
    soil = excavator.loads.with_wrench(share[:, None] * PUSH, axes="frame")
    tau = excavator.inverse_dynamics(state, goal.ddu, soil)
    sides = [
        chamber_pressures(excavator.cylinders[name], tau[:, excavator.active.index(name)])
        for name in CYLINDERS
    ]
    return goal, np.array(sides)


def streamed(pipeline, digging, rows=range(COUNT), without=()):
    """Results of some samples of the motion; those in `without` lack one cylinder."""
    goal, sides = digging
    results = []
    for k in rows:
        stamp = START + STEP * k
        count = 2 if k in without else 3
        cap, rod = sides[:count, :, k].T
        pipeline.pressures.newest = ()
        pipeline.pressures.take(PressureSample(stamp, CYLINDERS[:count], cap, rod))
        results.append(
            pipeline.process(JointSample(stamp, pipeline.evaluator.measured, goal.u[k], goal.du[k]))
        )
    return results


def numbers(message, count, kind="<f8"):
    return np.frombuffer(message[-count * np.dtype(kind).itemsize :], kind)


def test_the_stream_has_the_force_and_the_contact(excavator, digging):
    pipeline = Pipeline(excavator, 10.0, 0.5)
    topic = ToolWrench(excavator, frame_names(excavator, NodeSettings({})))
    names = frame_names(excavator, NodeSettings({}))
    wrenches, contacts = [], []
    for result in streamed(pipeline, digging):
        message = topic.fill(result)
        if message is not None:
            wrenches.append(numbers(message, 6))
            contacts.append(deserialize(Contact(excavator, names).fill(result), Contact.kind))
    free, pushed = np.array(wrenches[:40]), np.array(wrenches[-40:])
    assert not any(one.contact for one in contacts[:40])
    assert all(one.contact and one.level > one.threshold for one in contacts[-40:])
    covariance = np.reshape(contacts[-1].covariance, (6, 6))
    assert np.isnan(covariance[2]).all()
    assert 1.0 < np.sqrt(covariance[0, 0]) < 2e3  # the file has no friction, so 5 % is open
    assert np.abs(free[:, :2]).max() < 300.0
    assert pushed[:, :2] == pytest.approx(np.tile(PUSH[:2], (40, 1)), rel=0.01)
    assert np.isnan(pushed[:, 2]).all()


def test_the_stream_is_the_observer_of_the_library(excavator, digging):
    pipeline = Pipeline(excavator, 10.0, 0.5)
    observer = ToolForceObserver(ToolForceModel(excavator, CYLINDERS))
    topic = ToolWrench(excavator, frame_names(excavator, NodeSettings({})))
    for result in streamed(pipeline, digging, range(80)):
        efforts = result.measured_forces[1:]
        force = observer.step(result.stamp_ns * 1e-9, result.state, efforts)
        message = topic.fill(result)
        assert (message is not None) == bool(force.is_ready[0])
        if message is not None:
            assert message[-48:] == force.wrench[0].tobytes()


@examples(12, deadline=None)
@given(
    start=st.integers(0, 60),
    missing=st.sets(st.integers(60, 200), max_size=3),
    lost=st.sets(st.integers(60, 200), max_size=3),
    again=st.booleans(),
)
def test_recordings_have_the_force_of_the_stream(
    excavator, digging, tmp_path_factory, start, missing, lost, again
):
    """Also where a cylinder is missing, samples are lost, and stamps go back."""
    goal, _ = digging
    rows = [k for k in range(start, COUNT) if k not in lost]
    if again:
        rows = rows[:120] + rows[60:]
    pipeline = Pipeline(excavator, 10.0, 0.5)
    entries = []
    log = START
    for k in rows:
        stamp = START + STEP * k
        count = 2 if k in missing else 3
        cap, rod = digging[1][:count, :, k].T
        log += STEP
        data = pressures(stamp, CYLINDERS[:count], cap, rod)
        entries.append((PRESSURE_INPUT, PRESSURES, log, data))
        joint = joint_state(stamp, excavator.active, goal.u[k], goal.du[k])
        entries.append((INPUT, JOINT_STATE, log + 1, joint))
    expected = {"tool_wrench": [], "contact": []}
    names = frame_names(excavator, NodeSettings({}))
    topics = {
        "tool_wrench": ToolWrench(excavator, names),
        "contact": Contact(excavator, names),
    }
    for k in rows:
        stamp = START + STEP * k
        count = 2 if k in missing else 3
        cap, rod = digging[1][:count, :, k].T
        pipeline.pressures.take(PressureSample(stamp, CYLINDERS[:count], cap, rod))
        sample = JointSample(stamp, excavator.active, goal.u[k], goal.du[k])
        result = pipeline.process(sample)
        for name, topic in topics.items():
            message = topic.fill(result)
            if message is not None:
                expected[name].append(message)
    folder = tmp_path_factory.mktemp("forces")
    job = Job(write(folder / "in", entries), folder / "out", robot="excavator", settings=ALL)
    process(job)
    for name, messages in expected.items():
        assert len(messages) > 30
        assert messages_on(folder / "out", name) == messages


def test_forces_that_no_drive_has_are_none(excavator, digging):
    pipeline = Pipeline(excavator, 10.0, 0.5)
    goal, sides = digging
    streamed(pipeline, digging, range(60))
    stamp = START + STEP * 60
    pipeline.pressures.newest = ()
    huge = PressureSample(stamp, CYLINDERS, 1e15 * sides[:, 0, 60], sides[:, 1, 60])
    with pytest.raises(RejectedError, match="and its supply has"):
        pipeline.pressures.take(huge)
    sample = JointSample(stamp, excavator.active, goal.u[60], goal.du[60])
    result = pipeline.process(sample)
    topic = ToolWrench(excavator, frame_names(excavator, NodeSettings({})))
    assert topic.fill(result) is None
