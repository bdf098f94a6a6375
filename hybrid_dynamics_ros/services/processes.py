"""Child processes of this package, each with a pipe.

Each has the reading end of a further pipe, of which only this process has the writing end. It ends
when this process ends, in any way.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Sequence
from contextlib import suppress
from functools import cache
from multiprocessing.connection import Connection, Pipe
from multiprocessing.reduction import ForkingPickler
from types import MappingProxyType
from typing import Any, Final, NamedTuple

from ..messages.trajectory_columns import send_as_columns


def _proxy(values: dict[Any, Any]) -> MappingProxyType[Any, Any]:
    return MappingProxyType(values)


# Descriptions and states have read-only mappings, which Python does not pickle.
ForkingPickler.register(MappingProxyType, lambda proxy: (_proxy, (dict(proxy),)))
send_as_columns()


_NICENESS: Final = 5
_LONGEST_ID: Final = 32  # bytes


class Fork:
    """A fork of a child process, with the methods of `subprocess.Popen` that are used here."""

    def __init__(self, sign: int, *, gives_way: bool) -> None:
        """Listen to a pipe, of which the fork alone has the other end: its id, then its end."""
        self.pid: int | None = None  # until it is there
        self._sign, self._gives_way = sign, gives_way
        self._lock = threading.Lock()
        self._is_unwanted = False
        self._ended = threading.Event()
        threading.Thread(target=self._listen, daemon=True).start()

    def kill(self) -> None:
        """Kill it; if it is not there yet, as soon as it is."""
        with self._lock:
            self._is_unwanted = True
            if self.pid is not None and not self._ended.is_set():
                with suppress(ProcessLookupError):
                    os.kill(self.pid, signal.SIGKILL)

    def wait(self, timeout: float | None = None) -> None:
        """Wait for its end.

        Raises:
            subprocess.TimeoutExpired: it has not ended within `timeout` [s].
        """
        if not self._ended.wait(timeout):
            raise subprocess.TimeoutExpired("a fork", timeout or 0.0)

    def _listen(self) -> None:
        text = os.read(self._sign, _LONGEST_ID)
        if text:  # else there is none: the process that it was to be a fork of has ended
            pid = int(text)
            if self._gives_way:
                _give_way(pid)
            self.pid = pid
            if self._is_unwanted:
                self.kill()
            os.read(self._sign, 1)  # nothing more comes
        with self._lock:
            self._ended.set()
        os.close(self._sign)


Process = subprocess.Popen[bytes] | Fork


class Child(NamedTuple):
    """A child process, and this end of its pipe."""

    process: Process
    connection: Connection


def start(module: str, *, gives_way: bool) -> Child:
    """Start a module, with pipes that `worker` describes as its arguments.

    Args:
        module: full name of an executable module.
        gives_way: whether it has a low priority; not for processes with waiting clients, which
            would wait much longer under load.
    """
    (child,) = start_alike(module, [gives_way])
    return child


def start_alike(module: str, gives_way: Sequence[bool]) -> list[Child]:
    """Start a module, and forks of it, which need not import what it has imported.

    Args:
        module: full name of an executable module.
        gives_way: of each process, as `start` has it.
    """
    ours, theirs = Pipe()
    forks = [(*Pipe(), *os.pipe()) for _ in gives_way[1:]]
    descriptors = [_lifeline(), theirs.fileno()]
    for _, pipe, _, end in forks:
        descriptors += [pipe.fileno(), end]
    # Not multiprocessing, which starts a third process and imports the main module again.
    process = subprocess.Popen(  # noqa: S603 - our own module
        [sys.executable, "-m", module, *map(str, descriptors)],
        pass_fds=descriptors,
        stdin=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    )
    theirs.close()
    if gives_way[0]:
        _give_way(process.pid)
    children = [Child(process, ours)]
    for (connection, pipe, sign, end), gives in zip(forks, gives_way[1:], strict=True):
        pipe.close()
        os.close(end)
        children.append(Child(Fork(sign, gives_way=gives), connection))
    return children


@cache
def _lifeline() -> int:
    """The reading end of a pipe that nobody writes into; it closes when this process ends."""
    reading, _ = os.pipe()
    return reading


def _give_way(process: int) -> None:
    with suppress(ProcessLookupError):  # it has ended already; its user gets an error
        os.setpriority(os.PRIO_PROCESS, process, os.getpriority(os.PRIO_PROCESS, 0) + _NICENESS)
