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
from .bodies import shape_of
from .camera_fit import Fitting
from .gui_events import Wish
from .motion import Motion
from .panel import Panel
from .scene_view import Stage, rgb
from .session import Session
from .state_interpolation import Glide

FRAME: Final = 1.0 / 60.0  # [s] between pictures of what moves by itself
REST: Final = 0.3  # [s] without a wish before the assembly modes are looked for


class Viewer:
    """A robot in the browser at http://host:port, while `run` works; a context manager that closes the port."""

    def __init__(
        self, robot: Robot, motion: Motion | None = None, host: str = "localhost", port: int = 8080
    ) -> None:
        """Open the port. Raises InputError where it cannot be had."""
        self.port = free_port(host, port)
        self.host = host
        self.session = Session(robot, motion)
        if motion is not None:
            self.session.show_sample(0)
        shape = shape_of(robot, self.session.home)
        self._wishes: dict[str, Wish] = {}
        self._awake = threading.Condition()
        self._ended = False
        with redirect_stdout(StringIO()):  # viser's own greeting
            self.server = viser.ViserServer(
                host=host, port=self.port, label=robot.name, verbose=False
            )
        try:
            self._theme()
            self.stage = Stage(self.server, shape)
            self.fitting = Fitting(self.server, self.stage.camera)
            self.glide = Glide(robot, self.session.state)
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
        """Where to look."""
        return f"http://{self.host}:{self.port}"

    def ask(self, key: str, wish: Wish) -> None:
        """Have something done by `run`, from any thread; an older wish of the same key that still waits is dropped."""
        with self._awake:
            self._wishes.pop(key, None)  # the latest is done last, and what is said is about it
            self._wishes[key] = wish
            self._awake.notify()

    def show(self, smoothly: bool = False) -> None:
        """The present state, everywhere; `smoothly`: the picture follows within the next frames of `run`."""
        efforts = self.session.efforts()
        self.glide.to(self.session.state, smoothly)
        self.fit()
        self.stage.show(self.glide.state)
        self.stage.show_efforts(efforts)
        self.panel.refresh(efforts)

    def step(self, timeout: float | None) -> bool:
        """Do what is asked for, waiting for it up to some seconds; whether there was anything."""
        with self._awake:
            if not self._wishes:
                self._awake.wait(timeout)
            wishes, self._wishes = self._wishes, {}
        for wish in wishes.values():
            self._attempt(wish)
        if wishes:
            self.show(smoothly=True)
        return bool(wishes)

    def _attempt(self, wish: Wish) -> bool:
        """Do it; what the robot refuses is said in the panel, and the view goes on."""
        try:
            wish()
        except HybridDynamicsError as error:
            self.session.problem = " ".join(str(error).split())
            return False
        return True

    def _settle(self) -> None:
        if not self._attempt(self.panel.settle):
            self.panel.tell_problem()

    def fit(self, client: viser.ClientHandle | None = None) -> None:
        """The whole robot as it stands now into the picture of a browser, or of all that it has left."""
        points = place_skeleton(self.session.robot, self.session.state).points
        if client is None:
            self.fitting.follow(points)
        else:
            self.fitting.show(points, client)
        self.stage.surround(points, self.fitting.camera)

    def run(self) -> None:
        """Serve until `end`, or until KeyboardInterrupt, which is passed on."""
        last = time.monotonic()
        while not self._ended:
            if self.panel.playing or self.glide.moving:
                self.step(max(last + FRAME - time.monotonic(), 0.0))
                now = time.monotonic()
                if now - last >= FRAME:
                    self._frame(now - last)
                    last = now
            else:
                if not self.step(REST if self.panel.stale else None):
                    self._settle()
                last = time.monotonic()

    def _frame(self, elapsed: float) -> None:
        if self.panel.playback is not None and self.panel.playing:
            self.panel.playback.tick(elapsed)
            self.show()
        elif self.glide.moving:
            self.glide.tick(elapsed)
            self.stage.show(self.glide.state)

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
    """The port, if it is free; any free one for 0. Raises InputError with what to do otherwise."""
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM
        )[0]
        with socket.socket(family, kind, protocol) as trial:
            trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            trial.bind(address)
            return int(trial.getsockname()[1])
    except OSError as error:
        told = (
            "is in use: end the program that has it"
            if error.errno == errno.EADDRINUSE
            else f"cannot be had ({error})"
        )
        problem = f"port {port} of {host} {told}, or take another one, --port N"
        raise InputError(problem) from error
