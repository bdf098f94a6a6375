"""Lifecycle, parameters and services of the running node."""

import re
import time

import numpy as np
import pytest
import rclpy
import yaml
from geometry_msgs.msg import InertiaStamped
from hybrid_dynamics_msgs.msg import ErrorCode, JointMotion
from hybrid_dynamics_msgs.srv import (
    CloseLoops,
    ComputeJacobian,
    ConvertTrajectory,
    DescribeRobot,
    ForwardDynamics,
    ListAssemblyModes,
    MinimalForm,
    SetPayload,
    SolveFK,
    SolveIK,
    SwitchAssemblyMode,
)
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.srv import SetParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import parameter_value_to_python
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from hybrid_dynamics_core import Payload, load
from hybrid_dynamics_core.export import to_urdf
from hybrid_dynamics_ros.bags.settings import read_settings
from hybrid_dynamics_ros.node import qos
from hybrid_dynamics_ros.parameters import PAYLOAD_MASS, TABLE

ParameterType = rclpy.Parameter.Type
ACTIVE = ["q1", "q12", "q22", "q4"]
POSITION = [0.0, 0.1, 0.15, 0.0]
RATES = [0.17453292519943295, 0.01, 0.005, 0.08726646259971647]


def state(position=POSITION, velocity=RATES, effort=()):
    return JointState(
        name=ACTIVE, position=list(position), velocity=list(velocity), effort=list(effort)
    )


def motion(position=POSITION, velocity=RATES, acceleration=(0.0,) * 4):
    return JointMotion(
        name=ACTIVE,
        position=list(position),
        velocity=list(velocity),
        acceleration=list(acceleration),
    )


@pytest.fixture
def late_listener():
    """Waits until a new subscription has these masses by frame; the inertias by frame."""

    def listen(wanted):
        context, told = rclpy.Context(), {}
        rclpy.init(context=context)
        late = rclpy.create_node("late", context=context)

        def collect(message):
            told[message.header.frame_id] = message.inertia

        profile = qos.transient_local(20)
        late.create_subscription(InertiaStamped, "/hybrid_dynamics/payloads", collect, profile)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(late)
        end = time.monotonic() + 60.0
        while any(name not in told or told[name].m != mass for name, mass in wanted.items()):
            assert time.monotonic() < end, told
            executor.spin_once(timeout_sec=0.1)
        executor.shutdown()
        late.destroy_node()
        context.try_shutdown()
        return told

    return listen


def efforts_now(client):
    stamp = client.new_stamp()
    client.publish("active_joint_motions", motion(), stamp)
    return np.array(client.wait_for("required_efforts", stamp).effort)


def test_the_closed_state_tells_residual_modes_and_margins(client, robot):
    stamp = client.new_stamp()
    client.publish("active_joint_motions", motion(), stamp)
    told, wanted = client.wait_for("closed_state", stamp), robot.close(POSITION, RATES)
    assert told.residual < 1e-12
    assert dict(zip(told.loops, told.branches, strict=True)) == dict(wanted.branch)
    np.testing.assert_allclose(told.singularity, wanted.distances)
    assert told.nearest_singularity == pytest.approx(wanted.singularity)
    assert told.nearest_loop == wanted.singular_loop
    k = list(told.stroke_joints).index("q12")
    low, high = robot.limits[1]
    np.testing.assert_allclose([told.to_lower[k], told.to_upper[k]], [0.1 - low, high - 0.1])


def test_twist_and_reactions_are_those_of_the_library(client, robot):
    stamp = client.new_stamp(1000.0)
    client.publish("active_joint_motions", motion(), stamp)
    twist = client.wait_for("end_effector_twist", stamp).twist
    closed = robot.close(POSITION, RATES)
    wanted = robot.jacobian(closed) @ RATES
    found = [getattr(part, axis) for part in (twist.linear, twist.angular) for axis in "xyz"]
    np.testing.assert_allclose(found, wanted, atol=1e-12)
    told, pins = client.wait_for("loop_reactions", stamp), robot.reactions(closed, np.zeros(4)).pins
    assert list(told.pins) == list(pins)
    for wrench, pin in zip(told.wrenches, pins.values(), strict=True):
        np.testing.assert_allclose(
            [wrench.force.x, wrench.force.y, wrench.force.z], pin.force, atol=1e-6
        )


