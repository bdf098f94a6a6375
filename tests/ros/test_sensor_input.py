"""Sensors in place of joint states: the joints that they show go through the node as measured."""

from __future__ import annotations

import numpy as np
import pytest
from sensor_msgs.msg import Imu, JointState

from hybrid_dynamics_core import load
from hybrid_dynamics_core.filtering import read_sensors
from hybrid_dynamics_ros.messages.imu import sample_of_imu
from hybrid_dynamics_ros.messages.joint_samples import RejectedError
from hybrid_dynamics_ros.messages.sensor_topics import (
    SensorReading,
    SensorTopics,
    inertial_readings,
)
from hybrid_dynamics_ros.parameters import NodeSettings, ParameterError
from hybrid_dynamics_ros.stream.estimates.sensor_input import SensorInput, sensor_input_of
from hybrid_dynamics_ros.stream.results import MotionResult
from hybrid_dynamics_ros.stream.runtime import Runtime

FILE = """
sensors:
  slew: {kind: encoder, joint: slew, noise: 0.001}
  boom_pitch: {kind: encoder, joint: boom_pitch, noise: 0.001}
  stick: {kind: imu, frame: stick, gyro: {noise: 0.002}, accelerometer: {noise: 0.02}}
  bucket: {kind: imu, frame: bucket, gyro: {noise: 0.002}, accelerometer: {noise: 0.02}, topic: /b}
"""
START = 10**12  # [ns]
PERIOD = 10**7


@pytest.fixture
def path(tmp_path):
    """The file of sensors."""
    place = tmp_path / "sensors.yaml"
    place.write_text(FILE, encoding="utf-8")
    return place


def truth_of(robot):
    return robot.close(robot.reference + np.array([0.2, 0.1, 0.1, 0.1]))


def imu_message(sensors, state):
    """What a unit at rest reads."""
    gyro, accelerometer = (s.observe(state, np.zeros(4)).readings.tolist() for s in sensors)
    message = Imu()
    for axis, rate, force in zip("xyz", gyro, accelerometer, strict=True):
        setattr(message.angular_velocity, axis, rate)
        setattr(message.linear_acceleration, axis, force)
    return message


def test_readings_give_joints_as_if_they_were_measured(path):
    robot = load("excavator")
    settings = NodeSettings({"estimation.sensors": str(path), "estimation.rate": 50.0})
    runtime = Runtime(robot, settings)
    inputs, truth = runtime.sensors, truth_of(robot)
    assert list(inputs.topics.inertial) == ["~/imu/stick", "/b"]
    carried = {sensor.name: sensor for group in inputs.topics.inertial.values() for sensor in group}
    carried |= {sensor.name: sensor for group in inputs.topics.joints.values() for sensor in group}
    stamps, results = [], []
    for k in range(20):
        for name, sensor in carried.items():
            values = sensor.observe(truth, np.zeros(4)).readings
            sample = inputs.take([SensorReading(name, START + PERIOD * k, values)])
            if sample is not None:
                stamps.append(sample.stamp_ns)
                results.append(runtime.process(sample))
    assert np.diff(stamps).tolist() == [2 * PERIOD] * (len(stamps) - 1)
    assert all(isinstance(result, MotionResult) for result in results)
    np.testing.assert_allclose(results[-1].position, truth.s, atol=1e-3)
    assert results[-1].efforts is not None
    assert "slew" in inputs.describe()["deviations"]
    assert not inputs.doubtful
    for k in range(20, 30):  # ten wrong ones, each repeated for every late one of another sensor
        inputs.take([SensorReading("slew", START + PERIOD * k, np.array([1.5]))])
    angle = carried["boom_pitch"].observe(truth, np.zeros(4)).readings
    for k in range(5):
        inputs.take([SensorReading("boom_pitch", START + PERIOD * 20 + k, angle)])
    assert not inputs.doubtful
    for k in range(30, 60):
        inputs.take([SensorReading("slew", START + PERIOD * k, np.array([1.5]))])
    assert inputs.doubtful == ("slew",)
    entries = runtime.monitor._sensor_entries()
    assert entries[0].value == "slew"
    runtime.reset()
    assert inputs.describe()["readings used"] == "0"


