"""Starting a process of this package, with a pipe to it."""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import suppress
from multiprocessing.connection import Connection, Pipe
from multiprocessing.reduction import ForkingPickler
from types import MappingProxyType
from typing import Any, Final, NamedTuple


def _proxy(values: dict[Any, Any]) -> MappingProxyType[Any, Any]:
    return MappingProxyType(values)


# Frozen descriptions and states hold read-only mappings, which Python does not pickle.
ForkingPickler.register(MappingProxyType, lambda proxy: (_proxy, (dict(proxy),)))


_NICENESS: Final = 5


class Child(NamedTuple):
    """A process, and this end of the pipe to it."""

    process: subprocess.Popen[bytes]
    connection: Connection


def start(module: str, *, gives_way: bool) -> Child:
    """Start a module of this package; it is given the other end of the pipe and this process's id.

    Args:
        module: full name of a module that runs as a program.
        gives_way: whether all others come first where processors are short. Not where a client
            waits: under load it would wait many times as long as for a service of a plain node.
    """
    ours, theirs = Pipe()
    words = ["-m", module, str(theirs.fileno()), str(os.getpid())]
    # Not multiprocessing's own processes: they bring a third one along, and import the main
    # module again.
    process = subprocess.Popen(  # noqa: S603 - our own module
        [sys.executable, *words],
        pass_fds=[theirs.fileno()],
        stdin=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    )
    theirs.close()
    if gives_way:
        _give_way(process.pid)
    return Child(process, ours)


def _give_way(process: int) -> None:
    with suppress(ProcessLookupError):  # it ended already, and whoever talks to it sees that
        os.setpriority(os.PRIO_PROCESS, process, os.getpriority(os.PRIO_PROCESS, 0) + _NICENESS)
