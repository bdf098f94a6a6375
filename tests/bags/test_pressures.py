"""Measured pressures: forces of the cylinders beside the required ones, in recordings as live."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.rosbag2 import Reader, StoragePlugin, Writer

from hybrid_dynamics_core import load
from hybrid_dynamics_ros.bags.input_topic import INPUT
from hybrid_dynamics_ros.bags.job import Job
from hybrid_dynamics_ros.bags.process import process
from hybrid_dynamics_ros.bags.recorded_pressures import PRESSURE_INPUT
from hybrid_dynamics_ros.messages.interfaces import JOINT_STATE, typestore
from hybrid_dynamics_ros.messages.joint_samples import (
    JointSample,
    RejectedError,
    RejectionCode,
)
from hybrid_dynamics_ros.messages.pressures import (
    PRESSURES,
    PressureSample,
    sample_of_pressures,
)
from hybrid_dynamics_ros.stream.joint_topics import MeasuredEfforts
from hybrid_dynamics_ros.stream.pipeline import Pipeline
from tests.bags.messages import START, joint_state, motion_of
from tests.sampling import examples

MS = 10**6
CYLINDERS = ("boom_cylinder", "stick_cylinder", "bucket_cylinder")


@pytest.fixture(scope="module")
def excavator():
    return load("excavator")


def pressures(stamp_ns, names, cap, rod):
    """CDR bytes of a CylinderStates, of which names and pressures are filled in."""
    types = typestore().types
    time = types["builtin_interfaces/msg/Time"](sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
    kind = types[PRESSURES]
    fields = {name: np.zeros(0) for name in kind.__dataclass_fields__ if name != "__msgtype__"}
    fields["header"] = types["std_msgs/msg/Header"](time, "")
    fields |= {"name": list(names), "overloaded": np.zeros(0, dtype=bool)}
    fields |= {"cap_pressure": np.array(cap, float), "rod_pressure": np.array(rod, float)}
    return bytes(typestore().serialize_cdr(kind(**fields), PRESSURES))


def write(path, entries):
    """A bag of entries: topic, kind, log time, data."""
    writer = Writer(path, version=9, storage_plugin=StoragePlugin.MCAP)
    with writer:
        connections = {}
        for topic, kind, log_ns, data in entries:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=typestore())
            writer.write(connections[topic], log_ns, data)
    return path


def messages_on(path, name):
    with Reader(path) as reader:
        topics = [c for c in reader.connections if c.topic.endswith(name)]
        return [bytes(data) for _, _, data in reader.messages(topics)]


def test_pressures_of_the_required_forces_measure_these(excavator):
    """Chambers at the pressures that the model asks for: measured and required are the same."""
    pipeline = Pipeline(excavator, 10.0, 0.5)
    _, u, du, _ = motion_of(excavator, 40)
    for k in range(40):
        stamp = START + 10 * MS * k
        result = pipeline.process(JointSample(stamp, excavator.active, u[k], du[k]))
    states = excavator.hydraulics(result.state, result.efforts)
    cap = np.array([float(states[name].cap_pressure) for name in CYLINDERS])
    rod = np.array([float(states[name].rod_pressure) for name in CYLINDERS])
    pipeline.pressures.take(PressureSample(stamp, CYLINDERS, cap, rod))
    result = pipeline.process(JointSample(stamp + 10 * MS, excavator.active, u[-1], du[-1]))
    required = excavator.drive_forces(result.state, result.efforts)
    _, (*_, measured) = MeasuredEfforts(excavator).message(result)
    assert np.isnan(measured[0])  # nobody measures the slewing drive's pressures
    expected = [float(states[name].force) for name in CYLINDERS]
    np.testing.assert_allclose(measured[1:], expected, rtol=1e-12)
    assert list(required) == list(excavator.drives)
    old = pipeline.process(JointSample(stamp + 300 * MS, excavator.active, u[-1], du[-1]))
    assert old.measured_forces is None
    assert MeasuredEfforts(excavator).message(old) is None


@st.composite
def recordings(draw):
    """Joint states and pressures in any order: kind, stamp [ms], numbers."""
    entries, stamp = [], 0
    for _ in range(draw(st.integers(10, 40))):
        stamp += draw(st.sampled_from([1, 5, 10, 150]))
        if draw(st.booleans()):
            names = draw(st.lists(st.sampled_from([*CYLINDERS, "hose"]), max_size=3, unique=True))
            cap = [draw(st.sampled_from([1e6, 2.5e7, np.nan])) for _ in names]
            entries.append(("pressures", stamp, names, cap))
        else:
            entries.append(("states", stamp, (), ()))
    return [*entries, ("states", stamp + 1, (), ())]


@examples(24)
@given(entries=recordings())
def test_recordings_have_the_measured_efforts_of_the_stream(excavator, tmp_path_factory, entries):
    pipeline, topic, expected, written = Pipeline(excavator, 10.0, 0.5), None, [], []
    topic = MeasuredEfforts(excavator)
    for kind, stamp_ms, names, cap in entries:
        stamp = START + stamp_ms * MS
        if kind == "pressures":
            data = pressures(stamp, names, cap, np.full(len(names), 2e5))
            sample = sample_of_pressures(typestore().deserialize_cdr(data, PRESSURES))
            with suppress(RejectedError):  # none of the robot's cylinders is named
                pipeline.pressures.take(sample)
            written.append((PRESSURE_INPUT, PRESSURES, stamp, data))
            continue
        u = excavator.reference + 1e-5 * stamp_ms
        result = pipeline.process(JointSample(stamp, excavator.active, u))
        expected.append(topic.fill(result))
        written.append((INPUT, JOINT_STATE, stamp, joint_state(stamp, excavator.active, u)))
    folder = tmp_path_factory.mktemp("pressures")
    process(Job(write(folder / "in", written), folder / "out", "excavator"))
    sent = messages_on(folder / "out", "/measured_efforts")
    assert sent == [data for data in expected if data is not None]


@pytest.mark.parametrize(
    ("names", "cap", "stamp_ns", "code"),
    [
        (CYLINDERS, [1.0], 0, RejectionCode.WRONG_LENGTH),
        (("hose",), [1.0], 0, RejectionCode.MISSING_JOINT),
        ((), [], 0, RejectionCode.MISSING_JOINT),
        (("boom_cylinder",) * 2, [1.0, 2.0], 0, RejectionCode.DUPLICATE_JOINT),
        (("boom_cylinder",), [1.0], -1, RejectionCode.BAD_STAMP),
    ],
)
def test_pressures_that_cannot_be_used_are_refused(excavator, names, cap, stamp_ns, code):
    taken = Pipeline(excavator, 10.0, 0.5).pressures
    with pytest.raises(RejectedError) as caught:
        taken.take(PressureSample(stamp_ns, names, np.array(cap), np.array(cap)))
    assert caught.value.rejection.code is code
    assert taken.newest == ()
