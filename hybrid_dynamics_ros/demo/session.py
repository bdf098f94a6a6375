"""The live part of the demo.

Node and player are child processes; recorder and live view are in this process.
"""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import rclpy
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import try_shutdown

from ..bags.storage.bag_writer import BagWriter
from ..node.lifecycle import UNCONFIGURED
from ..parameters import INPUT_DEPTH, OUTPUT_DEPTH, Parameter
from ..parameters import ROBOT as ROBOT_PARAMETER
from .errors import DemoError, InterruptedDemoError
from .expectation import Expectation
from .play.live import LiveView
from .play.processes import Child, child
from .play.recorder import QUEUE, Recorder
from .play.recording import SHIPPED
from .trajectory import ROBOT

_START_DEADLINE: Final = 60.0  # [s] for the node to start and respond
_PLAY_MARGIN: Final = 120.0  # [s] of the player beyond the duration of the recording
_QUIET_DEADLINE: Final = 5.0  # [s] without a message after the player's end; then the rest is lost
_NODE_MODULE: Final = "hybrid_dynamics_ros.node"
_PLAYER_MODULE: Final = "hybrid_dynamics_ros.demo.play.player"
_MAX_WAIT: Final = 0.02  # [s] for a message, between two checks of the processes
_SUBSCRIBERS: Final = 2  # subscribers of the input: the node and the recorder
_NO_LOG_FILES: Final = ("--ros-args", "--disable-external-lib-logs")


class Session:
    """Plays the shipped recording into a node, and records the output."""

    def __init__(
        self,
        expected: Expectation,
        logs: Path,
        say: Callable[[str], None],
        view: LiveView | None,
        stop: threading.Event,
    ) -> None:
        """Prepare; nothing starts yet.

        Args:
            expected: the expected output.
            logs: folder for the output of the processes.
            say: shows a message.
            view: the live view, or None.
            stop: event that ends it early.
        """
        self._expected = expected
        self._logs = logs
        self._say = say
        self._view = view
        self._stop = stop

    def record(self, bag: BagWriter, rate: float) -> None:
        """Start the processes, play the recording, record the output, and end the processes.

        Args:
            bag: the bag to write.
            rate: recorded time over real time.

        Raises:
            DemoError: the node or the player failed.
            InterruptedDemoError: `stop` was set.
        """
        node_log, player_log = self._logs / "node.log", self._logs / "player.log"
        with (
            child("node", node_log, _NODE_MODULE, *_node_arguments()) as model,
            child("player", player_log, _PLAYER_MODULE, *_player_arguments(rate)) as player,
            _ros_node("demo_recorder") as (ros_node, executor),
        ):
            self._say(f"node    process {model.pid}\nplayer  process {player.pid}")
            self._say(f"  plays {_relative(SHIPPED)}")
            recorder = Recorder(ros_node, bag)
            self._connect(executor, recorder, model, player)
            recorder.listen_to_input()  # the player starts with this second subscriber
            try:
                self._play(executor, recorder, model, player, self._expected.duration / rate)
            finally:
                if self._view is not None:
                    self._view.close(recorder.latest, recorder.counts)

    def _connect(self, executor: Executor, recorder: Recorder, model: Child, player: Child) -> None:
        start = time.monotonic()
        while not recorder.connected():
            self._spin(executor, model, player)
            words = model.said()
            if UNCONFIGURED in words:
                raise DemoError(f"The node has no robot; it said:\n{words}")
            if time.monotonic() > start + _START_DEADLINE:
                raise DemoError(
                    f"The node did not answer within {_START_DEADLINE:.0f} s; it said:\n{words}"
                )
        self._say(f"ready after {time.monotonic() - start:.1f} s\n")

    def _play(
        self, executor: Executor, recorder: Recorder, model: Child, player: Child, length: float
    ) -> None:
        deadline = time.monotonic() + length + _PLAY_MARGIN
        while not self._is_finished(recorder, player):
            self._spin(executor, model, player)
            if self._view is not None:
                self._view.update(recorder.latest, recorder.counts)
            if time.monotonic() > deadline:
                raise DemoError(
                    f"The player did not come to its end in time; it said:\n{player.said()}"
                )

    def _is_finished(self, recorder: Recorder, player: Child) -> bool:
        """Whether all messages have arrived, or no more are expected."""
        expected = self._expected.counts
        if all(recorder.counts[topic] >= count for topic, count in expected.items()):
            return True
        is_quiet = time.monotonic() > recorder.last_arrival + _QUIET_DEADLINE
        return is_quiet and not player.running

    def _spin(self, executor: Executor, *children: Child) -> None:
        executor.spin_once(timeout_sec=_MAX_WAIT)
        # Checked first: a process that ends by the same Ctrl-C is no failure.
        if self._stop.is_set():
            raise InterruptedDemoError("Stopped.")
        for process in children:
            process.require_alive()


def _node_arguments() -> list[str]:
    """The command line of the node."""
    parameters: dict[Parameter[Any], object] = {
        ROBOT_PARAMETER: ROBOT,
        INPUT_DEPTH: QUEUE,
        OUTPUT_DEPTH: QUEUE,
    }
    arguments = list(_NO_LOG_FILES)
    for parameter, value in parameters.items():
        arguments += ["-p", f"{parameter.name}:={value}"]
    return arguments


def _player_arguments(rate: float) -> list[str]:
    """The command line of the player."""
    return [str(SHIPPED), "--rate", repr(rate), "--subscribers", str(_SUBSCRIBERS)]


def _relative(path: Path) -> Path:
    """A path relative to the working folder, if it is inside."""
    here = Path.cwd()
    if path.is_relative_to(here):
        return path.relative_to(here)
    return path


@contextmanager
def stop_signals() -> Iterator[threading.Event]:
    """A context in which SIGINT and SIGTERM only set an event."""
    stop = threading.Event()
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = {number: signal.signal(number, lambda *_: stop.set()) for number in numbers}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def _ros_node(name: str) -> Iterator[tuple[Node, Executor]]:
    try:
        rclpy.init(args=[*_NO_LOG_FILES], signal_handler_options=SignalHandlerOptions.NO)
    except RuntimeError as error:  # raised by the middleware
        raise DemoError(f"ROS does not start: {error}") from error
    try:
        node = rclpy.create_node(name, enable_rosout=False, start_parameter_services=False)
        # Jazzy's events executor fails for callbacks with message information.
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        yield node, executor
        executor.shutdown()
        node.destroy_node()
    finally:
        try_shutdown()
