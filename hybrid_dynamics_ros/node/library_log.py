"""What the library logs, in the log of a node."""

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
        """Log a line that asks for care."""


class _Forward(logging.Handler):
    def __init__(self, logger: Logs) -> None:
        super().__init__(logging.INFO)
        self._logger = logger

    def emit(self, record: logging.LogRecord) -> None:
        if record.levelno >= logging.WARNING:  # rclpy wants one severity at one place of the text
            self._logger.warning(record.getMessage())
        else:
            self._logger.info(record.getMessage())


@contextmanager
def forwarded(logger: Logs) -> Iterator[None]:
    """While this lasts, what the library logs is in the logger too."""
    library = logging.getLogger(LIBRARY)
    handler, level = _Forward(logger), library.level
    library.addHandler(handler)
    library.setLevel(min(logging.INFO, library.getEffectiveLevel()))
    try:
        yield
    finally:
        library.removeHandler(handler)
        library.setLevel(level)