def test_forward_dynamics_inverts_inverse_dynamics_with_the_payload_that_was_set(
    client, robot, node
):
    bare = efforts_now(client)
    request = SetPayload.Request()
    request.inertia.m, request.inertia.com.x = 25.0, 0.1
    try:
        assert client.call("set_payload", request).error_code == ErrorCode.OK
        node.wait_for(rf"\[INFO\].*: set_payload: 25 kg at {robot.end_effector}\n")
        laden = efforts_now(client)
        closed = robot.close(POSITION, RATES)
        loads = robot.loads.with_payload(Payload(25.0, [0.1, 0.0, 0.0]), robot.end_effector)
        np.testing.assert_allclose(
            laden, robot.inverse_dynamics(closed, np.zeros(4), loads), rtol=1e-12
        )
        assert np.abs(laden - bare).max() > 1.0
        answer = client.call(
            "forward_dynamics", ForwardDynamics.Request(active_joints=state(effort=laden))
        )
        assert answer.error_code == ErrorCode.OK, answer.error_text
        np.testing.assert_allclose(answer.motion.acceleration[:4], np.zeros(4), atol=1e-9)
    finally:
        request.inertia.m = 0.0
        assert client.call("set_payload", request).error_code == ErrorCode.OK
    node.wait_for(f"set_payload: nothing at {robot.end_effector}\n")
    np.testing.assert_allclose(efforts_now(client), bare, rtol=1e-12)


def test_a_latched_topic_tells_the_payloads_in_effect(client, late_listener):
    """Whoever comes late gets the newest of every frame, from calls and from parameters."""
    request = SetPayload.Request(frame="l4")
    request.inertia.m, request.inertia.com.z, request.inertia.ixy = 7.0, 0.2, 0.01
    request.inertia.ixx = request.inertia.iyy = request.inertia.izz = 0.1
    assert client.call("set_payload", request).error_code == ErrorCode.OK
    assert client.set_parameter("payload.mass", 3.0) == ""
    masses = late_listener({"end_effector": 3.0, "l4": 7.0})
    assert masses["l4"] == request.inertia
    request.inertia.m = 0.0
    assert client.call("set_payload", request).error_code == ErrorCode.OK
    assert client.set_parameter("payload.mass", 0.0) == ""
    late_listener({"end_effector": 0.0, "l4": 0.0})


def test_a_payload_that_is_none_is_refused(client):
    request = SetPayload.Request(frame="elbow")
    answer = client.call("set_payload", request)
    assert answer.error_code == ErrorCode.BAD_INPUT
    assert "elbow" in answer.error_text
    request = SetPayload.Request()
    request.inertia.m, request.inertia.ixx = 1.0, -1.0
    assert client.call("set_payload", request).error_code == ErrorCode.BAD_INPUT
    request = SetPayload.Request()
    request.inertia.m, request.inertia.com.x = 1e300, 1e5
    answer = client.call("set_payload", request)
    assert answer.error_code == ErrorCode.BAD_INPUT
    assert "payload.mass is 1e+300: expected a number from 0 to 1e+09 kg" in answer.error_text
    assert np.isfinite(efforts_now(client)).all()


def test_a_payload_at_a_frame_that_had_none_loses_no_input(client):
    """Its code is generated beside the stream."""
    bare, request = efforts_now(client), SetPayload.Request(frame="l3")
    request.inertia.m = 12.0
    told, stamps = client.call_async("set_payload", request), []
    while not told.done() or len(stamps) < 10:
        assert len(stamps) < 1000, "no answer"
        stamps.append(client.new_stamp())
        client.publish("active_joint_motions", motion(), stamps[-1])
        time.sleep(0.01)
    assert told.result().error_code == ErrorCode.OK
    for stamp in stamps:
        client.wait_for("required_efforts", stamp)
    assert np.abs(efforts_now(client) - bare).max() > 1.0
    request.inertia.m = 0.0
    assert client.call("set_payload", request).error_code == ErrorCode.OK


