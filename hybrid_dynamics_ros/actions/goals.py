"""An action server whose goals can be finished from any thread.

rclpy's usual coroutine that waits would keep a processor busy under the events executor.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from enum import Enum
from typing import Any

from rclpy.action.server import ActionServer, CancelResponse, RCLError, ServerGoalHandle
from rclpy.node import Node

Work = Callable[[ServerGoalHandle], None]


class Outcome(Enum):
    """Final status of a goal."""

    SUCCEEDED = "succeed"
    ABORTED = "abort"
    CANCELED = "canceled"


class GoalServer(ActionServer):
    """Accepts every goal, starts it at once, and waits for `finish`."""

    def __init__(
        self, node: Node, kind: Any, name: str, begin: Work, cancel: Work = lambda _: None
    ) -> None:
        """Create the action server.

        Args:
            node: the node.
            kind: type of the action.
            name: name of the action.
            begin: starts the work on a goal, without blocking.
            cancel: called when a client cancels a goal.
        """
        self._begin, self._cancel = begin, cancel
        super().__init__(  # type: ignore[no-untyped-call]
            node, kind, name, begin, cancel_callback=self._on_cancel
        )

    def notify_execute(self, goal_handle: ServerGoalHandle, execute_callback: Any) -> None:
        """Called by rclpy when a goal is accepted."""
        del execute_callback
        self._begin(goal_handle)

    def finish(self, goal: ServerGoalHandle, outcome: Outcome, result: Any) -> None:
        """Finish a goal, later and in a thread of the executor."""

        def end(handle: ServerGoalHandle) -> Any:
            with suppress(RCLError):  # it is finished already
                getattr(handle, outcome.value)()
            return result

        super().notify_execute(goal, end)  # type: ignore[no-untyped-call]

    def _on_cancel(self, goal: ServerGoalHandle) -> CancelResponse:
        self._cancel(goal)
        return CancelResponse.ACCEPT


def tell(goal: ServerGoalHandle, feedback: Any) -> None:
    """Publish feedback on a goal, unless it or the node is gone."""
    with suppress(RCLError):
        if goal.is_active:
            goal.publish_feedback(feedback)
