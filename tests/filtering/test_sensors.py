"""Sensor files, and readings that no sensor can have taken."""

from __future__ import annotations

import json
import math
from functools import cache

import numpy as np
import pytest

from benchmarks.estimation.states import cycle, sensors
from hybrid_dynamics_core import DescriptionError, load
from hybrid_dynamics_core.estimation import SensorError
from hybrid_dynamics_core.filtering import (
    Kind,
    MotionModel,
    ObservabilityError,
    Quality,
    default_motion,
    estimate_states,
    sensor_on_joint,
    sensors_from_text,
)
from hybrid_dynamics_core.filtering.track import column_names
from hybrid_dynamics_ros.messages.imu import IMU
from hybrid_dynamics_ros.messages.interfaces import JOINT_STATE, typestore
from tests.bags.test_odometry import write
from tests.cli.calling import call
from tests.sampling import swept

FILE = """\
sensors:
  slew: {kind: encoder, joint: slew, noise: 0.05*deg}
  boom:
    kind: imu
    frame: boom
    origin: {xyz: [2.5, 0.7, 0.2], rpy: [0, 0, 0.3]}
    rate: 100
    gyro: {density: 0.014*deg, bias: 0.075*deg}
    accelerometer: {density: 0.00186, bias: 0.01}
    topic: /boom/imu
  stick: {kind: stroke, joint: stick_cylinder, noise: 0.0005}
  tilt: {kind: inclinometer, frame: bucket, noise: 0.1*deg}
motion:
  correlation_time: 0.4
  accelerations: {slew: 0.3}
"""


@cache
def excavator():
    return load("excavator")


@cache
def carried():
    return tuple(sensors(excavator()))


@cache
def recorded():
    """The first seconds of a cycle."""
    motion = cycle(excavator(), carried(), np.random.default_rng(4))
    rows = slice(150, 350, 5)
    return motion.time[rows], {name: values[rows] for name, values in motion.readings.items()}


def table(**changed):
    """Readings by sensor, some of them replaced."""
    time, readings = recorded()
    columns = {name: (time, values) for name, values in readings.items()}
    for name, values in changed.items():
        columns[name.replace("__", ".")] = values
    return columns


def estimated(columns):
    robot = excavator()
    return estimate_states(robot, carried(), columns, default_motion(robot))


def test_a_file_gives_the_sensors_and_the_motion():
    robot = excavator()
    given = sensors_from_text(FILE, robot)
    names = [sensor.name for sensor in given.sensors]
    assert names == ["slew", "boom.gyro", "boom.accelerometer", "stick", "tilt"]
    gyro = given.sensors[1]
    assert gyro.quality.noise == pytest.approx(math.radians(0.014) * math.sqrt(50.0))
    assert gyro.topic == "/boom/imu"
    assert given.motion.time == 0.4
    assert given.motion.accelerations.tolist() == [0.3, 0.5, 0.5, 0.5]


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("kind: encoder", "kind: encodr", r"2: sensors.slew.kind: there is no kind 'encodr'.*mean"),
        ("joint: slew", "joint: slw", r"2: sensors.slew: slew: there is no joint 'slw'.*'slew'"),
        ("frame: boom", "frame: base", r"3: sensors.boom: boom.gyro: 'base' is on the base"),
        ("rate: 100", "rte: 100", r"7: sensors.boom.rte: unknown key.*'rate'"),
        ("noise: 0.05*deg", "noise: 0", r"2: sensors.slew: noise is 0; expected"),
        ("noise: 0.05*deg", "bias: 1", r"2: sensors.slew: expected either noise .* or density"),
        ("    rate: 100\n", "", r"sensors.boom: no 'rate'; expected the readings per second"),
        ("kind: stroke, joint: stick_cylinder", "kind: stroke, joint: slew", "does not suit a rev"),
        ("accelerations: {slew: 0.3}", "accelerations: {slow: 0.3}", r"15: .*slow: unknown key"),
        ("correlation_time: 0.4", "correlation_time: 0", "correlation time is 0 s"),
        ("  tilt: {kind", "  tilt: [kind]\n  tilt2: {kind", r"12: sensors.tilt: is \['kind'\]"),
    ],
)
def test_a_wrong_file_is_refused_with_its_line(before, after, message):
    assert before in FILE
    with pytest.raises(DescriptionError, match=message):
        sensors_from_text(FILE.replace(before, after), excavator())


