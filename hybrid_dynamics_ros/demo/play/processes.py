"""The processes beside this one, the node and the player; none of them outlives the demo."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from ..errors import DemoError

_LAST_LINES: Final = 15  # of a process that failed
_PATIENCE: Final = 10.0  # [s] for a process to end by itself once asked


class Child:
    """A Python module running in its own process; what it prints goes to a file."""

    def __init__(self, title: str, log: Path, module: str, *arguments: str) -> None:
        """Start it.

        Args:
            title: what people call it.
            log: file for its output.
            module: what `python -m` runs.
            arguments: its command line.
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
        """Whether it still runs."""
        return self._process.poll() is None

    @property
    def pid(self) -> int:
        """Its process number."""
        return self._process.pid

    def said(self) -> str:
        """All that it printed so far."""
        return self.log.read_text(encoding="utf-8", errors="replace").strip()

    def require_alive(self) -> None:
        """Raise DemoError with its last words if it has ended with a failure."""
        code = self._process.poll()
        if code:
            lines = self.said().splitlines()[-_LAST_LINES:] or ["(it said nothing)"]
            head = f"The {self.title} ended with exit code {code}. Its last words:"
            raise DemoError("\n".join([head, *lines]))

    def stop(self) -> int:
        """Ask it to end, make it end if it does not; its exit code."""
        if self.running:
            self._process.send_signal(signal.SIGINT)
        try:
            return self._process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            return self._process.wait()


@contextmanager
def child(title: str, log: Path, module: str, *arguments: str) -> Iterator[Child]:
    """A :class:`Child` that has ended when the block is left."""
    process = Child(title, log, module, *arguments)
    try:
        yield process
    finally:
        process.stop()
