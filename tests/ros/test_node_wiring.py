"""The node in this process, callbacks called by hand.

Faults that no message from outside can provoke.
"""

import math
import sys
import time
from pathlib import Path
from queue import SimpleQueue
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest
import rclpy
from geometry_msgs.msg import Quaternion, Transform, TransformStamped, Vector3
from hybrid_dynamics_msgs.msg import ErrorCode, JointMotion
from hybrid_dynamics_msgs.srv import DescribeRobot, SolveIK
from rclpy.duration import Duration
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from hybrid_dynamics_core.errors import InputError
from hybrid_dynamics_ros.actions.goals import GoalServer
from hybrid_dynamics_ros.messages import conversions
from hybrid_dynamics_ros.messages.joint_samples import RejectionCode
from hybrid_dynamics_ros.node import subscriptions
from hybrid_dynamics_ros.node.lifecycle import HybridDynamicsNode
from hybrid_dynamics_ros.services.table import TABLE
from hybrid_dynamics_ros.stream.topics import TOPICS


class Faulty:
    """A robot that has a bug; all else is that of a real one."""

    def __init__(self, robot):
        self._robot = robot

    def __getattr__(self, name):
        return getattr(self._robot, name)

    def close(self, *_, **__):
        raise ZeroDivisionError("a bug")


@pytest.fixture
def ros_node():
    context = rclpy.Context()
    rclpy.init(context=context)
    node = HybridDynamicsNode(context=context, namespace="wired")
    yield node
    node.discard()
    node.destroy_node()
    context.try_shutdown()


def receive(node, topic, data):
    """Hands bytes to the node as if they had come: topic 0 is of states, 1 of motions."""
    source = node._stream.inputs[topic]
    source.queue.put(bytes(data))
    node._stream._on_message(source)


MESSAGE = JointState(name=["q1", "q12", "q22", "q4"], position=[0.0, 0.1, 0.15, 0.0])


def test_a_bug_in_the_model_is_logged_with_its_place_counted_and_survived(ros_node, capfd):
    ros_node.start()
    runtime = ros_node._runtime
    runtime.evaluator.robot = Faulty(runtime.robot)
    for _ in range(3):
        receive(ros_node, 0, serialize_message(MESSAGE))
    assert "3 received, 0 accepted, 0 with efforts, 3 rejected: internal" in ros_node.summary()
    logged = capfd.readouterr().err
    assert logged.count("ZeroDivisionError: a bug") == 1  # once in a period
    assert "pipeline.py" in logged


def test_messages_that_cannot_be_read_count_as_received_and_rejected(ros_node):
    """Cut short anywhere: what is received is what is accepted and what is rejected, never less
    than nothing.
    """
    ros_node.start()
    whole = serialize_message(MESSAGE)
    counts = ros_node._runtime.pipeline.counts
    for size in (*range(4, len(whole), 9), len(whole)):
        receive(ros_node, 0, whole[:size])
        receive(ros_node, 1, whole[:size])
        assert counts.accepted >= 0
    assert counts.received == 2 * len(range(4, len(whole), 9)) + 2
    assert counts.rejected[RejectionCode.INTERNAL] > 0
    assert counts.received == counts.accepted + counts.rejected.total()
    assert counts.accepted > 0


def test_what_waits_while_the_node_is_not_active_is_counted_and_not_answered(ros_node):
    ros_node.start()
    stream = ros_node._stream
    data = bytes(serialize_message(MESSAGE))
    for _ in range(3):
        stream.inputs[0].queue.put(data)
    ros_node.trigger_deactivate()
    stream._on_resume()
    receive(ros_node, 1, data)
    monitor = ros_node._runtime.monitor
    assert monitor.inactive == 4
    assert ros_node._runtime.pipeline.counts.received == 0
    ros_node.trigger_activate()
    receive(ros_node, 0, data)
    assert ros_node._runtime.pipeline.counts.received == 1


