"""The stream of a node: input subscriptions, pipeline, output publishers."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable, Sequence
from functools import partial
from importlib import import_module
from typing import Any, Final, NamedTuple

from hybrid_dynamics_msgs.msg import CylinderStates, JointMotion
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.lifecycle import LifecycleNode
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import Imu, JointState, MultiDOFJointState

from hybrid_dynamics_core.errors import HybridDynamicsError
from hybrid_dynamics_core.filtering import Sensor

from ..messages import conversions
from ..messages.imu import sample_of_imu
from ..messages.joint_poses import samples_of_joint_poses
from ..messages.joint_samples import (
    JointSample,
    RejectedError,
    Rejection,
    RejectionCode,
    oversized,
    rejection_of,
)
from ..messages.odometry import sample_of_odometry
from ..messages.pressures import sample_of_pressures
from ..messages.sensor_topics import SensorReading, inertial_readings, joint_readings
from ..parameters import (
    INPUT_DEPTH,
    INPUT_QOS,
    MAX_GAP,
    ODOMETRY,
    PASS_THROUGH,
    ParameterError,
)
from ..stream.estimates.sensor_input import SensorInput
from ..stream.filter.filter import StampEvent
from ..stream.floating.base import PoseInputs
from ..stream.rate_limit import ThrottledLog
from ..stream.results import MotionResult
from ..stream.runtime import Runtime
from ..stream.topics import topics_of
from . import qos
from .incompatible import deaf_publishers, deaf_subscriptions
from .input_reader import Read, StateReader, reader_of
from .input_topic import InputTopic
from .publishers import Publishers

_UNREMARKABLE: Final = (None, StampEvent.NEXT, StampEvent.FIRST, StampEvent.REPEATED)
# [s] between a result and the next input, below which more inputs may be pending
_BACK_TO_BACK: Final = 2e-4
_RESUME: Final = 1e-3  # [s] until pending messages without a successor are processed
_STEADY: Final = Clock(clock_type=ClockType.STEADY_TIME)
_STUCK: Final = 3  # consecutive inputs with the same stamp


class PoseReader(NamedTuple):
    """How messages of poses are read: their type, its conversion, and what takes the result."""

    kind: type
    sample_of: Callable[[Any], Any]
    take: Callable[[Any], None]


class Stream:
    """Processes joint states while active, and publishes results of each on all topics."""

    def __init__(self, node: LifecycleNode, runtime: Runtime, log: ThrottledLog) -> None:
        """Create the topics on the node."""
        self.active = False
        self._node, self._runtime, self._log = node, runtime, log
        self._repeated = 0
        self._ended = 0.0  # [s] time of the last result
        self._publishers = Publishers(node)
        self.inputs: list[InputTopic] = []
        # Runs only while messages are pending, since the executor wakes only for new messages.
        self._resume = node.create_timer(_RESUME, self._on_resume, clock=_STEADY)
        self._resume.cancel()
        try:
            self._open()
        except BaseException:  # destroys what was created so far
            self.destroy()
            raise

    def _open(self) -> None:
        robot, settings = self._runtime.robot, self._runtime.settings
        self._publishers.open(topics_of(robot, settings), settings)
        states = StateReader(has_efforts=settings[PASS_THROUGH])
        self._subscribe(JointState, "~/active_joint_states", partial(self._process, states))
        motions = reader_of(JointMotion, conversions.sample_of_motion)
        self._subscribe(JointMotion, "~/active_joint_motions", partial(self._process, motions))
        self._subscribe(CylinderStates, "~/cylinder_pressures", self._take_pressures)
        self._subscribe_poses(self._runtime.pipeline.poses)
        if self._runtime.sensors is not None:
            self._subscribe_sensors(self._runtime.sensors)

    def _subscribe_poses(self, poses: PoseInputs) -> None:
        """Subscribe to odometry and to poses of ball and free joints, where they are measured."""
        odometry, joint_poses = poses.odometry, poses.joints
        if odometry is not None:
            kind = odometry_type()
            take = PoseReader(kind, sample_of_odometry, odometry.take)
            self._subscribe(kind, odometry.topic, partial(self._take_poses, take))
        if joint_poses is not None:
            kind = MultiDOFJointState
            take = PoseReader(kind, samples_of_joint_poses, joint_poses.take)
            self._subscribe(kind, joint_poses.topic, partial(self._take_poses, take))

    def _subscribe_sensors(self, sensors: SensorInput) -> None:
        """Subscribe to the topics of IMUs and other sensors, whose estimates are the input."""
        for topic, carried in sensors.topics.inertial.items():
            read = partial(_inertial, carried)
            self._subscribe(Imu, topic, partial(self._take_readings, sensors, read))
        for topic, carried in sensors.topics.joints.items():
            read = partial(_joints, carried)
            self._subscribe(JointState, topic, partial(self._take_readings, sensors, read))

    def check_connections(self) -> None:
        """Log publishers and subscriptions of other nodes with incompatible QoS."""
        reasons: list[str] = []
        for source in self.inputs:
            reasons += deaf_publishers(self._node, source.subscription)
        for output in self._publishers.outputs:
            reasons += deaf_subscriptions(self._node, output.publisher)
        text = "; ".join(reasons)
        self._runtime.monitor.unconnected = text
        if text:
            self._log.warn("not connected", f"not connected: {text}")

    def destroy(self) -> None:
        """Destroy the topics; messages that are pending count as left out."""
        self.active = False
        self._node.destroy_timer(self._resume)
        for source in self.inputs:
            source.take_all()
            self._leave_out(source)
            source.destroy()
        self._publishers.destroy()

    def _subscribe(self, kind: type, topic: str, answer: Callable[[bytes], bool]) -> None:
        settings = self._runtime.settings
        profile = qos.profile(settings[INPUT_QOS], settings[INPUT_DEPTH])
        source = InputTopic(self._node, kind, topic, profile)
        source.open(self._on_message, answer)
        self.inputs.append(source)

    def _on_message(self, source: InputTopic) -> None:
        """Process a message and all pending ones; under overload only the newest state."""
        if not self.active:
            self._leave_out(source)
            return
        start = time.perf_counter()
        # More messages may be pending.
        if source.queue.is_overloaded or start < self._ended + _BACK_TO_BACK:
            source.take_all()
        self._work(source)

    def _on_resume(self) -> None:
        self._resume.cancel()
        for source in self.inputs:
            if not self.active:
                self._leave_out(source)
            elif source.queue:
                source.take_all()
                self._work(source)

    def _leave_out(self, source: InputTopic) -> None:
        """Count pending messages as left out, since the node is inactive."""
        self._runtime.monitor.inactive += source.queue.clear()
        self._count()

    def _count(self) -> None:
        """Tell the monitor what the topics have lost so far."""
        monitor = self._runtime.monitor
        monitor.skipped = sum(each.queue.skipped for each in self.inputs)
        monitor.lost = sum(each.gaps.lost for each in self.inputs)

    def _work(self, source: InputTopic) -> None:
        source.queue.work()
        self._ended = time.perf_counter()
        self._count()
        if source.queue.is_overloaded:
            self._log.warn(
                "overload",
                "input comes faster than it can be answered: the newest states are taken",
            )
        if source.queue:
            self._resume.reset()

    def _process(self, read: Read, message: bytes) -> bool:
        """Process a message; returns False if it is unusable."""
        start = time.perf_counter()
        rejection = self._attempt(read, message)
        if rejection is not None:
            self._refuse(rejection)
        self._runtime.monitor.answered(time.perf_counter() - start)
        return rejection is None

    def _take_pressures(self, message: bytes) -> bool:
        """Store measured pressures; returns False if they are unusable."""
        rejection = oversized(len(message)) or self._remember_pressures(message)
        tally = self._runtime.monitor.pressures
        tally.received += 1
        if rejection is None:
            return True
        tally.rejected += 1
        self._refuse(rejection)
        return False

    def _remember_pressures(self, message: bytes) -> Rejection | None:
        try:
            sample = sample_of_pressures(deserialize_message(message, CylinderStates))
            with self._runtime.lock:
                self._runtime.pipeline.pressures.take(sample)
        except RejectedError as error:
            return error.rejection
        except Exception:  # noqa: BLE001 - as in `_attempt`
            return _fault()
        return None

    def _take_poses(self, reader: PoseReader, message: bytes) -> bool:
        """Store motions of ball and free joints; False if the message is unusable."""
        rejection = oversized(len(message))
        try:
            if rejection is None:
                sample = reader.sample_of(deserialize_message(message, reader.kind))
                with self._runtime.lock:
                    reader.take(sample)
        except RejectedError as error:
            rejection = error.rejection
        except Exception:  # noqa: BLE001 - as in `_attempt`
            rejection = _fault()
        if rejection is not None:
            self._refuse(rejection)
        return rejection is None

    def _take_readings(
        self, sensors: SensorInput, read: Callable[[bytes], list[SensorReading]], message: bytes
    ) -> bool:
        """Take readings, and process the joints that they give; False if they are unusable."""
        start = time.perf_counter()
        rejection = oversized(len(message))
        try:
            if rejection is None:
                with self._runtime.lock:
                    sample = sensors.take(read(message))
                for name in sensors.doubtful:
                    text = f"{name} contradicts the other sensors; its readings are left out"
                    self._log.warn(("sensor", name), text)
                if sample is None:
                    return True
                rejection = self._answer(sample)
        except RejectedError as error:
            rejection = error.rejection
        except Exception:  # noqa: BLE001 - as in `_attempt`
            rejection = _fault()
        if rejection is not None:
            self._refuse(rejection)
        self._runtime.monitor.answered(time.perf_counter() - start)
        return rejection is None

    def _attempt(self, read: Read, message: bytes) -> Rejection | None:
        """Process a message, or return the rejection; it is counted once in any case."""
        pipeline = self._runtime.pipeline
        rejection = oversized(len(message))
        if rejection is not None:
            return pipeline.reject_unread(rejection)
        try:
            sample = read(message)
        except Exception:  # noqa: BLE001 - one message must not end the node, whatever the fault
            return pipeline.reject_unread(_fault())
        try:
            return self._answer(sample)
        except Exception:  # noqa: BLE001
            return pipeline.reject(_fault())

    def _answer(self, sample: JointSample) -> Rejection | None:
        runtime = self._runtime
        result = runtime.process(sample)
        if not isinstance(result, MotionResult):
            return result  # refused, or other joints are missing
        try:
            messages = self._publishers.messages(result, runtime.settings)
            for send, message in messages:
                send(message)
        except HybridDynamicsError as error:
            return runtime.pipeline.withdraw(result, rejection_of(error))
        except Exception:  # noqa: BLE001 - as in `_attempt`
            return runtime.pipeline.withdraw(result, _fault())
        runtime.result = result
        self._warn(result)
        return None

    def _warn(self, result: MotionResult) -> None:
        """Log events of a result, throttled."""
        # Throttled by joint, so that each joint has its line.
        for joint, text in self._runtime.monitor.beyond(result).items():
            self._log.warn(("limit", joint), text)
        if result.event is StampEvent.REPEATED:
            self._repeated += 1
        else:
            self._repeated = 0
        if self._repeated >= _STUCK:
            stamp = result.stamp_ns * 1e-9
            self._log.warn(
                "stuck", f"stamps stay at {stamp:.9f} s: rates and efforts cannot be estimated"
            )
        elif result.event not in _UNREMARKABLE:
            self._log.warn(result.event, f"rates are estimated anew: {self._why(result.event)}")

    def _why(self, event: StampEvent | None) -> str:
        if event is not StampEvent.GAP:
            return "" if event is None else event.value
        most = self._runtime.settings[MAX_GAP]
        return (
            f"gap of {self._runtime.evaluator.gap:.6g} s between stamps, beyond {MAX_GAP.name}"
            f" ({most:g} s)"
        )

    def _refuse(self, rejection: Rejection) -> None:
        self._runtime.monitor.rejected(rejection)
        if rejection.code is RejectionCode.INTERNAL:
            self._log.warn(rejection.code, f"fault of the node:\n{rejection.text}")
        else:
            self._log.warn(rejection.code, f"rejected, {rejection.code.value}: {rejection.text}")


def _fault() -> Rejection:
    """The rejection for the exception that is being handled."""
    return Rejection(RejectionCode.INTERNAL, traceback.format_exc())


def _inertial(sensors: Sequence[Sensor], message: bytes) -> list[SensorReading]:
    return inertial_readings(sensors, sample_of_imu(deserialize_message(message, Imu)))


def _joints(sensors: Sequence[Sensor], message: bytes) -> list[SensorReading]:
    sample = conversions.sample_of_state(deserialize_message(message, JointState))
    if sample.stamp_ns < 0:
        text = f"stamp is {sample.stamp_ns} ns, expected 0 or more"
        raise RejectedError(RejectionCode.BAD_STAMP, text)
    return joint_readings(sensors, sample)


def odometry_type() -> type:
    """The type of odometry.

    Raises:
        ParameterError: nav_msgs is not installed.
    """
    try:
        kind: type = import_module("nav_msgs.msg").Odometry
    except ImportError as error:
        text = (
            f"parameter {ODOMETRY.name}: nav_msgs is not installed; install it with ROS, or"
            " ros-jazzy-nav-msgs from PyPI"
        )
        raise ParameterError(text) from error
    return kind
