"""Services of a node: calls are answered in this process or in worker processes.

They do not block the stream.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Final

from rclpy.lifecycle import LifecycleNode
from rclpy.qos import QoSProfile
from rclpy.service import Service as RosService

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.errors import HybridDynamicsError

from ..actions.convert import ConvertAction
from ..actions.follow import FollowAction
from ..messages.joint_samples import Rejection, RejectionCode, rejection_of
from ..parameters import FOLLOW_ACTION, QUEUE, TIMEOUT, NodeSettings
from ..services.answers import OK, guarded, refused
from ..services.call_counts import CallCounts
from ..services.code_maker import CodeMaker
from ..services.context import ServiceContext
from ..services.table import TABLE, Lane, Service
from ..services.worker_pool import ServiceCall, WorkerPool
from ..stream.conditions import ConditionChange, NewMode
from ..stream.monitor import Level, StatusEntry
from ..stream.rate_limit import ThrottledLog
from ..stream.runtime import Runtime
from .target_frames import TargetFrames
from .trajectory_topics import TrajectoryTopics

# With the usual depth of ten, calls of a flood would be lost unanswered.
_REQUESTS: Final = QoSProfile(depth=1000)
_UNREADY: Final = Rejection(
    RejectionCode.NOT_READY, "the node is not configured: it has no robot yet"
)
_MOVING: Final = Rejection(RejectionCode.REFUSED, "the robot began to move meanwhile")
Give = Callable[[Any], None]  # receives the response


class DeferredResponse:
    """A response that is given later, before or after its destination is known."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._response: Any = None
        self._send: Callable[[Any], None] | None = None

    def give(self, response: Any) -> None:
        """Set the response."""
        with self._lock:
            self._response = response
            if self._send is not None:
                self._send(response)

    def send_to(self, send: Callable[[Any], None]) -> None:
        """Set the destination of the response."""
        with self._lock:
            self._send = send
            if self._response is not None:
                send(self._response)


def defer_responses(service: RosService) -> None:
    """Let the callback of a service return `DeferredResponse`.

    The events executor does not support coroutines, rclpy's usual way.
    """
    send_now = service.send_response
    lock = threading.Lock()

    def send(response: Any, header: Any) -> None:
        def deliver(message: Any) -> None:
            with lock:
                send_now(message, header)

        if isinstance(response, DeferredResponse):
            response.send_to(deliver)
        else:
            deliver(response)

    service.send_response = send  # type: ignore[method-assign]


