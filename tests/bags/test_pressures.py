"""Measured pressures: forces of the cylinders beside the required ones, in recordings as live."""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.rosbag2 import Reader, StoragePlugin, Writer

from hybrid_dynamics_cli.bags.identification_text import pressure_lines
from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_ros.bags.analysis.collect import collect
from hybrid_dynamics_ros.bags.analysis.effort_error import effort_errors
from hybrid_dynamics_ros.bags.analysis.pressure_efforts import PressureEfforts
from hybrid_dynamics_ros.bags.analysis.pressure_figure import required_pressures
from hybrid_dynamics_ros.bags.analysis.report import report
from hybrid_dynamics_ros.bags.analysis.report_tables import facts_table
from hybrid_dynamics_ros.bags.input_topic import INPUT
from hybrid_dynamics_ros.bags.job import Job
from hybrid_dynamics_ros.bags.process import process
from hybrid_dynamics_ros.bags.recorded_pressures import PRESSURE_INPUT
from hybrid_dynamics_ros.bags.storage.bag_reader import BagReader
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
from tests.bags.calling import printed
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
        (("boom_cylinder",), [135.0], 0, RejectionCode.BAD_PRESSURE),  # in bar
        (("boom_cylinder",), [9e7], 0, RejectionCode.BAD_PRESSURE),
        (("boom_cylinder",), [-1e6], 0, RejectionCode.BAD_PRESSURE),
    ],
)
def test_pressures_that_cannot_be_used_are_refused(excavator, names, cap, stamp_ns, code):
    taken = Pipeline(excavator, 10.0, 0.5).pressures
    with pytest.raises(RejectedError) as caught:
        taken.take(PressureSample(stamp_ns, names, np.array(cap), np.array(cap)))
    assert caught.value.rejection.code is code
    assert taken.newest == ()


def swung(robot, time):
    """A motion about the reference: u, u', u'' (N, n)."""
    rng = np.random.default_rng(4)
    w = 2.0 * np.pi * rng.uniform(0.1, 0.6, (2, len(robot.active)))
    room = np.minimum(robot.limits[:, 1] - robot.reference, robot.reference - robot.limits[:, 0])
    half = 0.4 * np.minimum(room, 1.0)
    angle = w[:, None] * time[:, None]
    parts = np.sin(angle), w[:, None] * np.cos(angle), -(w[:, None] ** 2) * np.sin(angle)
    position, *rates = (0.5 * half * part.sum(axis=0) for part in parts)
    return robot.reference + position, *rates


def measured_bag(path, robot, count=1200, late=0.003):
    """Joint states with wrong efforts, and pressures of the true ones, with other stamps."""
    time = np.arange(count) / 100.0
    u, du, _ = swung(robot, time)
    state = robot.close(*swung(robot, time + late)[:2])
    efforts = robot.inverse_dynamics(state, swung(robot, time + late)[2])
    cylinders = robot.hydraulics(state, efforts)
    cap = np.array([cylinders[name].cap_pressure for name in CYLINDERS]).T
    rod = np.array([cylinders[name].rod_pressure for name in CYLINDERS]).T
    entries = []
    wrong = [np.nan, 1e5, 1e5, 1e5]
    for k, second in enumerate(time.tolist()):
        stamp = START + round(1e9 * second)
        data = joint_state(stamp, robot.active, u[k], du[k], wrong if k % 2 else ())
        entries.append((INPUT, JOINT_STATE, stamp, data))
        stamp += round(1e9 * late)
        data = pressures(stamp, CYLINDERS, cap[k], rod[k])
        entries.append((PRESSURE_INPUT, PRESSURES, stamp, data))
    return write(path, entries)


@pytest.fixture(scope="module")
def measured(excavator, tmp_path_factory):
    return measured_bag(tmp_path_factory.mktemp("measured") / "in", excavator)


def test_reports_compare_required_efforts_with_those_of_pressures(excavator, measured):
    recording = collect(measured, "excavator", smooth="spline")
    assert recording.pressed == CYLINDERS
    errors = {error.joint: error for error in effort_errors(recording)}
    for name in CYLINDERS:
        size = np.nanstd(recording.recorded[:, excavator.active.index(name)])
        assert errors[name].count > 1000
        assert errors[name].near < 1e-3 * size
    assert "boom_cylinder, stick_cylinder, bucket_cylinder: from the pressures" in facts_table(
        recording
    )


