"""The process around the node: start, parameters, names, logging, end."""

import importlib.metadata
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
import rclpy
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus
from hybrid_dynamics_msgs.msg import ErrorCode
from hybrid_dynamics_msgs.srv import InverseDynamics, SolveFK
from rclpy.qos import QoSProfile, QoSReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from hybrid_dynamics_core import load
from hybrid_dynamics_ros.bags.settings import make_pipeline
from hybrid_dynamics_ros.messages.joint_samples import JointSample
from hybrid_dynamics_ros.node import qos
from hybrid_dynamics_ros.parameters import FILTER_TYPE, KALMAN, KALMAN_BANDWIDTH, NodeSettings
from tests.export.test_names import PUBLISHED, TEXT
from tests.sampling import swept

ACTIVE = ["q1", "q12", "q22", "q4"]
POSITION = [0.0, 0.1, 0.15, 0.0]
RATES = [0.17453292519943295, 0.01, 0.005, 0.08726646259971647]
TOUCHED = ("active_joint_states", "required_efforts")
READY = "active joints q1, q12, q22, q4"


def state(position=POSITION, velocity=RATES):
    return JointState(name=ACTIVE, position=list(position), velocity=list(velocity))


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_idle_node_cleanly(start_node, number):
    chosen = number == signal.SIGTERM
    node = start_node(*(["-p", "robot:=forging_chu2020"] if chosen else []))
    node.wait_for(READY)
    first = node.output().splitlines()[0]  # which robot it is, and whether anybody chose it
    assert first.endswith(
        "robot forging_chu2020" if chosen else "the default, -p robot:=NAME_OR_FILE takes another"
    )
    assert node.stop(number) == 0
    assert "stopped: 0 received" in node.output()
    assert "Traceback" not in node.output()


def test_parameters_of_joints_with_names_of_ros(start_node, tmp_path):
    """Sensors of joints whose names have / - and points, from a parameter file."""
    names = [*PUBLISHED[:9], "arm/slide-1", PUBLISHED[10], "2nd.wrist", *PUBLISHED[12:]]
    robot, settings = tmp_path / "arm.yaml", tmp_path / "node.yaml"
    robot.write_text(TEXT.format(*names))
    sensors = {"arm/slide-1": {"offset": 0.001}, "2nd.wrist": {"sign": -1.0}}
    parameters = {"robot": str(robot), "sensors": sensors}
    settings.write_text(json.dumps({"/**": {"ros__parameters": parameters}}))
    node = start_node("--params-file", str(settings))
    node.wait_for("active joints arm/slide-1, 2nd.wrist")
    assert node.stop() == 0
    assert "Traceback" not in node.output()


@pytest.mark.parametrize("number", swept([signal.SIGINT, signal.SIGTERM], [signal.SIGINT]))
def test_a_signal_repeated_while_messages_flow_ends_the_node_without_a_traceback(
    start_node, connect, number
):
    node = start_node()
    node.wait_for(READY)
    client = connect()
    client.publish("active_joint_states", state(), client.new_stamp())
    for k in range(200):
        client.publish("active_joint_states", state(), client.new_stamp(0.005))
        if k in (100, 110, 120):
            node.process.send_signal(number)
    while (
        node.process.poll() is None
    ):  # while it cleans up, too; the test's own time limit guards this
        node.process.send_signal(number)
        time.sleep(0.01)
    code = node.finish()
    assert code in (0, -number)  # a second one ends it at once, where no Python runs for a moment
    assert "Traceback" not in node.output()
    assert code or "stopped: " in node.output()


def test_the_installed_command_is_this_node(start_node):
    installed = [
        Path(str(d.locate_file("")))
        for d in importlib.metadata.distributions(name="hybrid_dynamics_ros")
    ]
    if not any(path.is_relative_to(sys.prefix) for path in installed):
        pytest.skip("the package is not installed in this environment")
    command = shutil.which("hybrid_dynamics_node", path=str(Path(sys.executable).parent))
    assert command is not None
    node = start_node(command=[command])
    node.wait_for(READY)
    assert node.stop() == 0


