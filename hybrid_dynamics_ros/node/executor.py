"""The executor with the least cost per message."""

from __future__ import annotations

from rclpy.executors import Executor, SingleThreadedExecutor


def make_executor() -> Executor:
    """The events executor if rclpy has it, at half the cost of the wait set.

    The multi-threaded executor may lose messages.
    """
    try:
        from rclpy.experimental.events_executor import (  # noqa: PLC0415 - newer than Jazzy's first
            EventsExecutor,
        )
    except ImportError:
        return SingleThreadedExecutor()
    return EventsExecutor()
