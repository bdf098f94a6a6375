"""Starting a process of this package, with a pipe to it."""

from __future__ import annotations

import os
import subprocess
import sys
from multiprocessing.connection import Connection, Pipe
from multiprocessing.reduction import ForkingPickler
from types import MappingProxyType
from typing import Any, NamedTuple


def _proxy(values: dict[Any, Any]) -> MappingProxyType[Any, Any]:
    return MappingProxyType(values)


# Frozen descriptions and states hold read-only mappings, which Python does not pickle.
ForkingPickler.register(MappingProxyType, lambda proxy: (_proxy, (dict(proxy),)))


class Child(NamedTuple):
    """A process, and this end of the pipe to it."""

    process: subprocess.Popen[bytes]
    connection: Connection


def start(module: str) -> Child:
    """Start a module of this package; it is given the other end of the pipe and this process's id.

    Args:
        module: full name of a module that runs as a program.
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
    return Child(process, ours)
