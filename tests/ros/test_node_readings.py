"""The node in its own process, and sensors as they are: that wrap, that lack what others have."""

import math

import numpy as np
import pytest
from hybrid_dynamics_msgs.msg import CylinderStates, ErrorCode, PayloadEstimate
from hybrid_dynamics_msgs.srv import ZeroPayload
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState

from hybrid_dynamics_core import Payload, load
from hybrid_dynamics_core.control import JointTrajectory
from tests.sampling import swept

ACTIVE = ["q1", "q12", "q22", "q4"]
AT = [2.95, 0.1, 0.15, 0.0]
COUNT = 40


def published(client, position, velocity=(), names=ACTIVE):
    """Publishes rows 10 ms apart; their stamps."""
    stamps = []
    for k, row in enumerate(position):
        stamps.append(client.new_stamp(0.01 if k else 10.0))
        rates = list(velocity[k]) if len(velocity) else []
        message = JointState(name=list(names), position=list(row), velocity=rates)
        client.publish("active_joint_states", message, stamps[-1])
    return stamps


def slewing():
    """The first joint turns through pi at 1 rad/s."""
    position = np.tile(AT, (COUNT, 1))
    position[:, 0] += 0.01 * np.arange(COUNT)
    return position


def efforts_of(client, stamps):
    """Efforts of the last 20 messages (20, 4)."""
    return np.array([client.wait_for("required_efforts", stamp).effort for stamp in stamps[-20:]])


@pytest.mark.parametrize("lowest", swept([-math.pi, 0.0], (-math.pi,)))
def test_an_encoder_that_begins_anew_is_no_motion(client, lowest):
    position = slewing()
    if lowest == 0.0:
        position[:, 0] += math.pi  # through 2 pi
    expected = efforts_of(client, published(client, position))
    readings = position.copy()
    readings[:, 0] = (readings[:, 0] - lowest) % (2.0 * math.pi) + lowest
    assert np.abs(np.diff(readings[:, 0])).max() > 6.0
    stamps = published(client, readings)
    np.testing.assert_allclose(efforts_of(client, stamps), expected, atol=1e-5)
    steps = np.diff([client.wait_for("joint_states", stamp).position[0] for stamp in stamps])
    np.testing.assert_allclose(steps, 0.01, atol=1e-9)
    client.wait_until(
        lambda: any("of q1 continued" in entry.value for entry in values_of(client)),
        "a count of the turns in the diagnostics",
    )


def values_of(client):
    return [value for status in list(client.diagnostics) for value in status.values]


def test_velocities_that_are_nan_are_absent(client):
    position = slewing()
    expected = efforts_of(client, published(client, position))
    nan = np.full_like(position, np.nan)
    assert np.array_equal(efforts_of(client, published(client, position, nan)), expected)


def test_velocities_in_turn_are_served(client):
    velocity = np.tile([1.0, 0.0, 0.0, 0.0], (COUNT, 1))
    in_turn = [velocity[k] if k % 2 else [] for k in range(COUNT)]
    stamps = published(client, slewing(), in_turn)
    whole = efforts_of(client, published(client, slewing(), velocity))
    np.testing.assert_allclose(efforts_of(client, stamps), whole, atol=1e-5)


@pytest.mark.sweep(sample="test_a_gripper_is_in_the_processed_bag")
def test_extra_joints_pass_through_where_the_node_is_told_so(start_node, connect):
    start_node("-r", "__ns:=/cell", "-p", "pass_through:=true")
    client = connect("/cell/hybrid_dynamics")
    stamp = client.new_stamp(10.0)
    message = JointState(name=["finger", *ACTIVE], position=[0.02, *AT], effort=[3.0] + [0.0] * 4)
    client.publish("active_joint_states", message, stamp)
    states = client.wait_for("joint_states", stamp)
    assert states.name[-1] == "finger"
    assert states.position[-1] == 0.02
    assert len(states.position) == 13


def measured_efforts(client, robot):
    """The answer to pressures of two cylinders, one of them without a reading."""
    pressures = CylinderStates(
        name=["boom_cylinder", "bucket_cylinder"],
        cap_pressure=[12e6, 2e6],
        rod_pressure=[1e6, math.nan],
    )
    state = JointState(name=list(robot.active), position=robot.reference.tolist())

    def answer():
        stamp = client.new_stamp(0.01)
        client.publish("cylinder_pressures", pressures, stamp)
        client.publish("active_joint_states", state, stamp)
        return client.received("measured_efforts", stamp - 100 * 10**6)

    return client.wait_until(answer, "efforts from pressures", 60.0)


