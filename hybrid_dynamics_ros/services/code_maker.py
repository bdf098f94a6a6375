"""Compilation of kernels in a child process, which does not block the stream.

Compilation holds the GIL for seconds, loading from the cache for milliseconds. The process starts
when it is first needed. This module does not depend on rclpy.
"""

from __future__ import annotations

import subprocess
import threading
from contextlib import suppress
from typing import Final

from hybrid_dynamics_core.description.model import RobotDescription

from ..stream.rehearsal import Rehearsal
from .processes import Child, start

_ATTEMPTS: Final = 2  # a killed process is replaced once
_END_TIMEOUT: Final = 5.0  # [s] for a killed process to end


class CodeMaker:
    """The compiling process of one robot, for one thread at a time."""

    def __init__(self, description: RobotDescription) -> None:
        """Store the description; the process starts later."""
        self._description = description
        self._lock = threading.Lock()
        self._child: Child | None = None
        self._is_closed = False

    def make(self, rehearsal: Rehearsal) -> bool:
        """Compile the code of a rehearsal into the cache.

        Returns:
            True if it is ready, or cannot be compiled in another process; False after `close`.
        """
        for _ in range(_ATTEMPTS):
            try:
                child = self._running()
                if child is None:
                    break
                child.connection.send(rehearsal)
                child.connection.recv()
            except (EOFError, OSError):
                self._end()
            else:
                break
        return not self._is_closed

    def close(self) -> None:
        """End the process; waiting threads continue."""
        self._is_closed = True
        self._end()

    def _running(self) -> Child | None:
        """The process, started if needed; None after `close`."""
        with self._lock:
            if self._is_closed:
                return None
            if self._child is not None:
                return self._child
            child = self._child = start(f"{__package__}.code_worker", gives_way=True)
        child.connection.send(self._description)
        child.connection.recv()  # ready
        return child

    def _end(self) -> None:
        with self._lock:
            child, self._child = self._child, None
        if child is not None:
            child.process.kill()  # safe, since cache entries are written to temporary files
            with suppress(subprocess.TimeoutExpired):  # it ends with the node at the latest
                child.process.wait(_END_TIMEOUT)
