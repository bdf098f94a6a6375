"""The program of the process that compiles code, started by `code_maker` only.

It receives a RobotDescription, then rehearsals one by one. It sends None after each, when the code
is in the cache. It ends when the node closes the pipe or ends.
"""

from __future__ import annotations

import sys
from contextlib import suppress
from multiprocessing.connection import Connection

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.errors import HybridDynamicsError

from ..stream.rehearsal import rehearse
from .worker import main


def make_code(connection: Connection, robot: Robot) -> None:
    """Report that the robot is ready, then run requested rehearsals.

    Raises:
        EOFError, OSError: the node has closed the pipe, or has ended.
    """
    connection.send(None)  # ready
    while True:
        rehearsal = connection.recv()
        with suppress(HybridDynamicsError):  # the node will get the same error
            rehearse(robot, rehearsal)
        connection.send(None)


if __name__ == "__main__":
    main([int(word) for word in sys.argv[1:]], make_code)
