"""The node: wiring between topics, services and the model, and the process around it."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable
from typing import Any

import numpy as np
import rclpy
from geometry_msgs.msg import PoseStamped
from hybrid_dynamics_msgs.msg import JointMotion
from hybrid_dynamics_msgs.srv import InverseDynamics, SolveFK, SolveIK
from rclpy.exceptions import ParameterException
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.logging import get_logger
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import ok, remove_ros_args, try_shutdown
from sensor_msgs.msg import JointState

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_core.errors import HybridDynamicsError
from hybrid_dynamics_ros import conversions, qos, services
from hybrid_dynamics_ros.filters import StampEvent
from hybrid_dynamics_ros.parameters import ParameterError, Settings, declare
from hybrid_dynamics_ros.pipeline import Pipeline
from hybrid_dynamics_ros.samples import JointSample, Rejection, RejectionCode
from hybrid_dynamics_ros.throttle import Throttle

NODE_NAME = "hybrid_dynamics"
_STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_QUIET = (None, StampEvent.NEXT, StampEvent.FIRST, StampEvent.REPEATED)


class HybridDynamicsNode:
    """Topics and services of one robot on an rclpy node."""

    def __init__(self, node: Node, robot: Robot, settings: Settings) -> None:
        self._log = node.get_logger()
        self._robot = robot
        self._throttle = Throttle(settings.log_period)
        self._pipeline = Pipeline(robot, settings.bandwidth, settings.max_gap)

        outputs = qos.profile(settings.output_qos, settings.output_depth)
        self._joint_states = node.create_publisher(JointState, "~/joint_states", outputs)
        self._efforts = node.create_publisher(JointState, "~/required_efforts", outputs)
        self._pose = node.create_publisher(PoseStamped, "~/end_effector_pose", outputs)

        inputs = qos.profile(settings.input_qos, settings.input_depth)
        node.create_subscription(JointState, "~/active_joint_states", self._on_state, inputs)
        node.create_subscription(JointMotion, "~/active_joint_motions", self._on_motion, inputs)

        for kind, name, answer in (
            (SolveIK, "solve_ik", services.solve_ik),
            (SolveFK, "solve_fk", services.solve_fk),
            (InverseDynamics, "inverse_dynamics", services.inverse_dynamics),
        ):
            node.create_service(kind, f"~/{name}", self._service(name, answer))
        self._log.info(f"robot {robot.name}: active joints {', '.join(robot.active)}")

    def summary(self) -> str:
        """What happened to the input so far, one line."""
        return self._pipeline.counts.summary()

    def _on_state(self, message: JointState) -> None:
        self._process(conversions.sample_of_state(message))

    def _on_motion(self, message: JointMotion) -> None:
        self._process(conversions.sample_of_motion(message))

    def _process(self, sample: JointSample) -> None:
        try:
            result = self._pipeline.process(sample)
        except Exception:  # noqa: BLE001 - one message must not end the node, whatever the fault
            self._pipeline.counts.rejected[RejectionCode.INTERNAL] += 1
            self._warn(RejectionCode.INTERNAL, f"fault of the node:\n{traceback.format_exc()}")
            return
        if isinstance(result, Rejection):
            self._warn(result.code, f"rejected, {result.code.value}: {result.text}")
            return
        if result.event not in _QUIET:
            self._warn(result.event, f"rates are estimated anew: {result.event.value}")
        robot = self._robot
        states, efforts, pose = conversions.result_messages(result, robot.coordinates, robot.active, robot.base_frame)
        self._joint_states.publish(states)
        self._pose.publish(pose)
        if efforts is not None:
            self._efforts.publish(efforts)

    def _service(self, name: str, answer: Callable[[Robot, Any, Any], Any]) -> Callable[[Any, Any], Any]:
        def respond(request: Any, response: Any) -> Any:
            answered = services.guarded(answer, self._robot, request, response)
            if answered.error_code != services.OK:
                self._warn((name, answered.error_code), f"{name}: {answered.error_text}")
            return answered

        return respond

    def _warn(self, kind: object, text: str) -> None:
        held = self._throttle.admit(kind, time.monotonic())
        if held is not None:
            self._log.warning(text + (f" (and {held} like this before)" if held else ""))


def make_executor() -> Executor:
    """The executor that costs least for each message: the events executor, where this rclpy has it."""
    try:
        from rclpy.experimental.events_executor import EventsExecutor  # noqa: PLC0415 - newer than Jazzy's first
    except ImportError:
        return SingleThreadedExecutor()
    return EventsExecutor()


USAGE = "usage: hybrid_dynamics_node --ros-args [-p robot:=NAME_OR_FILE] [--params-file FILE] [-r __node:=NAME]"


def main(args: list[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM. Returns the exit code of the process."""
    # Outside a sourced ROS installation nothing says where packages are: in a plain environment, here.
    os.environ.setdefault("AMENT_PREFIX_PATH", sys.prefix)
    stop = threading.Event()
    for number in _STOP_SIGNALS:
        signal.signal(number, lambda *_: stop.set())
    try:
        # Own handlers set a flag and nothing else: a second signal during the clean-up does no harm.
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    except RuntimeError as error:  # wrong ROS arguments
        return _failed(error)
    try:
        _refuse_others(remove_ros_args(sys.argv if args is None else args)[1:])
        _run(stop)
    except (HybridDynamicsError, ParameterError, ParameterException, OSError) as error:
        return _failed(error)
    finally:
        try_shutdown()
        # Python takes its handlers away before the process is gone: the last signals are ignored instead.
        for number in _STOP_SIGNALS:
            signal.signal(number, signal.SIG_IGN)
    return 0


def _refuse_others(arguments: list[str]) -> None:
    """A word that is no ROS argument would be left out in silence, and another robot started than was meant."""
    if arguments:
        raise ParameterError(f"cannot use {' '.join(arguments)}; {USAGE}")


def _failed(error: Exception) -> int:
    """Say in one line why the node does not run; the exit code for it."""
    get_logger(NODE_NAME).fatal(" ".join(str(error).split()))
    return 1


def _run(stop: threading.Event) -> None:
    node = rclpy.create_node(NODE_NAME)
    try:
        settings = declare(node)
        robot = load(settings.robot)
        _warm_up(robot)
        wired = HybridDynamicsNode(node, robot, settings)
        executor = make_executor()
        executor.add_node(node)
        # Not spin(): the events executor's does not return on signals.
        while ok() and not stop.is_set():
            executor.spin_once(timeout_sec=0.5)
        node.get_logger().info(f"stopped: {wired.summary()}")
        executor.shutdown()
    finally:
        node.destroy_node()


def _warm_up(robot: Robot) -> None:
    """Have the robot's code generated now, not while the first message waits for it."""
    state = robot.close(robot.reference)
    robot.forward_kinematics(state).quaternion  # noqa: B018 - for its side effect
    robot.inverse_dynamics(state, np.zeros(state.n))


if __name__ == "__main__":
    sys.exit(main())
