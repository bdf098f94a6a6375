"""The viewer: a web server, the scene, the panel, and one thread that moves the robot."""

from __future__ import annotations

import errno
import socket
import threading
import time
from contextlib import redirect_stdout
from io import StringIO
from typing import Final

import viser

from ..errors import HybridDynamicsError, InputError
from ..robot.robot import Robot
from ..scene.skeleton import place_skeleton
from ..scene.style import RED
from .bodies import robot_shape
from .camera_fit import CameraFit
from .gui_events import Action
from .motion import Motion
from .panel import Panel
from .scene_view import SceneView, rgb
from .session import ViewSession
from .state_interpolation import StateInterpolation

FRAME: Final = 1.0 / 60.0  # [s] between pictures of what moves by itself
IDLE: Final = 0.3  # [s] without a request before the assembly modes are looked for


class Viewer:
    """A robot in the browser at http://host:port, while `run` works.

    It is a context manager that closes the port.

    Args:
        robot: to be shown.
        motion: to be played back.
        host: at which it listens.
        port: at which it listens; 0: any free port.

    Raises:
        InputError: where the port cannot be had.
    """

    def __init__(
        self,
        robot: Robot,
        motion: Motion | None = None,
        host: str = "localhost",
        port: int = 8080,
    ) -> None:
        self.port = free_port(host, port)
        self.host = host
        self.session = ViewSession(robot, motion)
        if motion is not None:
            self.session.show_sample(0)
        self._requests: dict[str, Action] = {}
        self._awake = threading.Condition()
        self._ended = False
        shape = robot_shape(robot, self.session.reference)
        with redirect_stdout(StringIO()):  # viser's own greeting
            self.server = viser.ViserServer(
                host=host, port=self.port, label=robot.name, verbose=False
            )
        try:
            self._theme()
            self.scene_view = SceneView(self.server, shape)
            self.camera_fit = CameraFit(self.server, self.scene_view.camera)
            self.interpolation = StateInterpolation(robot, self.session.state)
            self.panel = Panel(self.server, self.session, shape.size, self.ask, self.fit)
            self.show()
            self._settle()
        except BaseException:  # nobody else could close the port
            self.close()
            raise

    def _theme(self) -> None:
        self.server.gui.configure_theme(
            show_logo=False,
            show_share_button=False,
            dark_mode=False,
            brand_color=rgb(RED),
            control_width="large",
        )
        self.server.gui.main_panel.dock_right()

    @property
    def url(self) -> str:
        """The address of the page."""
        return f"http://{self.host}:{self.port}"

    def ask(self, key: str, action: Action) -> None:
        """Have something done by `run`, from any thread.

        Args:
            key: an older request of the same key that still waits is dropped.
            action: to be done.
        """
        with self._awake:
            self._requests.pop(key, None)  # the latest is done last, and what is said is about it
            self._requests[key] = action
            self._awake.notify()

    def show(self, smoothly: bool = False) -> None:
        """The present state, everywhere; `smoothly`: the picture follows within the next frames."""
        efforts = self.session.efforts()
        self.interpolation.move_to(self.session.state, smoothly)
        self.fit()
        self.scene_view.show(self.interpolation.state)
        self.scene_view.show_efforts(efforts)
        self.panel.refresh(efforts)

    def step(self, timeout: float | None) -> bool:
        """Do what is requested.

        Args:
            timeout: for a request to come [s]; None: any time.

        Returns:
            Whether there was anything.
        """
        with self._awake:
            if not self._requests:
                self._awake.wait(timeout)
            requests = self._requests
            self._requests = {}
        for action in requests.values():
            self._attempt(action)
        if requests:
            self.show(smoothly=True)
        return bool(requests)

    def _attempt(self, action: Action) -> bool:
        """Do it; what the robot refuses is said in the panel, and the view goes on."""
        try:
            action()
        except HybridDynamicsError as error:
            self.session.problem = " ".join(str(error).split())
            return False
        return True

    def _settle(self) -> None:
        if not self._attempt(self.panel.settle):
            self.panel.show_problem()

    def fit(self, client: viser.ClientHandle | None = None) -> None:
        """Bring the robot into the picture of a browser, or of every one whose picture it left."""
        points = place_skeleton(self.session.robot, self.session.state).points
        if client is None:
            self.camera_fit.follow(points)
        else:
            self.camera_fit.show(points, client)
        self.scene_view.surround(points, self.camera_fit.camera)

    def run(self) -> None:
        """Serve until `end`, or until KeyboardInterrupt, which is passed on."""
        last = time.monotonic()
        while not self._ended:
            if self.panel.playing or self.interpolation.moving:
                self.step(max(last + FRAME - time.monotonic(), 0.0))
                now = time.monotonic()
                if now - last >= FRAME:
                    self._frame(now - last)
                    last = now
            else:
                self._wait()
                last = time.monotonic()

    def _wait(self) -> None:
        """Do what is requested; after a while without requests, settle once."""
        timeout = IDLE if self.panel.stale else None
        if not self.step(timeout):
            self._settle()

    def _frame(self, elapsed: float) -> None:
        if self.panel.playback is not None and self.panel.playing:
            self.panel.playback.tick(elapsed)
            self.show()
        elif self.interpolation.moving:
            self.interpolation.tick(elapsed)
            self.scene_view.show(self.interpolation.state)

    def end(self) -> None:
        """Let `run` return, from any thread."""
        self.ask("end", lambda: setattr(self, "_ended", True))

    def __enter__(self) -> Viewer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the port."""
        with redirect_stdout(StringIO()):
            self.server.stop()


def free_port(host: str, port: int) -> int:
    """The port, if it is free; any free one for 0.

    Raises:
        InputError: with what to do otherwise.
    """
    try:
        addresses = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
        family, kind, protocol, _, address = addresses[0]
        with socket.socket(family, kind, protocol) as trial:
            trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            trial.bind(address)
            return int(trial.getsockname()[1])
    except OSError as error:
        reason = f"cannot be had ({error})"
        if error.errno == errno.EADDRINUSE:
            reason = "is in use: end the program that has it"
        raise InputError(
            f"port {port} of {host} {reason}, or take another one, --port N"
        ) from error