def test_pressures_are_measured_efforts_and_bad_ones_cost_nothing_else(start_node, connect):
    node = start_node("-r", "__ns:=/dig", "-p", "robot:=excavator", "-p", "log_period:=0.0")
    client = connect("/dig/hybrid_dynamics", only=("describe_robot",))
    robot = load("excavator")
    measured = measured_efforts(client, robot)
    assert list(measured.name) == list(robot.drives)
    boom = robot.cylinders["boom_cylinder"]
    force = boom.sign * (12e6 * boom.cap_area - 1e6 * boom.rod_area)
    np.testing.assert_allclose(measured.effort, [math.nan, force, math.nan, math.nan])
    np.testing.assert_allclose(measured.position, robot.reference)

    names = [f"cylinder_{k}" for k in range(60_000)]
    good = CylinderStates(name=["boom_cylinder"], cap_pressure=[1e6], rod_pressure=[1e6])
    data = bytes(serialize_message(good))
    bad = (
        CylinderStates(name=names, cap_pressure=[1e6] * len(names)),
        CylinderStates(name=["boom_cylinder"]),
        CylinderStates(name=["q1"], cap_pressure=[1e6], rod_pressure=[1e6]),
        data[:23],
        data[:4] + b"\xff" * (len(data) - 4),
    )
    state = JointState(name=list(robot.active), position=robot.reference.tolist())
    stamps = []
    for message in 4 * bad:
        client.publish_as_it_is("cylinder_pressures", message)
        stamps.append(client.new_stamp(0.002))
        client.publish("active_joint_states", state, stamps[-1])
    for stamp in stamps:
        client.wait_for("joint_states", stamp)
    node.wait_for("rejected, too long: a message of [0-9]+ bytes, expected 131072 at most")
    client.wait_until(
        lambda: client.values("stream").get("pressures", "").endswith(f" {4 * len(bad)} rejected"),
        "a report that counts them",
    )
    assert client.values("stream")["counts"].count("rejected") == 0
    again = measured_efforts(client, robot)
    np.testing.assert_array_equal(again.effort, measured.effort)
    assert node.stop() == 0


def test_two_drivers_are_joined(client):
    position = slewing()
    expected = efforts_of(client, published(client, position))
    stamps = []
    for k, row in enumerate(position):
        stamps.append(client.new_stamp(0.01 if k else 10.0))
        for part in ([0, 3], [2, 1]):
            names = [ACTIVE[i] for i in part]
            message = JointState(name=names, position=row[part].tolist())
            client.publish("active_joint_states", message, stamps[-1])
    assert np.array_equal(efforts_of(client, stamps), expected)


@pytest.mark.sweep(sample="test_recordings_have_the_force_of_the_stream")
def test_the_force_at_the_tool_follows_from_pressures(start_node, connect):
    """A bucket that pushes down at rest: the wrench of the library, and none across the arm."""
    start_node("-r", "__ns:=/push", "-p", "robot:=excavator", "-p", "rates.tool_wrench:=0.0")
    client = connect("/push/hybrid_dynamics", only=("describe_robot",))
    robot = load("excavator")
    state = robot.close(robot.reference)
    push = np.array([1e4, 3e4, 0.0, 0.0, 0.0, 0.0])
    soil = robot.loads.with_wrench(push, axes="frame")
    cylinders = robot.hydraulics(state, robot.inverse_dynamics(state, np.zeros(4), soil))
    pressures = CylinderStates(
        name=list(cylinders),
        cap_pressure=[float(one.cap_pressure) for one in cylinders.values()],
        rod_pressure=[float(one.rod_pressure) for one in cylinders.values()],
    )
    message = JointState(
        name=list(robot.active), position=state.u.tolist(), velocity=[0.0] * len(robot.active)
    )

    def answer():
        stamp = client.new_stamp(0.02)
        client.publish("cylinder_pressures", pressures, stamp)
        client.publish("active_joint_states", message, stamp)
        return client.received("tool_wrench", stamp - 10 * 20 * 10**6)

    wrench = client.wait_until(answer, "a force at the tool", 60.0)
    assert wrench.header.frame_id == "end_effector"
    force = [wrench.wrench.force.x, wrench.wrench.force.y, wrench.wrench.force.z]
    np.testing.assert_allclose(force, [1e4, 3e4, math.nan], rtol=1e-6)
    assert wrench.wrench.torque.x == 0.0