def test_readings_out_of_order_and_repeated_are_told():
    time, readings = recorded()
    time, readings = time[:15], {name: values[:15] for name, values in readings.items()}
    short = {name: (time, values) for name, values in readings.items()}
    order = np.arange(len(time))
    order[[10, 11]] = [11, 10]
    order = np.append(order, order[-1])
    plain = estimated(short)
    mixed = estimated({**short, "slew": (time[order], readings["slew"][order])})
    assert np.array_equal(plain.state.s, mixed.state.s)
    assert mixed.notes == (
        "slew: the clock goes back 1 time; sorted by stamps",
        "slew: 1 reading repeated; used once",
    )
    twice = time.copy()
    twice[5] = twice[4]
    with pytest.raises(SensorError, match=f"slew: two different readings.* {twice[4]:g} s"):
        estimated({**short, "slew": (twice, readings["slew"])})


def wrong(name, change):
    time, readings = recorded()
    return table(**{name.replace(".", "__"): (time, change(readings[name].copy()))})


def stuck(values):
    values[10:] = values[10]
    return values


WRONG = [
    ("boom.accelerometer", "in g", r"boom.acc.* it seems to be in g"),
    ("boom.accelerometer", "back", r"explains.*: boom.accelerometer contradicts.*opposite"),
    ("stick.gyro", "degrees", r"stick.gyro (contradicts.*in degrees|reads up to.*degrees)"),
    ("boom.gyro", "back", r"boom.gyro contradicts the other.*in the opposite direction"),
    ("stick.accelerometer", "axes", r"stick.accelerometer contradicts.*pose"),
    ("slew", "far", r"slew reads .* is it in degrees"),
    ("bucket.gyro", "stuck", r"bucket.gyro repeats .* to the last bit"),
]
CHANGES = {
    "in g": lambda values: values / 9.80665,
    "back": lambda values: -values,
    "degrees": np.rad2deg,
    "axes": lambda values: values[:, [1, 0, 2]],
    "far": lambda values: np.rad2deg(values) + 200.0,
    "stuck": stuck,
}
QUICK = ("bucket.gyro",)


@pytest.mark.parametrize(("name", "change", "message"), swept(WRONG, QUICK))
def test_a_wrong_sensor_is_told_by_name(name, change, message):
    with pytest.raises(SensorError, match=message):
        estimated(wrong(name, CHANGES[change]))


def test_a_stuck_stroke_sensor_is_told_though_nothing_checks_it():
    """It repeats to the last bit while others of its kind have noise."""
    robot = excavator()
    rng = np.random.default_rng(5)
    time = 0.02 * np.arange(150)
    kinds = [Kind.ENCODER, Kind.STROKE, Kind.STROKE, Kind.STROKE]
    sensors = []
    columns = {}
    for name, kind, start in zip(robot.active, kinds, robot.reference, strict=True):
        sensors.append(sensor_on_joint(robot, name, kind, name, Quality(1e-3)))
        moved = start + 0.1 * np.sin(time)
        columns[name] = (time, moved + 1e-3 * rng.normal(size=len(time)))
    motion = MotionModel(np.full(4, 0.3), 0.5)
    track = estimate_states(robot, sensors, columns, motion)
    assert track.unchecked == robot.active
    for first in (0, 60):
        values = columns["stick_cylinder"][1].copy()
        values[first:] = values[first]
        wrong = {**columns, "stick_cylinder": (time, values)}
        with pytest.raises(SensorError, match=r"stick_cylinder repeats .* seems stuck"):
            estimate_states(robot, sensors, wrong, motion)
    # a coarse sensor repeats too while its joint turns back
    slow = np.round(robot.reference[2] + 0.004 * np.sin(time), 3)
    coarse = {**columns, "stick_cylinder": (time, slow)}
    estimate_states(robot, sensors, coarse, motion)