def test_messages_that_nobody_took_before_the_end_are_in_the_last_line(ros_node, capfd):
    """Some wait in the subscription, some in the queue behind it."""
    ros_node.start()
    stream = ros_node._stream
    others = ros_node.create_publisher(JointState, stream.inputs[0].name, 20)
    end = time.monotonic() + 30.0
    while not others.get_subscription_count() and time.monotonic() < end:
        time.sleep(0.01)
    for _ in range(12):
        others.publish(MESSAGE)
    assert others.wait_for_all_acked(Duration(seconds=30))
    for _ in range(3):
        stream.inputs[0].queue.put(bytes(serialize_message(MESSAGE)))
    ros_node.trigger_deactivate()
    ros_node.trigger_cleanup()
    told = capfd.readouterr().err
    assert "stopped: 0 received" in told
    assert "15 left out while not active" in told


def test_a_reader_with_a_bug_is_counted_as_a_rejection_of_what_was_received(
    ros_node, capfd, monkeypatch
):
    def broken(_):
        raise ZeroDivisionError("a bug")

    monkeypatch.setattr(subscriptions, "StateReader", lambda **_: broken)
    ros_node.start()
    for _ in range(3):
        receive(ros_node, 0, serialize_message(MESSAGE))
    assert "3 received, 0 accepted, 0 with efforts, 3 rejected: internal" in ros_node.summary()
    assert "ZeroDivisionError: a bug" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (ZeroDivisionError("a bug"), RejectionCode.INTERNAL),
        (InputError("too large"), RejectionCode.OVERFLOW),
    ],
)
def test_efforts_that_cannot_be_told_are_not_counted(ros_node, error, code):
    def broken(_):
        raise error

    ros_node.start()
    outputs = ros_node._stream._publishers.outputs
    outputs[0] = outputs[0]._replace(fill=broken)
    listener = ros_node.create_subscription(JointState, "~/joint_states", lambda _: None, 1)
    motion = JointMotion(
        name=MESSAGE.name, position=MESSAGE.position, velocity=[0.0] * 4, acceleration=[0.0] * 4
    )
    end = time.monotonic() + 60.0
    counts = ros_node._runtime.pipeline.counts
    while not counts.rejected.total() and time.monotonic() < end:  # until the listener is known
        receive(ros_node, 1, serialize_message(motion))
        time.sleep(0.05)
    assert counts.rejected == {code: 1}
    assert counts.with_efforts == counts.accepted == counts.received - 1
    ros_node.destroy_subscription(listener)


def test_a_bug_in_the_model_is_answered_and_logged_by_services(ros_node, capfd):
    ros_node.start()
    ros_node._runtime.robot = None  # any use of it fails
    answered = []
    service = next(service for service in TABLE if service.name == "describe_robot")
    ros_node._calls._call(
        service, DescribeRobot.Request(), DescribeRobot.Response(), answered.append
    )
    assert answered[0].error_code == ErrorCode.INTERNAL
    assert "AttributeError" in answered[0].error_text
    assert "describe_robot: fault of the node: AttributeError" in capfd.readouterr().err


def test_the_names_are_those_of_the_tables(ros_node):
    services = {s.srv_name.rsplit("/", 1)[-1] for s in ros_node.services}
    assert services >= {service.name for service in TABLE}
    ros_node.start()
    topics = {p.topic_name for p in ros_node.publishers}
    assert topics >= {f"/wired/hybrid_dynamics/{topic.name}" for topic in TOPICS}
    assert topics >= {"/diagnostics", "/wired/robot_description"}
    assert {s.topic_name for s in ros_node.subscriptions} >= {
        "/wired/hybrid_dynamics/active_joint_states",
        "/wired/hybrid_dynamics/active_joint_motions",
        "/wired/hybrid_dynamics/joint_trajectory",
    }


