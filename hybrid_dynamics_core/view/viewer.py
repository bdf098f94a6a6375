"""The viewer: web server, scene, panel, and one thread that moves the robot."""

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
from ..scene.style import RED
from ..scene.visuals.surfaces import surfaces_of
from .bodies import robot_shape
from .camera_fit import CameraFit
from .gui_events import Action, set_value
from .motion import Motion
from .overlays import overlays_of
from .overlays.vibration import VibrationOverlay
from .panel import Panel
from .scene_view import SceneView, rgb
from .session import ViewSession
from .state_interpolation import StateInterpolation
from .visuals import add_switch

FRAME: Final = 1.0 / 60.0  # [s] between frames of a motion
IDLE: Final = 0.3  # [s] without a request before assembly modes are listed


class Viewer:
    """A robot in the browser at http://host:port, while `run` is running.

    It is a context manager that closes the port.

    Args:
        robot: the robot.
        motion: motion for playback.
        host: host to listen at.
        port: port to listen at; 0: any free port.
        skeleton: whether the skeleton is shown at first, in place of visuals.

    Raises:
        InputError: the port is not available.
    """

    def __init__(
        self,
        robot: Robot,
        motion: Motion | None = None,
        host: str = "localhost",
        port: int = 8080,
        skeleton: bool = False,
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
        surfaces = surfaces_of(robot.description)
        with redirect_stdout(StringIO()):  # hides viser's greeting
            self.server = viser.ViserServer(
                host=host, port=self.port, label=robot.name, verbose=False
            )
        try:
            self._theme()
            self.scene_view = SceneView(self.server, shape, surfaces)
            self._add_switch(skeleton)
            self.camera_fit = CameraFit(self.server, self.scene_view.camera)
            self.interpolation = StateInterpolation(robot, self.session.state)
            self.panel = Panel(self.server, self.session, shape.size, self.ask, self.fit)
            self.overlays = overlays_of(self.server, self.session, self.scene_view, self.ask)
            self.show()
            self._settle()
        except BaseException:  # closes the port in any case
            self.close()
            raise

    def _add_switch(self, skeleton: bool) -> None:
        """Add the switch between visuals and skeleton, if there are visuals."""
        show = self.scene_view.show_skeleton
        self.switch = add_switch(self.server.gui, self.scene_view.visuals, self.ask, show)
        if self.switch is not None and skeleton:
            set_value(self.switch, True)
            show(True)

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
        """Request an action, to be done by `run`; callable from any thread.

        Args:
            key: a pending request with the same key is dropped.
            action: the action.
        """
        with self._awake:
            self._requests.pop(key, None)  # the latest is done last
            self._requests[key] = action
            self._awake.notify()

    def show(self, smoothly: bool = False) -> None:
        """Show the present state everywhere; `smoothly`: with interpolated frames."""
        efforts = self.session.efforts()
        self.interpolation.move_to(self.session.state, smoothly)
        self.fit()
        self.scene_view.show(self.interpolation.state)
        self.scene_view.show_efforts(efforts)
        self.panel.refresh(efforts)
        for overlay in self.overlays:
            overlay.refresh()

    def step(self, timeout: float | None) -> bool:
        """Do pending requests.

        Args:
            timeout: longest wait for a request [s]; None: unlimited.

        Returns:
            Whether there was a request.
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
        """Do an action; errors of the robot are shown in the panel."""
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
        """Show the robot in a browser, or in every browser whose picture it left."""
        points = self.scene_view.points(self.session.state)
        if client is None:
            self.camera_fit.follow(points)
        else:
            self.camera_fit.show(points, client)
        self.scene_view.surround(points, self.camera_fit.camera)

    def run(self) -> None:
        """Serve until `end` or KeyboardInterrupt, which is raised."""
        last = time.monotonic()
        while not self._ended:
            if self.panel.playing or self.interpolation.moving or self.swinging:
                self.step(max(last + FRAME - time.monotonic(), 0.0))
                now = time.monotonic()
                if now - last >= FRAME:
                    self._frame(now - last)
                    last = now
            else:
                self._wait()
                last = time.monotonic()

    def _wait(self) -> None:
        """Do pending requests; settle once after a while without requests."""
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
        elif self.vibration is not None:
            self.vibration.tick(elapsed)

    @property
    def vibration(self) -> VibrationOverlay | None:
        """The overlay of natural modes; None if nothing is elastic."""
        for overlay in self.overlays:
            if isinstance(overlay, VibrationOverlay):
                return overlay
        return None

    @property
    def swinging(self) -> bool:
        """Whether the robot swings in a natural mode."""
        return self.vibration is not None and self.vibration.moving

    def end(self) -> None:
        """Let `run` return; callable from any thread."""
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
    """Check that a port is free; for 0, choose one.

    Raises:
        InputError: the port is not available; the message has advice.
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
