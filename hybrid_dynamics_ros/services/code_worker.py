"""The process that makes code beside the stream: started by `code_maker`, never by people.

It is given a RobotDescription, then a Rehearsal at a time, and sends None after each: what was made
is in the cache on disk then. It ends where the node closes the pipe or is gone.
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
    """Say that the robot is ready, then rehearse what the node asks for.

    Raises:
        EOFError, OSError: the node has closed the pipe, or is gone.
    """
    connection.send(None)  # ready
    while True:
        rehearsal = connection.recv()
        with suppress(HybridDynamicsError):  # the node finds that out itself
            rehearse(robot, rehearsal)
        connection.send(None)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), make_code)
