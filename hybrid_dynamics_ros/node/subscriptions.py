"""The stream on a node: subscriptions in, the pipeline, publishers out."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable
from typing import Any

from hybrid_dynamics_msgs.msg import JointMotion
from rclpy.event_handler import (
    QoSMessageLostInfo,
    SubscriptionEventCallbacks,
    UnsupportedEventTypeError,
)
from rclpy.lifecycle import LifecycleNode
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription
from sensor_msgs.msg import JointState

from hybrid_dynamics_core.errors import HybridDynamicsError

from ..messages import conversions
from ..messages.joint_samples import JointSample, Rejection, RejectionCode, rejection_of
from ..parameters import (
    INPUT_DEPTH,
    INPUT_QOS,
    MAX_GAP,
    OUTPUT_DEPTH,
    OUTPUT_QOS,
    RATES,
    TF_RATE,
    Parameter,
)
from ..stream import outputs
from ..stream.filter.filter import StampEvent
from ..stream.outputs import Fill
from ..stream.rate_limit import Log, Pace
from ..stream.results import MotionResult
from ..stream.runtime import Runtime
from ..stream.tf_output import tf_output
from . import qos
from .input_reader import Read, StateReader, reader_of

Send = Callable[[Any], None]

_QUIET = (None, StampEvent.NEXT, StampEvent.FIRST, StampEvent.REPEATED)
_BACK_TO_BACK = (
    2e-4  # [s] between an answer and the next input where there may be more inputs waiting
)
_CALM = 0.05  # [s] without a message left out: the overload is over
_KINDS = (JointState, JointMotion)
_LOOK = 0.02  # [s] for which is kept who listens to which topic
_STUCK = 3  # inputs with the same stamp, one after the other


class Stream:
    """Takes joint states while it is active, and answers each of them on all topics."""

    def __init__(self, node: LifecycleNode, runtime: Runtime, log: Log) -> None:
        """Create topics on the node."""
        self.active = False
        self._node, self._runtime, self._log = node, runtime, log
        self._repeated = 0
        self._ended = self._took = (
            0.0  # when the last input was answered, and how long that took [s]
        )
        self._overloaded, self._skipped_at = False, 0.0
        self._most = (
            runtime.settings[INPUT_DEPTH] // 2
        )  # inputs that may wait before some are left out
        settings = runtime.settings
        table: list[tuple[str, type, Fill, Parameter[float]]] = [
            (f"~/{output.topic}", output.kind, output.filler(runtime.robot), rate)
            for output, rate in zip(outputs.TABLE, RATES, strict=True)
        ]
        if settings[TF_RATE] >= 0.0:
            kind, filler = tf_output()
            table.append(("/tf", kind, filler(runtime.robot), TF_RATE))
        self._readers: tuple[Read, ...] = (
            StateReader(),
            reader_of(JointMotion, conversions.sample_of_motion),
        )
        self._outputs: list[tuple[Publisher, Fill, Parameter[float], Pace]] = []
        self._subscriptions: list[Subscription] = []
        try:
            self._open(table)
        except BaseException:  # nobody else knows of what was made so far
            self.destroy()
            raise
        self._looked = -_LOOK
        self._sent: list[tuple[Publisher, Fill, float, Pace, bool]] = []

    def _open(self, table: list[tuple[str, type, Fill, Parameter[float]]]) -> None:
        settings = self._runtime.settings
        profile = qos.profile(settings[OUTPUT_QOS], settings[OUTPUT_DEPTH])
        for topic, kind, fill, rate in table:
            self._outputs.append((self._publisher(kind, topic, profile), fill, rate, Pace()))
        self._subscriptions.append(
            self._subscription(_KINDS[0], "~/active_joint_states", self._on_state)
        )
        self._subscriptions.append(
            self._subscription(_KINDS[1], "~/active_joint_motions", self._on_motion)
        )

    def destroy(self) -> None:
        """Take the topics away."""
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)
        for publisher, *_ in self._outputs:
            self._node.destroy_publisher(publisher)

    def _publisher(self, kind: type, topic: str, profile: QoSProfile) -> Publisher:
        return self._node.create_publisher(
            kind, topic, profile, qos_overriding_options=qos.OVERRIDES
        )

    def _subscription(self, kind: type, topic: str, callback: Any) -> Subscription:
        settings = self._runtime.settings
        profile = qos.profile(settings[INPUT_QOS], settings[INPUT_DEPTH])
        options: dict[str, Any] = {"qos_overriding_options": qos.OVERRIDES, "raw": True}
        lost = SubscriptionEventCallbacks(message_lost=self._on_lost)
        try:
            return self._node.create_subscription(
                kind, topic, callback, profile, event_callbacks=lost, **options
            )
        except UnsupportedEventTypeError:  # a middleware that does not tell
            return self._node.create_subscription(kind, topic, callback, profile, **options)

    def _on_lost(self, event: QoSMessageLostInfo) -> None:
        self._runtime.monitor.lost = event.total_count

    def _on_state(self, data: bytes) -> None:
        self._take(0, data)

    def _on_motion(self, data: bytes) -> None:
        self._take(1, data)

    def _take(self, which: int, data: bytes) -> None:
        """Answer a message, and all that wait behind it; where there are too many, the newest state wins."""
        start = time.perf_counter()
        if not self.active or self._left_out(start):
            return
        # Back to back: there may be more waiting.
        waiting = (
            self._waiting(self._subscriptions[which]) if start < self._ended + _BACK_TO_BACK else []
        )
        if len(waiting) > self._most:
            self._overloaded, self._skipped_at = True, start
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

    def _left_out(self, now: float) -> bool:
        """Under overload every second moment is for leaving messages out, which costs little: so none pile up.

        Messages that wait hold an event each in the executor, which would otherwise grow without
        end.
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
        taken = []
        with subscription.handle:
            while (
                found := subscription.handle.take_message(subscription.msg_type, True)
            ) is not None:
                taken.append(found[0])
        return taken

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
            messages = self._messages(result)
            for send, message in messages:
                send(message)
        except HybridDynamicsError as error:
            return runtime.pipeline.withdraw(result, rejection_of(error))
        except Exception:  # noqa: BLE001 - as in `_attempt`
            return runtime.pipeline.withdraw(result, _fault())
        runtime.result = result
        self._tell(result)
        return None

    def _messages(self, result: MotionResult) -> list[tuple[Send, Any]]:
        """All messages that are due; made before the first is sent, so that all go or none."""
        now = time.perf_counter()
        if now > self._looked + _LOOK:
            self._looked = now
            self._look()
        messages = []
        for publisher, fill, rate, pace, listened in self._sent:
            if (rate == 0.0 or pace.due(result.stamp_ns, rate)) and listened:
                message = fill(result)
                if message is not None:
                    # Bytes go the short way; who is to send is destroyed in this thread alone.
                    send = (
                        publisher.handle.publish_raw
                        if type(message) is bytes
                        else publisher.publish
                    )
                    messages.append((send, message))
        return messages

    def _look(self) -> None:
        """Keep at which rate topics go out, and whether somebody listens; one at full rate needs no pace."""
        settings = self._runtime.settings
        told = [
            (publisher, fill, settings[rate], pace, publisher.get_subscription_count() > 0)
            for publisher, fill, rate, pace in self._outputs
        ]
        self._sent = [row for row in told if row[2] > 0.0 or (row[2] == 0.0 and row[4])]

    def _tell(self, result: MotionResult) -> None:
        for joint, text in self._runtime.monitor.beyond(
            result
        ).items():  # one joint must not keep back another's line
            self._log.warn(("limit", joint), text)
        self._repeated = self._repeated + 1 if result.event is StampEvent.REPEATED else 0
        if self._repeated >= _STUCK:
            stamp = result.stamp_ns * 1e-9
            self._log.warn(
                "stuck", f"stamps stay at {stamp:.9f} s: no rates and no efforts can be told"
            )
        elif result.event not in _QUIET:
            self._log.warn(result.event, f"rates are estimated anew: {self._why(result.event)}")

    def _why(self, event: StampEvent | None) -> str:
        if event is not StampEvent.GAP:
            return "" if event is None else event.value
        most = self._runtime.settings[MAX_GAP]
        return (
            f"gap of {self._runtime.pipeline.gap:.6g} s between stamps, beyond {MAX_GAP.name}"
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