def test_every_parameter_that_is_listed_has_a_value(client):
    values = client.parameters()
    assert {row.name for row in TABLE} < set(values)
    assert {
        name for name, value in values.items() if value.type == ParameterType.NOT_SET.value
    } == set()
    for name in ("gravity", "measured"):
        assert parameter_value_to_python(values[name]) == []
    assert values["gravity"].type == ParameterType.DOUBLE_ARRAY.value
    assert values["measured"].type == ParameterType.STRING_ARRAY.value


# what `ros2 param set gravity []`, `ros2 param delete gravity` and a program of rclpy send
@pytest.mark.parametrize("kind", ["BOOL_ARRAY", "NOT_SET", "DOUBLE_ARRAY", "BYTE_ARRAY"])
def test_what_was_set_can_be_unset(client, kind):
    before = efforts_now(client)
    assert client.set_parameter("gravity", [0.0, 0.0, -1.62]) == ""
    assert np.abs(efforts_now(client) - before).max() > 1.0
    message = ParameterMessage(name="gravity")
    message.value.type = ParameterType[kind].value
    (result,) = client.call("set_parameters", SetParameters.Request(parameters=[message])).results
    assert result.successful, result.reason
    assert parameter_value_to_python(client.parameters()["gravity"]) == []
    np.testing.assert_array_equal(efforts_now(client), before)


def test_a_dump_of_all_parameters_is_taken_and_read(client, start_node, connect, tmp_path):
    """As `ros2 param dump` writes it: empty arrays for what is not set."""
    values = {name: parameter_value_to_python(value) for name, value in client.parameters().items()}
    changed = {**values, "payload.mass": 3.0, "autostart": False}
    (tmp_path / "dump.yaml").write_text(yaml.safe_dump({"/**": {"ros__parameters": changed}}))
    start_node("--params-file", str(tmp_path / "dump.yaml"), "-r", "__ns:=/dump")
    second = connect("/dump/hybrid_dynamics", only=("list_parameters",))
    told = second.parameters()
    for row in TABLE:
        assert parameter_value_to_python(told[row.name]) == changed[row.name], row.name
    assert read_settings(tmp_path / "dump.yaml")[PAYLOAD_MASS] == 3.0