def fatal_line(node):
    """The one line that a node that could not start has said."""
    assert node.finish() == 1
    (line,) = node.output().strip().splitlines()
    assert "[FATAL]" in line
    return line


def test_an_unknown_robot_leaves_the_node_unconfigured_with_the_reason(start_node):
    node = start_node("-p", "robot:=no_such_robot")
    line = node.wait_for("stays unconfigured: .*").group()
    assert "no_such_robot" in line
    assert node.stop() == 0


def test_a_wrong_robot_file_is_told_with_its_line_and_a_mended_one_works_in_the_same_process(
    start_node, tmp_path, robot, connect
):
    shipped = (
        Path(sys.modules["hybrid_dynamics_core"].__file__).parent / "robots" / f"{robot.name}.yaml"
    )
    lines = shipped.read_text().splitlines(keepends=True)
    number = next(k for k, line in enumerate(lines) if line.startswith("gravity:"))
    lines[number] = "gravity: [0, 0, down]\n"
    wrong = tmp_path / "wrong.yaml"
    wrong.write_text("".join(lines))
    node = start_node("-p", f"robot:={wrong}", "-p", "diagnostics.period:=0.1")
    line = node.wait_for("stays unconfigured: .*").group()
    assert f"{wrong}:{number + 1}" in line
    assert "gravity" in line
    client = connect(only=("get_state", "solve_fk", "change_state"))
    assert client.state() == "unconfigured"
    refused = client.call("solve_fk", SolveFK.Request())
    assert refused.error_code == ErrorCode.NOT_READY
    client.wait_until(lambda: client.report("robot"), "a report")
    assert client.report("robot").level == DiagnosticStatus.ERROR
    assert f"{wrong}:{number + 1}" in client.report("robot").message
    assert not client.change("configure")

    wrong.write_text(shipped.read_text())
    assert client.change("configure")
    assert client.change("activate")
    client.connect()
    stamp = client.new_stamp()
    client.publish("active_joint_states", state(), stamp)
    assert len(client.wait_for("joint_states", stamp).position) == 12


def test_a_pipe_as_robot_is_refused_while_services_answer_and_a_file_in_its_place_works(
    start_node, tmp_path, robot, connect
):
    """Nobody writes into the pipe: opening it would wait for ever."""
    place = tmp_path / "robot.yaml"
    os.mkfifo(place)
    node = start_node("-p", f"robot:={place}")
    line = node.wait_for("stays unconfigured: .*").group()
    assert "seems to be a pipe; expected a robot description" in line
    client = connect(only=("get_state", "solve_fk", "change_state"))
    assert client.call("solve_fk", SolveFK.Request()).error_code == ErrorCode.NOT_READY
    place.unlink()
    shipped = Path(sys.modules["hybrid_dynamics_core"].__file__).parent / "robots"
    shutil.copy(shipped / f"{robot.name}.yaml", place)
    assert client.change("configure")
    assert node.stop() == 0


XACRO = """\
<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="prefix" default="a_"/>
  <xacro:arg name="mass" default="2"/>
  <link name="base"/>
  <link name="$(arg prefix)arm"><inertial><mass value="$(arg mass)"/><origin xyz="0.1 0 0"/>
    <inertia ixx="0.1" iyy="0.2" izz="0.2" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="$(arg prefix)joint" type="revolute"><parent link="base"/>
    <child link="$(arg prefix)arm"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="10" velocity="1"/></joint>
</robot>
"""


