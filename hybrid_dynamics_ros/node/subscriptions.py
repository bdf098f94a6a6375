"""The stream on a node: subscriptions in, the pipeline, publishers out."""

from __future__ import annotations

import time
import traceback
from typing import Any, Final

from hybrid_dynamics_msgs.msg import JointMotion
from rclpy.event_handler import (
    QoSMessageLostInfo,
    SubscriptionEventCallbacks,
    UnsupportedEventTypeError,
)
from rclpy.lifecycle import LifecycleNode
from rclpy.subscription import Subscription
from sensor_msgs.msg import JointState

from hybrid_dynamics_core.errors import HybridDynamicsError

from ..messages import conversions
from ..messages.joint_samples import JointSample, Rejection, RejectionCode, rejection_of
from ..parameters import INPUT_DEPTH, INPUT_QOS, MAX_GAP, TF_RATE
from ..stream.filter.filter import StampEvent
from ..stream.rate_limit import ThrottledLog
from ..stream.results import MotionResult
from ..stream.runtime import Runtime
from ..stream.topics import topics_of
from . import qos
from .input_reader import Read, StateReader, reader_of
from .publishers import Publishers

_UNREMARKABLE: Final = (None, StampEvent.NEXT, StampEvent.FIRST, StampEvent.REPEATED)
# [s] between an answer and the next input where there may be more inputs waiting
_BACK_TO_BACK: Final = 2e-4
_CALM: Final = 0.05  # [s] without a message left out: the overload is over
_STUCK: Final = 3  # inputs with the same stamp, one after the other


class Stream:
    """Takes joint states while it is active, and answers each of them on all topics."""

    def __init__(self, node: LifecycleNode, runtime: Runtime, log: ThrottledLog) -> None:
        """Create topics on the node."""
        self.active = False
        self._node, self._runtime, self._log = node, runtime, log
        self._repeated = 0
        self._ended = 0.0  # when the last input was answered [s]
        self._took = 0.0  # and how long that took [s]
        self._overloaded = False
        self._skipped_at = 0.0
        # inputs that may wait before some are left out
        self._most_waiting = runtime.settings[INPUT_DEPTH] // 2
        self._readers: tuple[Read, Read] = (
            StateReader(),
            reader_of(JointMotion, conversions.sample_of_motion),
        )
        self._publishers = Publishers(node)
        self._subscriptions: list[Subscription] = []
        try:
            self._open()
        except BaseException:  # nobody else knows of what was made so far
            self.destroy()
            raise

    def _open(self) -> None:
        robot, settings = self._runtime.robot, self._runtime.settings
        self._publishers.open(topics_of(robot, settings[TF_RATE]), settings)
        self._subscribe(JointState, "~/active_joint_states", self._on_state)
        self._subscribe(JointMotion, "~/active_joint_motions", self._on_motion)

    def destroy(self) -> None:
        """Take the topics away."""
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)
        self._publishers.destroy()

    def _subscribe(self, kind: type, topic: str, callback: Any) -> None:
        settings = self._runtime.settings
        profile = qos.profile(settings[INPUT_QOS], settings[INPUT_DEPTH])
        options: dict[str, Any] = {"qos_overriding_options": qos.OVERRIDES, "raw": True}
        lost = SubscriptionEventCallbacks(message_lost=self._on_lost)
        create = self._node.create_subscription
        try:
            subscription = create(kind, topic, callback, profile, event_callbacks=lost, **options)
        except UnsupportedEventTypeError:  # a middleware that does not report losses
            subscription = create(kind, topic, callback, profile, **options)
        self._subscriptions.append(subscription)

    def _on_lost(self, event: QoSMessageLostInfo) -> None:
        self._runtime.monitor.lost = event.total_count

    def _on_state(self, data: bytes) -> None:
        self._take(0, data)

    def _on_motion(self, data: bytes) -> None:
        self._take(1, data)

    def _take(self, which: int, data: bytes) -> None:
        """Answer a message, and all that wait behind it; of too many only the newest state."""
        start = time.perf_counter()
        if not self.active or self._is_skipped(start):
            return
        waiting: list[bytes] = []
        if start < self._ended + _BACK_TO_BACK:  # there may be more waiting
            waiting = self._waiting(self._subscriptions[which])
        if len(waiting) > self._most_waiting:
            self._overloaded = True
            self._skipped_at = start
            self._runtime.monitor.skipped += len(waiting)
            self._log.warn(
                "overload",
                "input comes faster than it can be answered: the newest states are taken",
            )
            data, waiting = waiting[-1], []
        for message in (data, *waiting):
            self._process(self._readers[which], message)
        self._ended = time.perf_counter()
        self._took = self._ended - start

    def _is_skipped(self, now: float) -> bool:
        """Whether to leave a message out: half the time under overload, so that none pile up.

        Leaving out costs little. Messages that wait hold an event each in the executor, which would
        otherwise grow without end.
        """
        if not self._overloaded:
            return False
        if now < self._ended + self._took:
            self._skipped_at = now
            self._runtime.monitor.skipped += 1
            return True
        self._overloaded = now < self._skipped_at + _CALM
        return False

    def _waiting(self, subscription: Subscription) -> list[bytes]:
        messages = []
        handle = subscription.handle
        with handle:
            while (taken := handle.take_message(subscription.msg_type, True)) is not None:
                messages.append(taken[0])
        return messages

    def _process(self, read: Read, message: bytes) -> None:
        start = time.perf_counter()
        rejection = self._attempt(read, message)
        if rejection is not None:
            self._refuse(rejection)
        self._runtime.monitor.answered(time.perf_counter() - start)

    def _attempt(self, read: Read, message: bytes) -> Rejection | None:
        """Answer a message, or say why not; it counts once, wherever it fails."""
        pipeline = self._runtime.pipeline
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
        if isinstance(result, Rejection):
            return result
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
        """ThrottledLog what is out of the ordinary."""
        # By joint: one must not keep back another's line.
        for joint, text in self._runtime.monitor.beyond(result).items():
            self._log.warn(("limit", joint), text)
        if result.event is StampEvent.REPEATED:
            self._repeated += 1
        else:
            self._repeated = 0
        if self._repeated >= _STUCK:
            stamp = result.stamp_ns * 1e-9
            self._log.warn(
                "stuck", f"stamps stay at {stamp:.9f} s: no rates and no efforts can be told"
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
    """The exception that is being handled."""
    return Rejection(RejectionCode.INTERNAL, traceback.format_exc())