class ServiceServer:
    """All services on a node.

    They exist from the start, and answer NOT_READY until there is a robot.
    """

    def __init__(self, node: LifecycleNode, log: ThrottledLog) -> None:
        self._node, self._log = node, log
        self._runtime: Runtime | None = None
        self._workers: WorkerPool | None = None
        self._code: CodeMaker | None = None
        self._targets: TargetFrames | None = None
        # One thread, so that changes are serial.
        self._changer: ThreadPoolExecutor | None = None
        self.active = False
        self.counts = CallCounts()
        for service in TABLE:
            name, respond = f"~/{service.name}", self._responder(service)
            server = node.create_service(service.kind, name, respond, qos_profile=_REQUESTS)
            defer_responses(server)
        self._trajectories = TrajectoryTopics(node, self.run, lambda: self.active)
        self._converting = ConvertAction(node, self.run)
        self._following: FollowAction | None = None

    def open(self, runtime: Runtime, targets: TargetFrames | None = None) -> None:
        """Start answering for a robot.

        Args:
            runtime: the robot.
            targets: transforms targets to the base frame; None if they must be in it.
        """
        self._targets = targets
        self._workers = WorkerPool(runtime.robot.description)
        self._code = CodeMaker(runtime.robot.description)
        runtime.make_code = self._code.make
        self._changer = ThreadPoolExecutor(1, "changes")
        self._runtime = runtime

    def offer_following(self, robot: Robot, settings: NodeSettings) -> None:
        """Create ~/follow_joint_trajectory, if a parameter names the controller's action.

        Raises:
            ParameterError: control_msgs is not installed.
        """
        controller = settings[FOLLOW_ACTION]
        if controller:
            self._following = FollowAction(self._node, controller, robot.coordinates, self.run)

    def close(self) -> None:
        """Start answering NOT_READY."""
        self._runtime = None
        if self._changer is not None:
            self._changer.shutdown(wait=False)  # pending calls are answered NOT_READY
        if self._code is not None:
            self._code.close()
        if self._workers is not None:
            self._workers.close()
        if self._targets is not None:
            self._targets.destroy()
        self._workers = self._changer = self._code = self._targets = None
        if self._following is not None:
            self._following.destroy()
        self._following = None

    def worker_report(self) -> list[StatusEntry]:
        """Diagnostics of the worker processes."""
        if self._workers is None:
            return [StatusEntry("processes", "none before configure", Level.STALE)]
        return self._workers.report()

    @property
    def runtime(self) -> Runtime | None:
        """The runtime of the present robot, or None."""
        return self._runtime

    def run_in_changer(self, work: Callable[[], None]) -> bool:
        """Call a function in the thread of the changes; returns False without a robot."""
        if self._changer is None:
            return False
        self._changer.submit(work)
        return True

    def _responder(self, service: Service) -> Callable[[Any, Any], Any]:
        def respond(request: Any, response: Any) -> Any:
            deferred = DeferredResponse()
            self._call(service, request, response, deferred.give)
            return deferred

        return respond

    def run(self, service: Service, request: Any, give: Give, *, is_begun: bool = False) -> None:
        """Submit a call that does not come from a service client.

        Args:
            service: the service.
            request: its request.
            give: receives the response, in any thread.
            is_begun: whether the call continues a job, which is never refused for a full queue.
        """
        self._call(service, request, service.kind.Response(), give, is_begun=is_begun)

    def _call(
        self, service: Service, request: Any, response: Any, give: Give, *, is_begun: bool = False
    ) -> None:
        runtime, workers, changer = self._runtime, self._workers, self._changer
        if runtime is None or workers is None or changer is None:
            self._give(service, refused(response, _UNREADY), give)
            return
        problem = None if self._targets is None else self._targets.to_base_frame(request)
        if problem is not None:
            self._give(service, refused(response, problem), give)
            return

        def done(answered: Any, change: ConditionChange | None) -> None:
            if change is None:
                self._give(service, answered, give)
                return

            def change_and_give() -> None:
                self._give(service, self._change(service, runtime, change, answered), give)

            try:
                changer.submit(change_and_give)
            except RuntimeError:  # shut down in the meantime
                self._give(service, refused(response, _UNREADY), give)

        situation, settings = runtime.situation(), runtime.settings
        if service.lane is Lane.HERE:
            context = ServiceContext(runtime.robot, situation)
            done(*guarded(service.answer, context, request, response))
        else:
            call = ServiceCall(service.name, request, situation, settings[TIMEOUT], done)
            most = sys.maxsize if is_begun else settings[QUEUE]
            workers.submit(service.lane, call, most)

    def _change(
        self, service: Service, runtime: Runtime, change: ConditionChange, answered: Any
    ) -> Any:
        """Apply the change of a call, unless the conditions changed in the meantime.

        It runs in the thread of the changes.
        """
        empty = type(answered)()
        try:
            is_done = False
            while not is_done:
                if runtime is self._runtime:
                    runtime.prepare(change.applied(runtime.conditions))
                with runtime.lock:
                    if runtime is not self._runtime:
                        return refused(empty, _UNREADY)
                    if isinstance(change, NewMode) and runtime.moving:
                        return refused(empty, _MOVING)
                    is_done = runtime.change(change)
            self._log.info(f"{service.name}: {change.text}")
        except HybridDynamicsError as error:
            return refused(empty, rejection_of(error))
        except Exception as error:  # noqa: BLE001 - a call is answered, whatever the fault
            rejection = Rejection(RejectionCode.INTERNAL, f"fault of the node: {error!r}")
            return refused(empty, rejection)
        return answered

    def _give(self, service: Service, response: Any, give: Give) -> None:
        name, code = service.name, response.error_code
        self.counts.note(name, code, response.error_text)
        if code != OK:
            self._log.warn((name, code), f"{name}: {response.error_text}")
        try:
            give(response)
        except Exception as error:  # noqa: BLE001 - the client, or the node, may be gone by now
            text = f"{name}: the response could not be sent: {error}"
            self._log.warn(("undelivered", name), text)
