"""Services and trajectories on a node: each call is answered here or beside, never in the way of the stream."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Final

import numpy as np
from hybrid_dynamics_msgs.srv import ConvertTrajectory
from rclpy.lifecycle import LifecycleNode
from rclpy.qos import QoSProfile
from rclpy.service import Service as RosService
from trajectory_msgs.msg import JointTrajectory

from hybrid_dynamics_core.errors import HybridDynamicsError

from ..messages.joint_samples import Rejection, RejectionCode, rejection_of
from ..parameters import QUEUE, TIMEOUT
from ..services.answers import OK, guarded, refused
from ..services.table import TABLE, Lane, Service
from ..services.worker_pool import Job, Workers
from ..stream.conditions import Change, NewMode
from ..stream.rate_limit import Log
from ..stream.runtime import Runtime
from ..stream.situation import Context

# The usual ten that wait would let calls of a flood vanish unanswered.
_REQUESTS: Final = QoSProfile(depth=1000)
TRAJECTORY: Final = "convert_trajectory"
_UNREADY: Final = Rejection(
    RejectionCode.NOT_READY, "the node is not configured: it has no robot yet"
)


class Later:
    """Stands for a response that comes later: :meth:`tell` gives it, before or after it is known where it goes."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._response: Any = None
        self._send: Callable[[Any], None] | None = None

    def tell(self, response: Any) -> None:
        """The response is there."""
        with self._lock:
            self._response = response
            if self._send is not None:
                self._send(response)

    def when_told(self, send: Callable[[Any], None]) -> None:
        """Where the response goes."""
        with self._lock:
            self._send = send
            if self._response is not None:
                send(self._response)


def answer_later(service: RosService) -> None:
    """Let the callback of a service return :class:`Later`. rclpy's own way, coroutines, the events executor has not."""
    send_now = service.send_response
    lock = threading.Lock()

    def send(response: Any, header: Any) -> None:
        def deliver(told: Any) -> None:
            with lock:
                send_now(told, header)

        if isinstance(response, Later):
            response.when_told(deliver)
        else:
            deliver(response)

    service.send_response = send  # type: ignore[method-assign]


class Calls:
    """All services on a node.

    They are there from the first moment on, and say NOT_READY until there is a robot.
    """

    def __init__(self, node: LifecycleNode, log: Log) -> None:
        self._node, self._log = node, log
        self._runtime: Runtime | None = None
        self._workers: Workers | None = None
        self._changer: ThreadPoolExecutor | None = (
            None  # one thread: changes come one after the other
        )
        self.active = False
        for service in TABLE:
            name, responder = f"~/{service.name}", self._responder(service)
            answer_later(node.create_service(service.kind, name, responder, qos_profile=_REQUESTS))
        self._converted = node.create_publisher(JointTrajectory, "~/active_joint_trajectory", 10)
        node.create_subscription(JointTrajectory, "~/joint_trajectory", self._on_trajectory, 10)

    def open(self, runtime: Runtime) -> None:
        """Answer for this robot from now on."""
        self._workers = Workers(runtime.robot.description)
        self._changer = ThreadPoolExecutor(1, "changes")
        self._runtime = runtime

    def close(self) -> None:
        """Answer NOT_READY from now on."""
        self._runtime = None
        if self._changer is not None:
            self._changer.shutdown(wait=False)  # what waits is answered NOT_READY
        if self._workers is not None:
            self._workers.close()
        self._workers = self._changer = None

    def _responder(self, service: Service) -> Callable[[Any, Any], Any]:
        def respond(request: Any, response: Any) -> Any:
            later = Later()
            self._call(service, request, response, later.tell)
            return later

        return respond

    def _on_trajectory(self, message: JointTrajectory) -> None:
        if not self.active:
            return
        service = next(service for service in TABLE if service.name == TRAJECTORY)

        def publish(response: ConvertTrajectory.Response) -> None:
            if response.error_code == OK:
                self._converted.publish(response.trajectory)

        self._call(
            service,
            ConvertTrajectory.Request(joints=message),
            ConvertTrajectory.Response(),
            publish,
        )

    def _call(
        self, service: Service, request: Any, response: Any, tell: Callable[[Any], None]
    ) -> None:
        runtime, workers, changer = self._runtime, self._workers, self._changer
        if runtime is None or workers is None or changer is None:
            self._tell(service, refused(response, _UNREADY), tell)
            return

        def done(answered: Any, change: Change | None) -> None:
            if change is None:
                self._tell(service, answered, tell)
                return
            try:
                changer.submit(
                    lambda: self._tell(
                        service, self._change(service, runtime, change, answered), tell
                    )
                )
            except RuntimeError:  # it was shut down meanwhile
                self._tell(service, refused(response, _UNREADY), tell)

        if service.lane is Lane.HERE:
            done(
                *guarded(
                    service.answer, Context(runtime.robot, runtime.situation()), request, response
                )
            )
        else:
            settings = runtime.settings
            job = Job(service.name, request, runtime.situation(), settings[TIMEOUT], done)
            workers.submit(service.lane, job, settings[QUEUE])

    def _change(self, service: Service, runtime: Runtime, change: Change, answered: Any) -> Any:
        """Make the change of a call, unless things changed while it was worked on; in a thread of its own."""
        empty = type(answered)()
        try:
            if runtime is self._runtime:
                with np.errstate(
                    all="ignore"
                ):  # of a payload beyond all numbers: the result is checked
                    runtime.prepare(change)
            with runtime.lock:
                if runtime is not self._runtime:
                    return refused(empty, _UNREADY)
                if isinstance(change, NewMode) and runtime.moving:
                    return refused(
                        empty, Rejection(RejectionCode.REFUSED, "the robot began to move meanwhile")
                    )
                runtime.change(change)
            self._log.info(f"{service.name}: {change.words}")
        except HybridDynamicsError as error:
            return refused(empty, rejection_of(error))
        except Exception as error:  # noqa: BLE001 - a call is answered, whatever the fault
            return refused(
                empty, Rejection(RejectionCode.INTERNAL, f"fault of the node: {error!r}")
            )
        return answered

    def _tell(self, service: Service, response: Any, tell: Callable[[Any], None]) -> None:
        if response.error_code != OK:
            self._log.warn(
                (service.name, response.error_code), f"{service.name}: {response.error_text}"
            )
        try:
            tell(response)
        except Exception as error:  # noqa: BLE001 - the client, or the node, may be gone by now
            self._log.warn(
                ("undelivered", service.name), f"{service.name}: the answer found nobody: {error}"
            )