def test_no_topic_has_an_event_whose_locks_the_receiving_thread_takes_in_another_order(ros_node):
    ros_node.start()
    topics = [*ros_node.publishers, *ros_node.subscriptions]
    assert len(topics) > len(TOPICS)
    assert [topic.topic_name for topic in topics if topic.event_handlers] == []
    # the services and topics of an action have no events either
    assert [other for other in ros_node.waitables if not isinstance(other, GoalServer)] == []


def test_what_configure_makes_cleanup_takes_away(ros_node):
    before = {*ros_node.publishers}, {*ros_node.subscriptions}
    for _ in range(2):
        ros_node.start()
        assert ros_node._state_machine.current_state[1] == "active"
        assert len({*ros_node.publishers}) > len(before[0])
        ros_node.trigger_deactivate()
        ros_node.trigger_cleanup()
        assert ({*ros_node.publishers}, {*ros_node.subscriptions}) == before


def test_cleanup_takes_the_description_back(ros_node, monkeypatch):
    """Who comes late would take the last one for the robot of now."""
    published = []
    monkeypatch.setattr(ros_node._description, "publish", published.append)
    ros_node.start()
    ros_node.trigger_deactivate()
    ros_node.trigger_cleanup()
    assert [bool(message.data) for message in published] == [True, False]


def fails(topic):
    """A node's method that makes everything but one topic."""

    def make(self, kind, name, *args, **options):
        if name == topic:
            raise RuntimeError(f"no {topic}")
        own = (
            LifecycleNode.create_subscription
            if topic.endswith("motions")
            else LifecycleNode.create_publisher
        )
        return own(self, kind, name, *args, **options)

    return make


def test_a_configure_that_fails_leaves_no_topics(ros_node, monkeypatch):
    before = {*ros_node.publishers}, {*ros_node.subscriptions}

    def configured():
        done = ros_node.trigger_configure() == TransitionCallbackReturn.SUCCESS
        return done, {*ros_node.publishers} == before[0] and {*ros_node.subscriptions} == before[1]

    with monkeypatch.context() as without:
        for name in ("tf2_msgs", "tf2_msgs.msg"):
            without.setitem(sys.modules, name, None)
        assert ros_node.set_parameters([Parameter("rates.tf", value=10.0)])[0].successful
        assert [configured() for _ in range(3)] == [(False, True)] * 3
    assert ros_node.set_parameters([Parameter("rates.tf", value=-1.0)])[0].successful
    for maker, topic in (
        ("publisher", "~/cylinder_states"),
        ("subscription", "~/active_joint_motions"),
    ):
        with monkeypatch.context() as broken:
            broken.setattr(HybridDynamicsNode, f"create_{maker}", fails(topic), raising=False)
            assert configured() == (False, True), topic
    assert configured() == (True, False)


# a frame beside the robot, turned by a quarter about z: its x is y of the base
CAMERA = Transform(
    translation=Vector3(x=0.5, y=-0.2, z=0.1),
    rotation=Quaternion(z=math.sqrt(0.5), w=math.sqrt(0.5)),
)


def fake_tf2(monkeypatch):
    """tf2_ros as its documentation has it, with one transform: it is not on PyPI."""

    class Buffer:
        def lookup_transform(self, target, source, _time):
            if (target, source) != ("left/base", "camera"):
                raise LookupError(f'"{source}" passed to lookupTransform does not exist')
            return TransformStamped(transform=CAMERA)

    class TransformListener:
        def __init__(self, *_buffer_and_node):
            self.unregister = lambda: None

    module = SimpleNamespace(Buffer=Buffer, TransformListener=TransformListener)
    monkeypatch.setitem(sys.modules, "tf2_ros", module)


