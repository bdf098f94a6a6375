"""The process that answers service calls: started by `worker_pool`, never by people."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from multiprocessing.connection import Connection
from typing import Final

from hybrid_dynamics_core import Robot

from .answers import guarded
from .context import ServiceContext
from .table import BY_NAME

_NICENESS: Final = 5  # the stream comes first where processors are short
_CHECK_PERIOD: Final = 0.2  # [s] between two checks whether the node is still there


def main(descriptor: int, parent: int) -> None:
    """Make a robot from what the node sends, then answer jobs until the node is gone."""
    # Ctrl-C reaches all processes of a terminal: the node ends this one.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()
    os.nice(_NICENESS)
    connection = Connection(descriptor)
    try:
        robot = Robot(connection.recv())
        connection.send(None)
        while True:
            name, request, situation = connection.recv()
            service = BY_NAME[name]
            context, response = ServiceContext(robot, situation), service.kind.Response()
            connection.send(guarded(service.answer, context, request, response))
    except (EOFError, OSError):
        return  # the node is gone


def _end_with(parent: int) -> None:
    """End in the middle of a job, too, where the node was killed."""
    while os.getppid() == parent:
        time.sleep(_CHECK_PERIOD)
    os._exit(0)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
