"""The program of the process that answers service calls, started by `worker_pool` only.

It is connected with the node by a pipe. Both ends send pickled objects:

1. The node sends a RobotDescription. The process makes the robot, and sends None when it is ready.
2. For each call, the node sends (name of the service, request, Situation). The process sends
   (response, ConditionChange or None).

The process ends when the node closes the pipe or ends.
"""

from __future__ import annotations

import gc
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Final

from hybrid_dynamics_core import Robot

from ..messages.trajectory_columns import send_as_columns
from .answers import guarded
from .context import ServiceContext
from .table import BY_NAME

Serve = Callable[[Connection, Robot], None]
_CHECK_PERIOD: Final = 0.2  # [s] between checks whether the node is running


def main(descriptor: int, parent: int, serve: Serve) -> None:
    """Make a robot from the node's description, then serve the node until it ends.

    Args:
        descriptor: file descriptor of this end of the pipe.
        parent: process id of the node.
        serve: function of the pipe and the robot.
    """
    # Ctrl-C reaches all processes of a terminal, but the node ends this one.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_exit_with_node, args=(parent,), daemon=True).start()
    send_as_columns()
    connection = Connection(descriptor)
    try:
        description = connection.recv()
    except (EOFError, OSError):  # the node is gone
        return
    robot = Robot(description)  # an error here ends the process with its text
    with suppress(EOFError, OSError):  # the node is gone
        serve(connection, robot)


def answer_calls(connection: Connection, robot: Robot) -> None:
    """Report that the robot is ready, then answer calls.

    Raises:
        EOFError, OSError: the node has closed the pipe, or has ended.
    """
    # The robot's objects are frozen, since their garbage collection would delay calls.
    gc.collect()
    gc.freeze()
    connection.send(None)  # ready
    while True:
        name, request, situation = connection.recv()
        service = BY_NAME[name]
        context, response = ServiceContext(robot, situation), service.kind.Response()
        connection.send(guarded(service.answer, context, request, response))


def _exit_with_node(parent: int) -> None:
    """Exit when the node has ended, even during a call.

    Args:
        parent: process id of the node.
    """
    while os.getppid() == parent:
        time.sleep(_CHECK_PERIOD)
    os._exit(0)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), answer_calls)
