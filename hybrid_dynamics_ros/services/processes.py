"""Child processes of this package, each with a pipe."""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import suppress
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


class Child(NamedTuple):
    """A child process, and this end of its pipe."""

    process: subprocess.Popen[bytes]
    connection: Connection


def start(module: str, *, gives_way: bool) -> Child:
    """Start a module with the other end of a pipe and this process's id as arguments.

    Args:
        module: full name of an executable module.
        gives_way: whether it has a low priority; not for processes with waiting clients, which
            would wait much longer under load.
    """
    ours, theirs = Pipe()
    words = ["-m", module, str(theirs.fileno()), str(os.getpid())]
    # Not multiprocessing, which starts a third process and imports the main module again.
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
    with suppress(ProcessLookupError):  # it has ended already; its user gets an error
        os.setpriority(os.PRIO_PROCESS, process, os.getpriority(os.PRIO_PROCESS, 0) + _NICENESS)
