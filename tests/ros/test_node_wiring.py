"""The node in this process, callbacks called by hand: faults that no message from outside can provoke."""

import dataclasses

import pytest
import rclpy
from hybrid_dynamics_msgs.srv import SolveFK
from sensor_msgs.msg import JointState

from hybrid_dynamics_ros.node import HybridDynamicsNode
from hybrid_dynamics_ros.parameters import declare


class Faulty:
    """A robot whose forward kinematics has a bug; all else is that of a real one."""

    def __init__(self, robot):
        self._robot = robot

    def __getattr__(self, name):
        return getattr(self._robot, name)

    def forward_kinematics(self, *_):
        raise ZeroDivisionError("a bug")


@pytest.fixture
def ros_node():
    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node("wired", context=context)
    yield node
    node.destroy_node()
    context.try_shutdown()


@pytest.fixture
def settings(ros_node):
    return declare(ros_node)


MESSAGE = JointState(name=["q1", "q12", "q22", "q4"], position=[0.0, 0.1, 0.15, 0.0])


def test_a_bug_in_the_model_is_logged_with_its_place_counted_and_survived(ros_node, robot, settings, capfd):
    wired = HybridDynamicsNode(ros_node, Faulty(robot), settings)
    for _ in range(3):
        wired._on_state(MESSAGE)
    assert "3 received, 0 accepted, 0 with efforts, 3 rejected: internal" in wired.summary()
    logged = capfd.readouterr().err
    assert logged.count("ZeroDivisionError: a bug") == 1  # once in a period
    assert "forward_kinematics" in logged


def test_a_bug_in_the_model_is_answered_and_logged_by_services(ros_node, robot, settings, capfd):
    wired = HybridDynamicsNode(ros_node, Faulty(robot), dataclasses.replace(settings, log_period=0.0))
    services = {service.srv_name.rsplit("/", 1)[-1]: service for service in ros_node.services}
    response = services["solve_fk"].callback(SolveFK.Request(active_joints=MESSAGE), SolveFK.Response())
    assert response.error_code == 7
    assert "ZeroDivisionError('a bug')" in response.error_text
    assert "solve_fk: fault of the node: ZeroDivisionError('a bug')" in capfd.readouterr().err
    assert wired.summary().startswith("0 received")


def test_the_names_are_those_of_the_documentation(ros_node, robot, settings):
    HybridDynamicsNode(ros_node, robot, settings)
    assert {p.topic_name for p in ros_node.publishers} >= {
        "/wired/joint_states",
        "/wired/required_efforts",
        "/wired/end_effector_pose",
    }
    assert {s.topic_name for s in ros_node.subscriptions} >= {
        "/wired/active_joint_states",
        "/wired/active_joint_motions",
    }
    assert {s.srv_name.rsplit("/", 1)[-1] for s in ros_node.services} >= {
        "solve_ik",
        "solve_fk",
        "inverse_dynamics",
    }