def test_arguments_reach_a_xacro_file_and_wrong_ones_are_named(start_node, tmp_path, connect):
    file = tmp_path / "arm.urdf.xacro"
    file.write_text(XACRO)
    arguments = "['prefix:=left_', 'weight:=3.5']"
    node = start_node("-p", f"robot:={file}", "-p", f"xacro_args:={arguments}")
    line = node.wait_for("stays unconfigured: .*").group()
    assert f"{file} has no argument 'weight'" in line
    client = connect(only=("get_state", "inverse_dynamics", "set_parameters", "change_state"))
    assert "NAME:=VALUE" in client.set_parameter("xacro_args", ["prefix"])
    assert client.set_parameter("xacro_args", ["prefix:=left_", "mass:=3.5"]) == ""
    assert client.change("configure")
    request = InverseDynamics.Request()
    request.motion.name = ["left_joint"]
    for values in (
        request.motion.position,
        request.motion.velocity,
        request.motion.acceleration,
    ):
        values.append(0.0)
    answer = client.call("inverse_dynamics", request)
    assert answer.error_text == ""
    np.testing.assert_allclose(answer.efforts.effort, [-3.5 * 9.81 * 0.1], rtol=1e-3)
    assert "only while the node is unconfigured" in client.set_parameter("xacro_args", [])
    assert node.stop() == 0


def test_a_copied_robot_file_starts(start_node, tmp_path, robot):
    shipped = (
        Path(sys.modules["hybrid_dynamics_core"].__file__).parent / "robots" / f"{robot.name}.yaml"
    )
    shutil.copy(shipped, tmp_path / "robot.yaml")
    node = start_node("-p", f"robot:={tmp_path / 'robot.yaml'}")
    node.wait_for(READY)
    assert node.stop() == 0


WRONG = ("acceleration_filter.bandwidth:=-1.0", "qos.input:=perfect", "bandwidth:=1.0")


@pytest.mark.parametrize(
    ("argument", "words"),
    swept(
        [
            ("acceleration_filter.bandwidth:=-1.0", ["acceleration_filter.bandwidth", "-1.0"]),
            ("acceleration_filter.bandwidth:=fast", ["acceleration_filter.bandwidth", "fast"]),
            ("qos.input:=perfect", ["qos.input", "perfect", "reliable, best_effort"]),
            ("qos.input_depth:=0", ["qos.input_depth", "0"]),
            ("robot:=''", ["robot"]),
            (
                "acceleration_filter.bandwith:=1.0",
                ["did you mean 'acceleration_filter.bandwidth'?"],
            ),
            ("bandwidth:=1.0", ["did you mean 'acceleration_filter.bandwidth'?"]),
            ("gravity:=[0.0, 1.0]", ["gravity", "expected 3 entries"]),
        ],
        WRONG,
    ),
)
def test_a_wrong_parameter_ends_in_one_line_and_a_failure(start_node, argument, words):
    line = fatal_line(start_node("-p", argument))
    assert all(word in line for word in words)


def test_a_wrong_ros_argument_ends_without_a_traceback(start_node):
    node = start_node("--params-file", "/nowhere/parameters.yaml")
    assert node.finish() == 1
    assert "/nowhere/parameters.yaml" in node.output()
    assert "Traceback" not in node.output()


def test_names_follow_the_namespace_and_the_node_name(start_node, connect):
    node = start_node("-r", "__ns:=/forge", "-r", "__node:=left_arm")
    node.wait_for(READY)
    client = connect("/forge/left_arm")
    stamp = client.new_stamp()
    client.publish("active_joint_states", state(), stamp)
    assert len(client.wait_for("joint_states", stamp).position) == 12
    client.wait_until(
        lambda: "/forge/left_arm" in client.node_names(), "the node's name in the graph"
    )
    assert not [name for name in client.topic_names() if name.startswith("/hybrid_dynamics")]


def test_bad_input_is_counted_and_logged_at_a_limited_rate(start_node, connect):
    node = start_node("-p", "log_period:=3600.0")
    node.wait_for(READY)
    client = connect()
    for _ in range(20):  # fewer than the subscription's queue holds, however slow the node
        client.publish("active_joint_states", state([np.nan, 0.1, 0.15, 0.0]), client.new_stamp())
        client.publish("active_joint_states", JointState(), client.new_stamp())
    last = client.new_stamp()
    client.publish("active_joint_states", state(), last)
    client.wait_for("joint_states", last)
    assert node.stop() == 0
    assert node.output().count("rejected, not finite") == 1
    assert node.output().count("rejected, empty") == 1
    assert "20 rejected: not finite" in node.output()
    assert "20 rejected: empty" in node.output()


