"""Deferred setting of parameters: a call is answered when the compiled code it needs is ready.

Code is compiled by another process, while the stream continues with the old values. Values that
need no code are set at once, in the order of the calls.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.node import Node

from hybrid_dynamics_core.errors import HybridDynamicsError

from ..parameters import ParameterError
from ..stream.conditions import Conditions
from ..stream.runtime import Runtime
from .declare_parameters import ParameterWatch
from .service_server import DeferredResponse, ServiceServer, defer_responses

Respond = Callable[[Any, Any], Any]


class _Call(NamedTuple):
    """A pending call, with its handler and its response."""

    respond: Callable[[], Any]
    request: Any
    deferred: DeferredResponse


class _Queue:
    """Pending calls in order; all methods except `_prepare` run in the executor's thread."""

    def __init__(self, node: Node, watch: ParameterWatch, calls: ServiceServer) -> None:
        self._node, self._watch, self._calls = node, watch, calls
        self._waiting: deque[_Call] = deque()
        self._is_preparing = False

    def answer(self, respond: Respond, request: Any, response: Any) -> DeferredResponse:
        """Answer a call, at once or later."""
        deferred = DeferredResponse()
        self._waiting.append(_Call(partial(respond, request, response), request, deferred))
        self._go_on()
        return deferred

    def _go_on(self) -> None:
        """Answer calls whose code is ready, in order."""
        while self._waiting and not self._is_preparing:
            call, runtime = self._waiting[0], self._calls.runtime
            missing = None if runtime is None else self._missing(runtime, call.request)
            if runtime is not None and missing is not None:
                work = partial(self._prepare, runtime, missing)
                self._is_preparing = self._calls.run_in_changer(work)
            if not self._is_preparing:
                self._waiting.popleft()
                call.deferred.give(call.respond())

    def _missing(self, runtime: Runtime, request: Any) -> Conditions | None:
        """The first of the intermediate conditions, up to the requested values, without code."""
        for count in range(len(request.parameters)):
            try:
                settings = self._watch.after(request.parameters[: count + 1])
                conditions = runtime.conditions_under(settings)
            except (ParameterError, HybridDynamicsError):  # the call will be refused
                return None
            if not runtime.is_prepared(conditions):
                return conditions
        return None

    def _prepare(self, runtime: Runtime, conditions: Conditions) -> None:
        """Compile code, in the thread of the changes."""
        try:
            runtime.prepare(conditions)
        finally:
            executor = self._node.executor
            if executor is not None:
                executor.create_task(self._resume)

    def _resume(self) -> None:
        self._is_preparing = False
        self._go_on()


def wait_for_code(node: Node, watch: ParameterWatch, calls: ServiceServer) -> None:
    """Let the node's parameter services wait for code."""
    queue = _Queue(node, watch, calls)
    for service in node.services:
        if service.srv_type in (SetParameters, SetParametersAtomically):
            service.callback = partial(queue.answer, service.callback)  # type: ignore[assignment]
            defer_responses(service)
