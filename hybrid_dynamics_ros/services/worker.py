"""The process that answers service calls: started by `workers.py`, never by people."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from multiprocessing.connection import Connection
from typing import Final

from hybrid_dynamics_core import Robot

from ..stream.situation import Context
from .answers import guarded
from .table import BY_NAME

_NICENESS: Final = 5  # the stream comes first where processors are short
_LOOK: Final = 0.2  # [s] between two looks whether the node is still there


def main(descriptor: int, parent: int) -> None:
    """Make a robot from what the node sends, then answer jobs until the node is gone."""
    signal.signal(
        signal.SIGINT, signal.SIG_IGN
    )  # Ctrl-C reaches all processes of a terminal: the node ends this one
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()
    os.nice(_NICENESS)
    connection = Connection(descriptor)
    try:
        robot = Robot(connection.recv())
        connection.send(None)
        while True:
            name, request, situation = connection.recv()
            service = BY_NAME[name]
            response = service.kind.Response()
            connection.send(guarded(service.answer, Context(robot, situation), request, response))
    except (EOFError, OSError):
        return  # the node is gone


def _end_with(parent: int) -> None:
    """End in the middle of a job, too, where the node was killed."""
    while os.getppid() == parent:
        time.sleep(_LOOK)
    os._exit(0)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