def test_an_accelerometer_in_g_is_refused_by_name(path):
    robot = load("excavator")
    settings = NodeSettings({"estimation.sensors": str(path)})
    inputs = SensorInput(robot, robot.active, settings, path)
    carried = [sensor for group in inputs.topics.inertial.values() for sensor in group]
    carried += inputs.topics.joints["~/sensor_states"]
    readings = []
    for k in range(10):
        for sensor in carried:
            values = sensor.observe(truth_of(robot), np.zeros(4)).readings
            if sensor.name == "bucket.accelerometer":
                values = values / 9.80665
            readings.append(SensorReading(sensor.name, START + PERIOD * k, values))
    text = r"bucket\.accelerometer reads 1.* it seems to be in g"
    with pytest.raises(RejectedError, match=text):
        inputs.take(readings)


def test_what_is_not_measured_is_no_reading_and_what_is_not_finite_is_refused(path):
    robot = load("excavator")
    topics = SensorTopics(read_sensors(path, robot).sensors)
    sensors = topics.inertial["/b"]
    message = imu_message(sensors, truth_of(robot))
    message.angular_velocity_covariance[0] = -1.0
    names = [reading.sensor for reading in inertial_readings(sensors, sample_of_imu(message))]
    assert names == ["bucket.accelerometer"]
    message.linear_acceleration.x = np.nan
    with pytest.raises(RejectedError, match="linear_acceleration is"):
        sample_of_imu(message)


@pytest.mark.parametrize(
    ("before", "after", "text"),
    [
        ("kind: encoder, joint: slew", "kind: rate, joint: slew", "do not determine slew"),
        ("joint: slew", "joint: slw", "there is no joint 'slw'"),
    ],
)
def test_a_file_that_does_not_do_is_refused(path, before, after, text):
    path.write_text(FILE.replace(before, after), encoding="utf-8")
    robot = load("excavator")
    settings = NodeSettings({"estimation.sensors": str(path)})
    with pytest.raises(ParameterError, match=rf"parameter estimation.sensors: .*{text}"):
        sensor_input_of(robot, robot.active, settings)


@pytest.mark.sweep(sample="test_readings_give_joints_as_if_they_were_measured")
def test_the_node_takes_imus_and_publishes_all_joints(start_node, connect, path):
    robot = load("excavator")
    parameters = ("-p", "robot:=excavator", "-p", f"estimation.sensors:={path}")
    start_node("-r", "__ns:=/tilt", *parameters)
    client = connect("/tilt/hybrid_dynamics", only=("describe_robot",))
    truth = truth_of(robot)
    inputs = Runtime(robot, NodeSettings({"estimation.sensors": str(path)})).sensors.topics
    publishers = {}
    for topic in inputs.inertial:
        name = topic.replace("~", "/tilt/hybrid_dynamics")
        publishers[topic] = client._node.create_publisher(Imu, name, 100)
    encoders = client._node.create_publisher(JointState, "/tilt/hybrid_dynamics/sensor_states", 100)
    place = [truth.s[robot.coordinates.index(name)] for name in ("slew", "boom_pitch")]
    state = JointState(name=["slew", "boom_pitch"], position=place)

    def answer():
        stamp = client.new_stamp(0.01)
        for topic, sensors in inputs.inertial.items():
            message = imu_message(sensors, truth)
            message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 10**9)
            publishers[topic].publish(message)
        state.header.stamp.sec, state.header.stamp.nanosec = divmod(stamp, 10**9)
        encoders.publish(state)
        joints = client.received("joint_states", stamp - 20 * PERIOD)
        return joints is not None and errors(joints).max() < 2e-3

    def errors(joints):
        assert set(joints.name) == set(robot.coordinates)
        places = [robot.coordinates.index(name) for name in joints.name]
        return np.abs(np.array(joints.position) - truth.s[places])

    client.wait_until(answer, "joint states from sensors", 90.0)