def test_the_bandwidth_parameter_reaches_the_filter(start_node, connect):
    """At 1 Hz the filter needs 0.205 s of samples, at 10 Hz it would need a tenth of it."""
    node = start_node("-p", "acceleration_filter.bandwidth:=1.0")
    node.wait_for(READY)
    client = connect()
    stamps = []
    for k in range(25):
        stamps.append(client.new_stamp(10.0 if k == 0 else 0.01))
        client.publish("active_joint_states", state(), stamps[-1])
    client.wait_for("required_efforts", stamps[-1])
    with_efforts = [client.received("required_efforts", stamp) is not None for stamp in stamps]
    assert with_efforts == [k >= 21 for k in range(25)]


def test_the_kalman_filter_gives_the_bits_that_recordings_give(start_node, connect):
    group = "acceleration_filter"
    node = start_node("-p", f"{group}.type:=kalman", "-p", f"{group}.kalman.bandwidth:=20.0")
    node.wait_for(READY, 60.0)
    client = connect()
    settings = NodeSettings({FILTER_TYPE.name: KALMAN, KALMAN_BANDWIDTH.name: 20.0})
    pipeline = make_pipeline(load("forging_chu2020"), settings)
    expected = {}
    for k in range(30):
        t = 0.01 * k
        position = np.add(POSITION, [0.3 * t * t, 0.02 * np.sin(4 * t), 0.01 * t**3, t])
        velocity = np.array([0.6 * t, 0.08 * np.cos(4 * t), 0.03 * t * t, 1.0])[: 4 * (k % 3 > 0)]
        stamp = client.new_stamp(10.0 if k == 0 else 0.01)
        client.publish("active_joint_states", state(position, velocity), stamp)
        rates = velocity if velocity.size else None
        result = pipeline.process(JointSample(stamp, ACTIVE, position, rates))
        if result.efforts is not None:
            expected[stamp] = result.efforts
    assert len(expected) >= 25
    for stamp, efforts in expected.items():
        assert np.array_equal(client.wait_for("required_efforts", stamp).effort, efforts)
    reason = client.set_parameter("acceleration_filter.type", "polynomial")
    assert "acceleration_filter.type" in reason
    assert "cleanup" in reason
    assert client.set_parameter("acceleration_filter.kalman.velocity_noise", 30.0) == ""


def test_publishers_and_subscriptions_that_the_node_does_not_reach_are_reported(
    start_node, connect
):
    node = start_node("-p", "diagnostics.period:=0.1")
    node.wait_for(READY)
    client = connect(only=("get_state",))
    client.wait_until(lambda: client.values("stream").get("not connected") == "none", "a report")
    context = rclpy.Context()
    rclpy.init(context=context)
    other = rclpy.create_node("other", context=context)
    place = "/hybrid_dynamics"
    try:
        weak = QoSProfile(depth=10, reliability=QoSReliabilityPolicy.BEST_EFFORT)
        other.create_publisher(JointState, f"{place}/active_joint_states", weak)
        other.create_subscription(
            JointState, f"{place}/required_efforts", print, qos.transient_local()
        )

        def reported():
            text = client.values("stream")["not connected"]
            named = [f"{place}/{name} of /other" in text for name in TOUCHED]
            return all(named) and "Best effort publisher and reliable subscription" in text

        client.wait_until(reported, "both")
        node.wait_for("not connected: /hybrid_dynamics/active_joint_states of /other")
    finally:
        other.destroy_node()
        context.try_shutdown()
    client.wait_until(lambda: client.values("stream")["not connected"] == "none", "none")
    assert node.stop() == 0