@pytest.mark.sweep(sample="test_a_wrong_sensor_is_told_by_name")
def test_an_encoder_that_is_stuck_is_told_though_nothing_replaces_it():
    """While the house turns, as its gyro says."""
    motion = cycle(excavator(), carried(), np.random.default_rng(4))
    rows = slice(600, 800, 5)
    columns = {name: (motion.time[rows], values[rows]) for name, values in motion.readings.items()}
    columns["slew"] = (motion.time[rows], stuck(columns["slew"][1].copy()))
    with pytest.raises(SensorError, match="slew contradicts the other sensors; it seems stuck"):
        estimated(columns)


def test_a_clock_in_milliseconds_is_told():
    columns = {name: (1e3 * stamps, values) for name, (stamps, values) in table().items()}
    with pytest.raises(SensorError, match=r"s apart, .* milliseconds, divide it by 1000"):
        estimated(columns)


def test_without_an_encoder_slewing_is_not_determined():
    columns = table()
    del columns["slew"]
    with pytest.raises(ObservabilityError, match="do not determine slew: rank 7 of 8"):
        estimated(columns)


FILE_OF_TOPICS = """
sensors:
  slew: {kind: encoder, joint: slew, noise: 0.001}
  boom_pitch: {kind: encoder, joint: boom_pitch, noise: 0.001}
  stick: {kind: imu, frame: stick, gyro: {noise: 0.002}, accelerometer: {noise: 0.02}}
  bucket:
    {kind: imu, frame: bucket, gyro: {noise: 0.002}, accelerometer: {noise: 0.02}, topic: /bucket}
"""


def bag_entries(columns):
    """Messages of readings: topic, type, log time, data."""
    types = typestore().types
    vector, quaternion = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
    time = columns["slew"][0]
    entries = []
    for k, stamp in enumerate((1e9 * (time + 7.0)).round().astype(int).tolist()):
        sec, nanosec = divmod(stamp, 10**9)
        header = types["std_msgs/msg/Header"](
            types["builtin_interfaces/msg/Time"](sec, nanosec), ""
        )
        for link, topic in (("stick", "/hybrid_dynamics/imu/stick"), ("bucket", "/bucket")):
            rate, force = (
                vector(*columns[f"{link}.{part}"][1][k]) for part in ("gyro", "accelerometer")
            )
            turn, unset = quaternion(0.0, 0.0, 0.0, 1.0), np.zeros(9)
            message = types[IMU](header, turn, unset, rate, unset, force, unset)
            entries.append((topic, IMU, stamp, typestore().serialize_cdr(message, IMU)))
        names = ["boom_pitch", "gripper", "slew"]
        place = np.array([columns["boom_pitch"][1][k, 0], 9.0, columns["slew"][1][k, 0]])
        none = np.zeros(0)
        message = types[JOINT_STATE](header, names, place, none, none)
        data = typestore().serialize_cdr(message, JOINT_STATE)
        entries.append(("/joint_states", JOINT_STATE, stamp, data))
    return entries


