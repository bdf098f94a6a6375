"""Has code made in a process beside the node, so that the stream does not wait for it.

Making code holds Python's interpreter for seconds. Taking it from disk holds it for milliseconds.
The process starts when it is first needed. Knows no rclpy.
"""

from __future__ import annotations

import threading
from typing import Final

from hybrid_dynamics_core.description.model import RobotDescription

from ..stream.rehearsal import Rehearsal
from .processes import Child, start

_ATTEMPTS: Final = 2  # a process that was killed is replaced once
_END_TIMEOUT: Final = 5.0  # [s] for a killed process to be gone


class CodeMaker:
    """The process of one robot that makes code; one thread at a time asks it."""

    def __init__(self, description: RobotDescription) -> None:
        """Start nothing yet."""
        self._description = description
        self._lock = threading.Lock()
        self._child: Child | None = None
        self._is_closed = False

    def make(self, rehearsal: Rehearsal) -> bool:
        """Have the code made and kept on disk.

        Returns:
            True when it is there, or cannot be made in another process; False once this is closed.
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
        """End the process; who waits for it goes on."""
        self._is_closed = True
        self._end()

    def _running(self) -> Child | None:
        """The process, started where there is none; None once this is closed."""
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
            child.process.kill()  # what it was writing is written aside, and renamed when whole
            child.process.wait(_END_TIMEOUT)