def test_best_effort_input_connects_to_a_best_effort_publisher(start_node, connect):
    node = start_node("-p", "qos.input:=best_effort")
    node.wait_for(READY)
    client = connect()
    context = rclpy.Context()
    rclpy.init(context=context)
    sensor = rclpy.create_node("sensor", context=context)
    try:
        weak = QoSProfile(depth=10, reliability=QoSReliabilityPolicy.BEST_EFFORT)
        publisher = sensor.create_publisher(
            JointState, "/hybrid_dynamics/active_joint_states", weak
        )

        def answered():
            stamp = client.new_stamp()
            message = state()
            message.header.stamp.sec = stamp // 10**9
            publisher.publish(message)
            time.sleep(0.02)
            return client.received("joint_states", stamp)

        client.wait_until(answered, "an answer to a best-effort message")
    finally:
        sensor.destroy_node()
        context.try_shutdown()


def test_without_ros_the_command_says_how_to_get_it():
    code = (
        "import sys; sys.modules['rclpy'] = None; from hybrid_dynamics_ros.node.entry import main;"
        " sys.exit(main(['node']))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 1
    assert "the Python module rclpy is not there" in done.stderr
    assert "pip install" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("word", ["--help", "-h"])
def test_help_is_printed_with_ros_and_without(word):
    program = "from hybrid_dynamics_ros.node.entry import main"
    code = f"import sys; sys.modules['rclpy'] = None; {program}; sys.exit(main(['node', '{word}']))"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("usage: hybrid_dynamics_node --ros-args [-p robot:=NAME_OR_FILE]")


def test_with_simulated_time_ages_are_by_that_clock(start_node, connect):
    node = start_node("-p", "use_sim_time:=true", "-p", "diagnostics.period:=0.1")
    node.wait_for(READY)
    client = connect(only=("get_state",))
    context = rclpy.Context()
    rclpy.init(context=context)
    simulator = rclpy.create_node("simulator", context=context)
    try:
        clock = simulator.create_publisher(Clock, "/clock", 10)
        stamp = client.new_stamp()

        def age():
            clock.publish(Clock(clock=Time(sec=stamp // 10**9 + 3, nanosec=stamp % 10**9)))
            client.publish("active_joint_states", state(), stamp)
            return float(client.values("stream").get("age of the stamp [s]", "nan")) == 3.0

        client.wait_until(age, "an age of 3 s by /clock")
    finally:
        simulator.destroy_node()
        context.try_shutdown()


def test_a_joint_beyond_its_limit_is_logged_and_answered(start_node, connect, tmp_path):
    robots = resources.files("hybrid_dynamics_core").joinpath("robots")
    text = robots.joinpath("forging_chu2020.yaml").read_text(encoding="utf-8")
    own = "q1:  {type: revolute, parent: base, child: l1, axis: z"
    tool = "q4:  {type: revolute, parent: l42, child: l4, origin: {xyz: [L42, 0, 0]}, axis: x"
    assert own in text
    assert tool in text
    text = text.replace(own, f"{own}, limits: [-1, 1]").replace(tool, f"{tool}, limits: [-1, 1]")
    (tmp_path / "limited.yaml").write_text(text, encoding="utf-8")
    node = start_node("-p", f"robot:={tmp_path / 'limited.yaml'}")
    node.wait_for(READY)
    client = connect()
    message = state()
    message.position[list(message.name).index("q1")] = 1.5
    stamp = client.new_stamp(0.01)
    client.publish("active_joint_states", message, stamp)
    client.wait_for("joint_states", stamp)
    node.wait_for("q1 is beyond its upper limit by 0.5 rad; it is answered")
    message.position[list(message.name).index("q1")] = 0.0
    message.position[list(message.name).index("q4")] = 3.0  # at once, and for one input alone
    stamp = client.new_stamp(0.05)
    client.publish("active_joint_states", message, stamp)
    client.wait_for("joint_states", stamp)
    message.position[list(message.name).index("q4")] = 0.0
    client.publish("active_joint_states", message, client.new_stamp(0.05))
    node.wait_for("q4 is beyond its upper limit by 2 rad; it is answered")