def test_reports_show_pressures_beside_those_that_the_model_needs(measured):
    recording = collect(measured, "excavator", smooth="spline")
    required = required_pressures(recording)
    assert tuple(required) == CYLINDERS
    for name, needed in required.items():
        cap = recording.pressures[name][:, 0]
        known = np.isfinite(cap) & np.isfinite(needed)
        assert known.sum() > 1000
        difference = np.abs(cap - needed)[known]
        assert np.quantile(difference, 0.95) < 1e-3 * cap[known].max()
    page = report(recording, "digging")
    assert "<h2>Pressures</h2>" in page
    assert page.index("<h2>Efforts</h2>") < page.index("<h2>Pressures</h2>")
    without = replace(recording, pressures={})
    assert "<h2>Pressures</h2>" not in report(without, "digging")


def test_parameters_are_identified_from_pressures(measured):
    call = ("identify", measured, "--robot", "excavator", "--links", "bucket", "--from", "0.1")
    found = json.loads(printed(*call, "--json"))
    assert found["from_pressures"] == list(CYLINDERS)
    assert found["worse_than_file"] == []
    assert list(found["held_out"]) == list(CYLINDERS)
    assert all(row["explained"] > 0.9999 for row in found["held_out"].values())
    source = collect(measured, "excavator").pressure_source
    assert pressure_lines(source)[0].startswith("Recorded efforts of boom_cylinder")


@pytest.mark.parametrize("active", [(), ("slew", "boom_pitch", "stick_pitch", "bucket_pitch")])
def test_efforts_of_pressures_have_the_power_of_the_cylinders(excavator, measured, active):
    """Wherever the active coordinates are: efforts times rates are forces times rates of rods."""
    robot = excavator
    if active:
        robot = Robot(replace(excavator.description, active=active))
    rng = np.random.default_rng(2)
    stamps = START + rng.integers(0, 12 * 10**9, 300)
    state = excavator.close(*swung(excavator, (stamps - START) * 1e-9)[:2])
    with BagReader(measured) as source:
        taken = PressureEfforts(robot, source, 0.2)
    by_name = dict(zip(excavator.coordinates, state.s.T, strict=True))
    u = np.stack([by_name[name] for name in robot.active], axis=1)
    rates = dict(zip(excavator.coordinates, state.ds.T, strict=True))
    du = np.stack([rates[name] for name in robot.active], axis=1)
    efforts = taken.efforts(stamps, robot.close(u, du))
    slew = robot.active.index("slew")
    others = [k for k in range(4) if k != slew]
    forces = taken.forces(stamps)[:, [robot.drives.index(name) for name in CYLINDERS]]
    speeds = np.stack([rates[name] for name in CYLINDERS], axis=1)
    is_there = np.isfinite(forces).all(axis=1)
    assert is_there.sum() > 290
    power = (efforts[:, others] * du[:, others]).sum(axis=1)
    np.testing.assert_allclose(power[is_there], (forces * speeds).sum(axis=1)[is_there], atol=1e-3)
    assert np.isnan(efforts[:, slew]).all()
    assert np.isnan(efforts[~is_there]).any(axis=1).all()


def test_readings_far_from_a_stamp_do_not_count(excavator, tmp_path):
    entries = []
    for second in (0.0, 0.1, 0.9):
        stamp = START + round(1e9 * second)
        data = pressures(stamp, CYLINDERS[:1], [1e7 * (1.0 + second)], [0.0])
        entries.append((PRESSURE_INPUT, PRESSURES, stamp, data))
    with BagReader(write(tmp_path / "in", entries)) as source:
        taken = PressureEfforts(excavator, source, 0.2)
    stamps = START + np.array([-1, 0, 50, 100, 150, 500, 900, 901]) * MS
    forces = taken.forces(stamps)[:, excavator.drives.index("boom_cylinder")]
    cylinder = excavator.cylinders["boom_cylinder"]
    area = cylinder.sign * cylinder.cap_area
    nan = np.nan
    expected = 1e7 * area * np.array([nan, 1.0, 1.05, 1.1, nan, nan, 1.9, nan])
    np.testing.assert_allclose(forces, expected, rtol=1e-12)