@pytest.mark.sweep(sample="test_the_command_writes_states")
def test_a_bag_and_its_table_give_the_same_states(tmp_path):
    robot = excavator()
    given = sensors_from_text(FILE_OF_TOPICS, robot)
    time = 0.05 * np.arange(12)
    state = robot.close(robot.reference + np.array([0.2, 0.1, 0.1, 0.1]))
    rng = np.random.default_rng(1)
    columns = {}
    for sensor in given.sensors:
        exact = sensor.observe(state, np.zeros(4)).readings
        noise = sensor.quality.noise * rng.normal(size=(len(time), sensor.channels))
        columns[sensor.name] = (time, exact + noise)
    recording = write(tmp_path / "bag", bag_entries(columns))
    (tmp_path / "sensors.yaml").write_text(FILE_OF_TOPICS, encoding="utf-8")
    heads = ["time"] + [name for sensor in given.sensors for name in column_names(sensor)]
    table = np.concatenate([time[:, None], *(values for _, values in columns.values())], axis=1)
    np.savetxt(tmp_path / "data.csv", table, delimiter=",", header=",".join(heads), comments="")
    results = []
    for data in (recording, tmp_path / "data.csv"):
        words = ("estimate", str(data), "--robot", "excavator", "-o", str(tmp_path / "out.csv"))
        answer = call(*words, "--sensors", str(tmp_path / "sensors.yaml"))
        assert answer.exit_code == 0, answer.output
        results.append(np.loadtxt(tmp_path / "out.csv", delimiter=",", skiprows=1))
    assert np.allclose(*results, rtol=0.0, atol=1e-9)
    text = FILE_OF_TOPICS.replace("/bucket}", "/bukket}")
    (tmp_path / "sensors.yaml").write_text(text, encoding="utf-8")
    answer = call(
        "estimate", str(recording), *words[2:4], "--sensors", str(tmp_path / "sensors.yaml")
    )
    assert answer.exit_code == 1
    assert "no sensor_msgs/msg/Imu on /bukket for bucket.gyro" in answer.output


@pytest.fixture
def files(tmp_path):
    """A CSV file with the readings of FILE's sensors, and the file."""
    robot = excavator()
    given = sensors_from_text(FILE, robot)
    time = np.arange(0.0, 0.5, 0.02)
    state = robot.close(robot.reference + np.array([0.2, 0.1, 0.1, 0.1]))
    rng = np.random.default_rng(0)
    heads, columns = ["time [ms]"], [time * 1e3]
    for sensor in given.sensors:
        exact = sensor.observe(state, np.zeros(4)).readings
        for name, value in zip(column_names(sensor), exact, strict=True):
            heads.append(name)
            columns.append(value + sensor.quality.noise * rng.normal(size=len(time)))
    rows = [",".join(f"{value:.9g}" for value in row) for row in np.stack(columns, axis=1)]
    rows[3] = rows[3].rpartition(",")[0] + ","  # no reading
    (tmp_path / "data.csv").write_text("\n".join([",".join(heads), *rows]), encoding="utf-8")
    (tmp_path / "sensors.yaml").write_text(FILE, encoding="utf-8")
    return tmp_path, state


def test_the_command_writes_states(files):
    folder, truth = files
    words = ("estimate", str(folder / "data.csv"), "--robot", "excavator")
    words += ("--sensors", str(folder / "sensors.yaml"))
    answer = call(*words, "-o", str(folder / "out.csv"), "--json")
    assert answer.exit_code == 0, answer.output
    facts = json.loads(answer.stdout)
    assert facts["readings"]["tilt"]["used"] == facts["readings"]["slew"]["used"] - 1
    out = np.genfromtxt(folder / "out.csv", delimiter=",", names=True)
    assert len(out) == facts["states"] == 25
    for name, value in zip(excavator().coordinates, truth.s, strict=True):
        assert out[name][-1] == pytest.approx(value, abs=5e-3)
    assert out["boom_cylinder"][-1] == pytest.approx(truth.u[1], abs=4 * facts["deviation"]["slew"])
    text = (folder / "sensors.yaml").read_text(encoding="utf-8")
    (folder / "sensors.yaml").write_text(text.replace("encoder", "rate"), encoding="utf-8")
    answer = call(*words)
    assert answer.exit_code == 2
    assert "do not determine slew" in answer.output
