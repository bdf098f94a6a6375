"""Forwarding of the library's log to the node's log."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

LIBRARY = "hybrid_dynamics_core"


class Logs(Protocol):
    """A logger of ROS."""

    def info(self, message: str) -> object:
        """Log a line."""

    def warning(self, message: str) -> object:
        """Log a warning."""


class _Forward(logging.Handler):
    def __init__(self, logger: Logs) -> None:
        super().__init__(logging.INFO)
        self._logger = logger

    def emit(self, record: logging.LogRecord) -> None:
        if record.levelno >= logging.WARNING:  # rclpy requires one severity per call site
            self._logger.warning(record.getMessage())
        else:
            self._logger.info(record.getMessage())


@contextmanager
def forwarded(logger: Logs) -> Iterator[None]:
    """A context in which the library's log is forwarded to a logger."""
    library = logging.getLogger(LIBRARY)
    handler, level = _Forward(logger), library.level
    library.addHandler(handler)
    library.setLevel(min(logging.INFO, library.getEffectiveLevel()))
    try:
        yield
    finally:
        library.removeHandler(handler)
        library.setLevel(level)
