"""The live part of the demo.

Node and player in processes of their own, the recorder and the live view in this one.
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

_START_DEADLINE: Final = 60.0  # [s] for the node to come up and answer
_PLAY_MARGIN: Final = 120.0  # [s] that the player may take longer than the recording
_QUIET_DEADLINE: Final = 5.0  # [s] without a message, once the player has ended: the rest is lost
_SUBSCRIBERS: Final = 2  # of the input: the node and the recorder
_NO_LOG_FILES: Final = ("--ros-args", "--disable-external-lib-logs")


class Session:
    """Plays the shipped recording into a node and records what comes out."""

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
            expected: what the recording leads to.
            logs: folder for what the processes print.
            say: tells people what happens.
            view: the live view, or None.
            stop: ends it early.
        """
        self._expected = expected
        self._logs = logs
        self._say = say
        self._view = view
        self._stop = stop

    def record(self, bag: BagWriter, rate: float) -> None:
        """Start all, play the recording ``rate`` times as fast, record to ``bag``, end all.

        Raises:
            DemoError: the node or the player failed.
            InterruptedDemoError: ``stop`` was set.
        """
        parameters: dict[Parameter[Any], object] = {
            ROBOT_PARAMETER: ROBOT,
            INPUT_DEPTH: QUEUE,
            OUTPUT_DEPTH: QUEUE,
        }
        for_node = list(_NO_LOG_FILES)
        for parameter, value in parameters.items():
            for_node += ["-p", f"{parameter.name}:={value}"]
        for_player = (str(SHIPPED), "--rate", repr(rate), "--subscribers", str(_SUBSCRIBERS))
        with (
            child("node", self._logs / "node.log", "hybrid_dynamics_ros.node", *for_node) as model,
            child(
                "player",
                self._logs / "player.log",
                "hybrid_dynamics_ros.demo.play.player",
                *for_player,
            ) as player,
            _ros_node("demo_recorder") as (ros_node, executor),
        ):
            self._say(
                f"node    process {model.pid}\nplayer  process {player.pid}\n  plays"
                f" {_short_path(SHIPPED)}"
            )
            recorder = Recorder(ros_node, bag)
            self._connect(executor, recorder, model, player)
            recorder.listen_to_input()  # with this second subscriber the player begins
            try:
                self._play(executor, recorder, model, player, self._expected.duration / rate)
            finally:
                if self._view is not None:
                    self._view.close(recorder.latest, recorder.counts)

    def _connect(self, executor: Executor, recorder: Recorder, model: Child, player: Child) -> None:
        start = time.monotonic()
        while not recorder.connected():
            self._spin(executor, model, player)
            if UNCONFIGURED in (words := model.said()):
                raise DemoError(f"The node has no robot; it said:\n{words}")
            if time.monotonic() > start + _START_DEADLINE:
                raise DemoError(
                    f"The node did not answer within {_START_DEADLINE:.0f} s; it"
                    f" said:\n{model.said()}"
                )
        self._say(f"ready after {time.monotonic() - start:.1f} s\n")

    def _play(
        self, executor: Executor, recorder: Recorder, model: Child, player: Child, length: float
    ) -> None:
        deadline = time.monotonic() + length + _PLAY_MARGIN
        while not self._over(recorder, player):
            self._spin(executor, model, player)
            if self._view is not None:
                self._view.update(recorder.latest, recorder.counts)
            if time.monotonic() > deadline:
                raise DemoError(
                    f"The player did not come to its end in time; it said:\n{player.said()}"
                )

    def _over(self, recorder: Recorder, player: Child) -> bool:
        """Whether all has come, or nothing will come any more."""
        wanted = self._expected.counts
        if all(recorder.counts[topic] >= wanted[topic] for topic in wanted):
            return True
        return not player.running and time.monotonic() > recorder.last_arrival + _QUIET_DEADLINE

    def _spin(self, executor: Executor, *children: Child) -> None:
        executor.spin_once(timeout_sec=0.02)
        # First: a process that ends because of the same Ctrl-C is no failure.
        if self._stop.is_set():
            raise InterruptedDemoError("Stopped.")
        for process in children:
            process.require_alive()


def _short_path(path: Path) -> Path:
    """A path as it is seen from here, where it is in this folder."""
    here = Path.cwd()
    return path.relative_to(here) if path.is_relative_to(here) else path


@contextmanager
def stop_signals() -> Iterator[threading.Event]:
    """An event that the signals to end set, instead of what they do otherwise."""
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
    except RuntimeError as error:  # of the middleware
        raise DemoError(f"ROS does not start: {error}") from error
    try:
        node = rclpy.create_node(name, enable_rosout=False, start_parameter_services=False)
        executor = (
            SingleThreadedExecutor()
        )  # Jazzy's events executor fails where callbacks take a message's times
        executor.add_node(node)
        yield node, executor
        executor.shutdown()
        node.destroy_node()
    finally:
        try_shutdown()