def test_targets_in_any_frame_of_tf_are_brought_into_the_base_frame(ros_node, monkeypatch, robot):
    fake_tf2(monkeypatch)
    given = {"tf_targets": True, "frame_prefix": "left/"}
    for name, value in given.items():
        assert ros_node.set_parameters([Parameter(name, value=value)])[0].successful
    assert ros_node.trigger_configure() == TransitionCallbackReturn.SUCCESS
    pose = robot.forward_kinematics(robot.close(robot.reference))
    x, y, z = pose.position - [0.5, -0.2, 0.1]
    turned = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]) @ pose.rotation
    target = conversions.pose_stamped(Header(frame_id="camera"), np.array([y, -x, z]), turned)
    server = next(entry for entry in ros_node.services if entry.srv_name.endswith("solve_ik"))
    answers = SimpleQueue()
    request = SolveIK.Request(target=target)
    server.callback(request, SolveIK.Response()).send_to(answers.put)
    answer = answers.get(timeout=60.0)
    assert answer.error_code == ErrorCode.OK, answer.error_text
    assert answer.solution.header.frame_id == "left/base"
    told = robot.forward_kinematics(robot.close(answer.solution.position[:4]))
    np.testing.assert_allclose(told.position, pose.position, atol=1e-6)
    np.testing.assert_allclose(told.rotation, pose.rotation, atol=1e-6)
    request.target.header.frame_id = "moon"
    server.callback(request, SolveIK.Response()).send_to(answers.put)
    answer = answers.get(timeout=60.0)
    assert answer.error_code == ErrorCode.BAD_INPUT
    assert "moon" in answer.error_text


def test_targets_of_tf_need_its_package_and_say_so(ros_node, monkeypatch):
    monkeypatch.setitem(sys.modules, "tf2_ros", None)
    assert ros_node.set_parameters([Parameter("tf_targets", value=True)])[0].successful
    assert ros_node.trigger_configure() == TransitionCallbackReturn.FAILURE
    assert "tf2_ros is not installed" in ros_node._failure
    assert ros_node.set_parameters([Parameter("tf_targets", value=False)])[0].successful


POLICY = ElementTree.parse(
    Path(__file__).resolve().parents[2] / "security" / "hybrid_dynamics.policy.xml"
)
# by use_sim_time, rates.tf, tf_targets, and measured_poses
OPTIONAL = {"/clock", "/tf", "/tf_static", "/hybrid_dynamics/active_joint_poses"}


def allowed(kind, right):
    """Names that the policy gives the node, as they are without remapping."""
    profile = POLICY.find("./enclaves/enclave[@path='/hybrid_dynamics']/profiles/profile")
    names = {
        entry.text for block in profile.findall(f"{kind}[@{right}='ALLOW']") for entry in block
    }
    return {
        name.replace("~/", "/hybrid_dynamics/") if name.startswith("~") else f"/{name.lstrip('/')}"
        for name in names
    }


ACTION_SERVICES = ("send_goal", "cancel_goal", "get_result")
ACTION_TOPICS = ("feedback", "status")


def of_actions(parts):
    """Names of the services or topics below the actions that the policy gives the node."""
    actions = allowed("actions", "execute")
    return {f"{action}/_action/{part}" for action in actions for part in parts}


def test_the_policy_allows_exactly_what_the_node_needs():
    context = rclpy.Context()
    rclpy.init(context=context)
    node = HybridDynamicsNode(context=context)
    try:
        node.start()
        own = node.get_name(), node.get_namespace()

        def names(listed):
            return {name for name, _ in listed(*own)}

        needed = allowed("services", "reply") | of_actions(ACTION_SERVICES)
        end = time.monotonic() + 60.0
        while names(node.get_service_names_and_types_by_node) != needed and time.monotonic() < end:
            time.sleep(0.05)  # the graph is told step by step
        assert names(node.get_service_names_and_types_by_node) == needed
        assert (
            names(node.get_publisher_names_and_types_by_node)
            == (allowed("topics", "publish") | of_actions(ACTION_TOPICS)) - OPTIONAL
        )
        assert (
            names(node.get_subscriber_names_and_types_by_node)
            == allowed("topics", "subscribe") - OPTIONAL
        )
        assert not names(node.get_client_names_and_types_by_node)
    finally:
        node.discard()
        node.destroy_node()
        context.try_shutdown()
