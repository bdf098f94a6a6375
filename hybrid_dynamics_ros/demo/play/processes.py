"""Child processes of the demo, the node and the player, which end with it."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from ..errors import DemoError

_LAST_LINES: Final = 15  # shown of a failed process
_PATIENCE: Final = 10.0  # [s] for a process to end after SIGINT


class Child:
    """A Python module in a child process, with its output in a file."""

    def __init__(self, title: str, log: Path, module: str, *arguments: str) -> None:
        """Start it.

        Args:
            title: its name in messages.
            log: file for its output.
            module: module for `python -m`.
            arguments: its arguments.
        """
        self.title = title
        self.log = log
        with log.open("wb") as output:
            self._process = subprocess.Popen(  # noqa: S603 - our own modules
                [sys.executable, "-m", module, *arguments],
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
            )

    @property
    def running(self) -> bool:
        """Whether it is running."""
        return self._process.poll() is None

    @property
    def pid(self) -> int:
        """Its process number."""
        return self._process.pid

    def said(self) -> str:
        """Its output so far."""
        return self.log.read_text(encoding="utf-8", errors="replace").strip()

    def require_alive(self) -> None:
        """Raise DemoError with its last lines if it has failed."""
        code = self._process.poll()
        if code:
            lines = self.said().splitlines()[-_LAST_LINES:] or ["(it said nothing)"]
            head = f"The {self.title} ended with exit code {code}. Its last words:"
            raise DemoError("\n".join([head, *lines]))

    def stop(self) -> int:
        """Interrupt it, and kill it if necessary; returns its exit code."""
        if self.running:
            self._process.send_signal(signal.SIGINT)
        try:
            return self._process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            return self._process.wait()


@contextmanager
def child(title: str, log: Path, module: str, *arguments: str) -> Iterator[Child]:
    """A context with a `Child`, which ends with the context."""
    process = Child(title, log, module, *arguments)
    try:
        yield process
    finally:
        process.stop()