def test_jacobian_and_minimal_form_are_those_of_the_library(client, robot):
    closed = robot.close(POSITION, RATES)
    jacobian = client.call("compute_jacobian", ComputeJacobian.Request(active_joints=state()))
    assert list(jacobian.joints) == ACTIVE
    np.testing.assert_allclose(
        np.reshape(jacobian.jacobian, (6, 4)), robot.jacobian(closed), atol=1e-12
    )
    form, (M, h, g) = (
        client.call("minimal_form", MinimalForm.Request(active_joints=state())),
        robot.minimal_form(closed),
    )
    np.testing.assert_allclose(np.reshape(form.inertia, (4, 4)), M, rtol=1e-12)
    np.testing.assert_allclose(form.coriolis, h, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(form.gravity, g, rtol=1e-12, atol=1e-12)


def test_any_independent_joints_close_the_loops(client, robot):
    closed = robot.close(POSITION, RATES)
    names = ["q1", "q2", "q3", "q4"]
    places = [robot.coordinates.index(name) for name in names]
    given = JointMotion(
        name=names, position=closed.s[places].tolist(), velocity=closed.ds[places].tolist()
    )
    answer = client.call("close_loops", CloseLoops.Request(given=given))
    assert answer.error_code == ErrorCode.OK, answer.error_text
    np.testing.assert_allclose(answer.motion.position, closed.s, atol=1e-9)
    np.testing.assert_allclose(answer.motion.velocity, closed.ds, atol=1e-9)
    assert answer.closed_state.residual < 1e-9
    few = client.call(
        "close_loops", CloseLoops.Request(given=JointMotion(name=["q1"], position=[0.0]))
    )
    assert few.error_code == ErrorCode.BAD_INPUT
    assert "4 degrees of freedom" in few.error_text


def test_a_target_in_part_of_its_coordinates_is_reached(client, robot):
    tool = robot.forward_kinematics(robot.close(POSITION)).position
    request = SolveIK.Request(mask=[True, False, True, False, False, False])
    request.target.pose.position.x, request.target.pose.position.z = (
        float(tool[0]) + 0.01,
        float(tool[2]),
    )
    answer = client.call("solve_ik", request)
    assert answer.error_code == ErrorCode.OK, answer.error_text
    found = robot.forward_kinematics(robot.close(np.array(answer.solution.position[:4]))).position
    np.testing.assert_allclose(found[[0, 2]], [tool[0] + 0.01, tool[2]], atol=1e-8)
    request.mask = [True]
    assert client.call("solve_ik", request).error_code == ErrorCode.BAD_INPUT


def test_the_robot_describes_itself(client, robot):
    told = client.call("describe_robot", DescribeRobot.Request())
    assert told.error_code == ErrorCode.OK
    assert (told.name, list(told.joints), list(told.active)) == (
        robot.name,
        list(robot.coordinates),
        ACTIVE,
    )
    np.testing.assert_allclose(np.array([told.lower, told.upper]).T[:4], robot.limits)


def test_modes_are_listed_and_switched_only_while_the_robot_stands(client, robot, node):
    began = client.new_stamp()
    client.publish("active_joint_motions", motion(), began)
    client.wait_for("joint_states", began)
    listed = client.call("list_assembly_modes", ListAssemblyModes.Request(active_joints=state()))
    assert len(listed.modes) == len(robot.assembly_modes(POSITION)) > 1
    own = listed.modes[listed.current]
    other = next(mode for k, mode in enumerate(listed.modes) if k != listed.current)
    switch = SwitchAssemblyMode.Request(loops=other.loops, branches=other.branches)
    moving = client.call("switch_assembly_mode", switch)
    assert moving.error_code == ErrorCode.REFUSED

    def positions():
        stamp = client.new_stamp()
        client.publish("active_joint_motions", motion(velocity=[0.0] * 4), stamp)
        return client.wait_for("joint_states", stamp).position

    np.testing.assert_allclose(positions(), own.joint_state.position, atol=1e-9)
    try:
        answer = client.call("switch_assembly_mode", switch)
        assert answer.error_code == ErrorCode.OK, answer.error_text
        modes = ", ".join(
            f"{loop} {branch}" for loop, branch in zip(other.loops, other.branches, strict=True)
        )
        node.wait_for(rf"\[INFO\].*: switch_assembly_mode: {re.escape(modes)}\n")
        np.testing.assert_allclose(positions(), other.joint_state.position, atol=1e-9)
        pose = client.call("solve_fk", SolveFK.Request(active_joints=state())).poses[0]
        found = client.call("solve_ik", SolveIK.Request(position_only=True, target=pose))
        assert found.error_code == ErrorCode.OK, found.error_text
        assert dict(zip(found.loops, found.branches, strict=True)) == dict(
            zip(other.loops, other.branches, strict=True)
        )
    finally:
        client.call(
            "switch_assembly_mode",
            SwitchAssemblyMode.Request(loops=own.loops, branches=own.branches),
        )
    np.testing.assert_allclose(positions(), own.joint_state.position, atol=1e-9)
    wrong = client.call(
        "switch_assembly_mode", SwitchAssemblyMode.Request(loops=["knee"], branches=["up"])
    )
    assert wrong.error_code == ErrorCode.BAD_INPUT
    assert "knee" in wrong.error_text


def trajectory(rows, names=ACTIVE):
    message = JointTrajectory(joint_names=list(names))
    for k, row in enumerate(rows):
        point = JointTrajectoryPoint(positions=[float(value) for value in row])
        point.time_from_start.sec, point.time_from_start.nanosec = k // 2, 500_000_000 * (k % 2)
        message.points.append(point)
    return message


def asked_for(points):
    """The points of an answer at the times of `trajectory`, of those that it has."""
    of_time = {(p.time_from_start.sec, p.time_from_start.nanosec): p for p in points}
    times = [(k // 2, 500_000_000 * (k % 2)) for k in range(len(points))]
    return [of_time[time] for time in times if time in of_time]


def test_a_trajectory_of_serial_joints_becomes_one_of_active_joints_with_efforts(client, robot):
    u = np.array(POSITION) + np.linspace(0.0, 1.0, 9)[:, None] * np.array([0.2, 0.02, 0.02, 0.1])
    s = robot.close(u).s
    names = ["q1", "q2", "q3", "q4"]
    rows = s[:, [robot.coordinates.index(name) for name in names]]
    request = ConvertTrajectory.Request(joints=trajectory(rows, names))
    answer = client.call("convert_trajectory", request)
    assert answer.error_code == ErrorCode.OK, answer.error_text
    assert answer.first_bad == -1
    points = asked_for(answer.trajectory.points)
    np.testing.assert_allclose([p.positions for p in points], u, atol=1e-8)
    np.testing.assert_allclose(points[0].velocities, 0.0, atol=1e-9)
    middle = points[4]
    wanted = robot.inverse_dynamics(
        robot.close(middle.positions, middle.velocities), middle.accelerations
    )
    np.testing.assert_allclose(middle.effort, wanted, rtol=1e-6)
    stamp = client.new_stamp()
    client.publish("joint_trajectory", request.joints, stamp)
    assert len(asked_for(client.wait_for("active_joint_trajectory", stamp).points)) == 9


def test_the_first_bad_point_of_a_trajectory_is_named(client):
    u = np.array(POSITION) + np.linspace(0.0, 1.0, 9)[:, None] * np.array([0.0, 0.9, 0.0, 0.0])
    answer = client.call("convert_trajectory", ConvertTrajectory.Request(joints=trajectory(u)))
    assert answer.error_code in (ErrorCode.LIMIT, ErrorCode.OUT_OF_REACH, ErrorCode.SINGULAR)
    assert 0 < answer.first_bad < 9
    assert len(asked_for(answer.trajectory.points)) == answer.first_bad
    assert f"point {answer.first_bad} at" in answer.error_text


def test_a_path_of_the_end_effector_becomes_a_trajectory(client, robot):
    from geometry_msgs.msg import PoseStamped

    u = np.array(POSITION) + np.linspace(0.0, 1.0, 5)[:, None] * np.array([0.2, 0.02, 0.02, 0.0])
    tool = robot.forward_kinematics(robot.close(u)).position
    request = ConvertTrajectory.Request(position_only=True, start=state())
    for k, place in enumerate(tool):
        pose = PoseStamped()
        pose.header.stamp.sec = 10 + k
        pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = place.tolist()
        request.path.append(pose)
    answer = client.call("convert_trajectory", request)
    assert answer.error_code == ErrorCode.OK, answer.error_text
    found = robot.forward_kinematics(
        robot.close(np.array([p.positions for p in answer.trajectory.points]))
    ).position
    times = [
        p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec for p in answer.trajectory.points
    ]
    np.testing.assert_allclose(found[np.isin(times, np.arange(5.0))], tool, atol=1e-7)
    request.path[3].pose.position.z = 50.0
    answer = client.call("convert_trajectory", request)
    assert answer.error_code == ErrorCode.OUT_OF_REACH
    assert answer.first_bad == 3
    assert answer.trajectory.points[-1].time_from_start.sec == 2


def test_parameters_are_checked_before_they_are_taken_and_work_at_once(client, robot):
    reason = client.set_parameter("acceleration_filter.bandwidth", -1.0)
    assert all(word in reason for word in ("acceleration_filter.bandwidth", "0.01", "1000"))
    assert client.set_parameter("acceleration_filter.bandwidth", 20) == ""
    assert "cleanup" in client.set_parameter("robot", "excavator")
    assert "elbow" in client.set_parameter("payload.frame", "elbow")
    bare = efforts_now(client)
    for frame in (
        "",
        robot.description.frames[robot.end_effector].link,
    ):  # the payload moves with its frame
        assert client.set_parameter("payload.frame", frame) == ""
        assert client.set_parameter("payload.mass", 3) == ""
        loads = robot.loads.with_payload(Payload(3.0), frame or robot.end_effector)
        wanted = robot.inverse_dynamics(robot.close(POSITION, RATES), np.zeros(4), loads)
        np.testing.assert_allclose(efforts_now(client), wanted, rtol=1e-12)
    assert client.set_parameter("payload.mass", 0) == ""
    assert client.set_parameter("payload.frame", "") == ""
    assert client.set_parameter("gravity", [0.0, 0.0, 0.0]) == ""
    weightless = robot.inverse_dynamics(
        robot.close(POSITION, RATES), np.zeros(4), robot.loads.with_gravity([0, 0, 0])
    )
    np.testing.assert_allclose(efforts_now(client), weightless, rtol=1e-9, atol=1e-9)
    assert (
        client.set_parameter("gravity", [float(value) for value in robot.description.gravity]) == ""
    )
    np.testing.assert_allclose(efforts_now(client), bare, rtol=1e-12)
    assert client.set_parameter("sensors.q12.offset", 0.02) == ""
    stamp = client.new_stamp()
    client.publish("active_joint_motions", motion(), stamp)
    assert client.wait_for("joint_states", stamp).position[1] == pytest.approx(0.08)
    assert "1.0 or -1.0" in client.set_parameter("sensors.q12.sign", 0.5)
    assert client.set_parameter("sensors.q12.offset", 0.0) == ""


def test_the_description_is_there_for_those_who_come_late(client, robot):
    context = rclpy.Context()
    rclpy.init(context=context)
    late = rclpy.create_node("late", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(late)
    told = []
    try:
        late.create_subscription(String, "/robot_description", told.append, qos.transient_local())

        def heard():
            executor.spin_once(timeout_sec=0.1)
            return told

        client.wait_until(heard, "the description")
        assert told[0].data == to_urdf(robot.description)
    finally:
        executor.shutdown()
        late.destroy_node()
        context.try_shutdown()


def test_reports_go_out(client, robot):
    client.wait_until(lambda: "residual" in client.values("robot"), "a report")
    values = {**client.values("stream"), **client.values("robot")}
    assert {
        "rate [Hz]",
        "age of the stamp [s]",
        "residual",
        "singularity margin",
        "stroke margin",
    } <= set(values)
    client.call("describe_robot", DescribeRobot.Request())
    client.wait_until(lambda: "describe_robot" in client.values("services"), "the call")
    assert {"short", "search", "long"} <= set(client.values("workers"))
    subjects = ("stream", "services", "workers", "robot")
    assert {client.report(subject).hardware_id for subject in subjects} == {robot.name}


def test_another_robot_is_configured_in_the_same_process(start_node, connect):
    node = start_node("-p", "autostart:=false", "-r", "__ns:=/second")
    client = connect(
        "/second/hybrid_dynamics",
        only=("get_state", "solve_fk", "describe_robot", "change_state", "set_parameters"),
    )
    assert client.state() == "unconfigured"
    assert client.call("solve_fk", SolveFK.Request()).error_code == ErrorCode.NOT_READY
    assert not client.change("activate")
    for name in ("forging_chu2020", "palletizer", "excavator"):
        assert client.set_parameter("robot", name) == ""
        assert client.change("configure")
        assert client.change("activate")
        assert client.call("describe_robot", DescribeRobot.Request()).name == name
        robot = load(name)
        message = JointState(name=list(robot.active), position=robot.reference.tolist())

        def answered(robot=robot, message=message):
            stamp = client.new_stamp()
            client.publish("active_joint_states", message, stamp)
            time.sleep(0.05)
            told = client.received("joint_states", stamp)
            return told is not None and list(told.name) == list(robot.coordinates)

        client.wait_until(answered, f"joint states of {name}")
        assert client.change("deactivate")
        assert client.change("cleanup")
        assert client.call("solve_fk", SolveFK.Request()).error_code == ErrorCode.NOT_READY
    assert client.change("shutdown")
    assert node.stop() == 0
    assert "Traceback" not in node.output()


def test_serial_joints_may_be_measured_in_place_of_cylinders(start_node, connect, robot):
    arguments = (
        "-p",
        "measured:=[q1, q2, q3, q4]",
        "-p",
        "sensors.q2.scale:=0.001",
        "-r",
        "__ns:=/third",
    )
    start_node(*arguments).wait_for("measured joints")
    client = connect("/third/hybrid_dynamics", only=("get_state",))
    closed = robot.close(POSITION, RATES)
    names = ["q1", "q2", "q3", "q4"]
    reading = closed.s[[robot.coordinates.index(name) for name in names]] * [1.0, 1000.0, 1.0, 1.0]

    def told():
        stamp = client.new_stamp()
        client.publish(
            "active_joint_states", JointState(name=names, position=reading.tolist()), stamp
        )
        time.sleep(0.05)
        return client.received("joint_states", stamp)

    np.testing.assert_allclose(client.wait_until(told, "an answer").position, closed.s, atol=1e-9)
