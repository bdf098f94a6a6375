"""The program of the processes that answer service calls, started by `worker_pool` only.

Its arguments are file descriptors:

* the end of a pipe that closes when the node ends;
* the end of a pipe to the node;
* for each fork of this process, the end of a pipe to the node, and of one into which it writes its
  process id. It forks when all is imported.

Both ends of a pipe send pickled objects:

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
from collections.abc import Callable, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection

from hybrid_dynamics_core import Robot

from ..messages.trajectory_columns import send_as_columns
from .answers import guarded
from .context import ServiceContext
from .table import BY_NAME

Serve = Callable[[Connection, Robot], None]


def main(descriptors: Sequence[int], serve: Serve) -> None:
    """Make a robot from the node's description, then serve the node until it ends.

    Args:
        descriptors: the arguments of this program.
        serve: function of the pipe and the robot.
    """
    # Ctrl-C reaches all processes of a terminal, but the node ends this one.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    lifeline, first, *others = descriptors
    descriptor = _forked(first, others)
    threading.Thread(target=_exit_with_node, args=(lifeline,), daemon=True).start()
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


def _forked(first: int, others: Sequence[int]) -> int:
    """Fork this process, which has no threads yet; the pipe to the node that each process has.

    Args:
        first: pipe of this process.
        others: pipes of each fork: to the node, and for its process id.
    """
    gc.freeze()  # what forks share stays shared
    open_ends = [first, *others]
    for pipe, sign in zip(others[::2], others[1::2], strict=True):
        if os.fork() == 0:
            for end in set(open_ends) - {pipe, sign}:
                os.close(end)
            os.write(sign, str(os.getpid()).encode())
            return pipe
        # Only the fork has them now, so the node sees its end.
        for end in (pipe, sign):
            os.close(end)
            open_ends.remove(end)
    return first


def _exit_with_node(lifeline: int) -> None:
    """Exit when the node has ended, even during a call.

    Args:
        lifeline: a pipe that closes then.
    """
    os.read(lifeline, 1)
    os._exit(0)


if __name__ == "__main__":
    main([int(word) for word in sys.argv[1:]], answer_calls)