@pytest.mark.sweep(sample="test_a_stream_weighs_the_load_and_an_empty_tool_zeroes_it")
def test_a_node_weighs_and_zeroes(start_node, connect):
    """A lift of a load as a stream: a mass, contact none, and zero refused without a motion."""
    start_node("-r", "__ns:=/scale", "-p", "robot:=excavator", "-p", "rates.payload:=0.0")
    client = connect("/scale/hybrid_dynamics", only=("zero_payload",))
    refused = client.call("zero_payload", ZeroPayload.Request())
    assert refused.error_code == ErrorCode.NOT_READY
    assert "0.0 s of motion" in refused.error_text
    robot = load("excavator")
    time = np.arange(0.0, 6.0, 0.04)
    stops = np.zeros((3, 4))
    points = [[0.0, 0.4, 1.05, 0.85], [0.5, 0.8, 1.0, 0.92], [0.8, 0.8, 0.7, 0.88]]
    goal = JointTrajectory([0.0, 3.0, 6.0], points, stops, stops)(time)
    state = robot.close(goal.u, goal.du)
    laden = robot.loads.with_payload(Payload(900.0, [-0.6, 0.35, 0.0]))
    cylinders = robot.hydraulics(state, robot.inverse_dynamics(state, goal.ddu, laden))
    stamps = []
    for k, u in enumerate(goal.u):
        stamps.append(client.new_stamp(0.04))
        pressures = CylinderStates(
            name=list(cylinders),
            cap_pressure=[float(one.cap_pressure[k]) for one in cylinders.values()],
            rod_pressure=[float(one.rod_pressure[k]) for one in cylinders.values()],
        )
        client.publish("cylinder_pressures", pressures, stamps[-1])
        message = JointState(name=list(robot.active), position=u.tolist())
        client.publish("active_joint_states", message, stamps[-1])
        client.wait_for("joint_states", stamps[-1])

    def weighed():
        for stamp in stamps:
            message = client.received("payload", stamp)
            if message is not None and message.quality != PayloadEstimate.NONE:
                return message
        return None

    reading = client.wait_until(weighed, "a mass on ~/payload", 60.0)
    assert reading.interval[0] < 900.0 < reading.interval[1]
    assert reading.problem == ""
    assert reading.header.frame_id == "end_effector"
    zeroed = client.call("zero_payload", ZeroPayload.Request())
    assert zeroed.error_code == ErrorCode.OK
    assert 5.0 < zeroed.duration < 6.0
    assert client.call("zero_payload", ZeroPayload.Request()).error_code == ErrorCode.NOT_READY
    assert client.call("zero_payload", ZeroPayload.Request(clear=True)).error_code == ErrorCode.OK


@pytest.mark.sweep(sample="test_a_stream_names_the_cylinders_with_exchanged_chambers")
def test_a_node_tells_which_chambers_seem_to_be_exchanged(start_node, connect):
    """At rest, cap and rod pressure of the boom come as rod and cap: diagnostics name the boom."""
    start_node("-r", "__ns:=/side", "-p", "robot:=excavator", "-p", "diagnostics.period:=0.1")
    client = connect("/side/hybrid_dynamics", only=("describe_robot",))
    robot = load("excavator")
    state = robot.close(robot.reference)
    cylinders = robot.hydraulics(state, robot.inverse_dynamics(state, np.zeros(4)))
    cap = [float(one.cap_pressure) for one in cylinders.values()]
    rod = [float(one.rod_pressure) for one in cylinders.values()]
    boom = list(cylinders).index("boom_cylinder")
    cap[boom], rod[boom] = rod[boom], cap[boom]
    pressures = CylinderStates(name=list(cylinders), cap_pressure=cap, rod_pressure=rod)
    message = JointState(
        name=list(robot.active), position=state.u.tolist(), velocity=[0.0] * len(robot.active)
    )

    def told():
        stamp = client.new_stamp(0.1)
        client.publish("cylinder_pressures", pressures, stamp)
        client.publish("active_joint_states", message, stamp)
        return "boom_cylinder" in client.values("stream").get("chambers", "")

    client.wait_until(told, "a warning in diagnostics", 60.0)
    assert "exchanged" in client.values("stream")["chambers"]
