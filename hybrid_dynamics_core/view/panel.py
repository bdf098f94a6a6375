"""Sliders, buttons and tables next to the scene."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import viser

from ..closed_state.assembly_modes import AssemblyMode
from ..ground.arrays import Array
from ..ground.units import coordinate_unit
from . import panel_html
from .gui_events import Enqueue, in_order, is_from_browser, set_value
from .number_input import NumberInput
from .playback import Playback
from .ranges import Range, round_value, slider_ranges
from .script import script_html
from .session import DriveEfforts, ViewSession
from .slider import Slider

# Lets the camera of one browser, or of all, show the robot.
FitCamera = Callable[[viser.ClientHandle | None], None]


class Panel:
    """The control panel.

    Actions of users are passed to `enqueue`. The robot is not used in viser's threads.

    Args:
        server: the server of viser.
        session: the session to show and control.
        size: size of the robot [m].
        enqueue: receives actions of users.
        fit: lets cameras show the robot.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        session: ViewSession,
        size: float,
        enqueue: Enqueue,
        fit: FitCamera,
    ) -> None:
        self.gui = server.gui
        self.session = session
        self.enqueue = enqueue
        self.fit = fit
        self.target = np.array(session.state.u)
        self.modes: tuple[AssemblyMode, ...] = ()
        self.labels: list[str] = []
        self.stale = True  # whether the list of modes and the sliders need an update
        self.gui.add_html(panel_html.SHEET + script_html(session.robot.name))
        typed = NumberInput(self.gui)  # next to the script, where the style sheet hides it
        self._problem = self.gui.add_html("", visible=False)
        self.playback: Playback | None = None
        if session.motion is not None:
            self.playback = Playback(self.gui, session, session.motion, enqueue)
        self._add_sliders(slider_ranges(session.robot, session.reference, size))
        with self.gui.add_folder("State"):
            self._state = self.gui.add_html("")
        self._add_efforts()
        self._add_modes()
        sliders = [*self.sliders, self._payload]
        if self.playback is not None:
            sliders.insert(0, self.playback.slider)
        typed.listen(sliders, self._pause_for_typing)

    @property
    def playing(self) -> bool:
        """Whether a motion is playing."""
        return self.playback is not None and self.playback.playing

    # -- updates

    def refresh(self, efforts: DriveEfforts) -> None:
        """Update numbers and, unless the last request was refused, sliders."""
        self.show_problem()
        session = self.session
        self._state.content = panel_html.state_html(session)
        self._modes.content = panel_html.modes_html(session.state)
        self._payload.follow(session.payload)
        self._efforts.content = panel_html.efforts_html(session.robot, efforts)
        self.stale = True
        if not session.problem:
            self._follow()
        if self.playback is not None:
            self.playback.refresh()

    def show_problem(self) -> None:
        """Show why the last request was refused, if it was."""
        self._problem.content = panel_html.problem_html(self.session.problem)
        self._problem.visible = bool(self.session.problem)

    def _follow(self) -> None:
        self.target = np.array(self.session.state.u)
        for slider, value in zip(self.sliders, self.target.tolist(), strict=True):
            slider.follow(value)

    def settle(self) -> None:
        """When idle, move the sliders back to the pose and list its assembly modes."""
        self.stale = False  # tried only once
        self._follow()
        if self.session.state.loops:
            self.list_modes()

    def list_modes(self) -> None:
        """List the assembly modes at the present coordinates."""
        self.modes = self.session.modes()
        self.labels = panel_html.mode_labels(self.modes, self.session.reference.branch)
        present = self.session.present(self.modes)
        self._mode.options = tuple(self.labels) or ("none",)
        if present is not None:
            set_value(self._mode, self.labels[present])

    # -- controls

    def _add_sliders(self, ranges: Array) -> None:
        robot = self.session.robot
        self.sliders: list[Slider] = []
        driven = len(robot.description.motors)  # idle coordinates come after them
        with self.gui.add_folder("Active joints"):
            for k in range(driven):
                self._add_slider(k, ranges[k])
            reset = self.gui.add_button("Reset pose and payload")
            fit = self.gui.add_button("Fit the robot into the picture")
        if robot.idle:
            with self.gui.add_folder("Idle joints"):
                for k in range(driven, len(robot.active)):
                    self._add_slider(k, ranges[k])
        reset.on_click(in_order(lambda _: self.enqueue("reset", self._reset)))

        @fit.on_click
        @in_order
        def _(event: viser.GuiEvent[Any]) -> None:
            self.enqueue("fit", partial(self.fit, event.client))

    def _add_slider(self, k: int, reach: Array) -> None:
        """Add the slider of the k-th coordinate."""
        robot = self.session.robot
        name = robot.active[k]
        unit = coordinate_unit(robot.joint_types[name])
        limits = robot.description.joints[name].limits
        low, high = reach
        scope = Range(name, unit, low, high, limits)
        slider = Slider(self.gui, scope, float(self.target[k]))
        slider.on_request(f"move {k}", self.enqueue, partial(self._move, k))
        self.sliders.append(slider)

    def _move(self, k: int, value: float) -> None:
        self._pause()
        self.target[k] = value
        self.session.move(self.target)

    def _reset(self) -> None:
        self._pause()
        self.session.reset()

    def _pause(self) -> None:
        if self.playback is not None:
            self.playback.playing = False

    def _pause_for_typing(self) -> None:
        if self.playing:
            self.enqueue("pause", self._pause)

    def _add_modes(self) -> None:
        has_loops = bool(self.session.state.loops)
        with self.gui.add_folder("Assembly mode", visible=has_loops):
            self._mode = self.gui.add_dropdown("mode", ("1",))
            self._modes = self.gui.add_html("")

        @self._mode.on_update
        @in_order
        def _(event: viser.GuiEvent[Any]) -> None:
            if is_from_browser(event):
                wanted = str(event.target.value)
                self.enqueue("mode", lambda: self._take(wanted))

    def _take(self, wanted: str) -> None:
        self._pause()
        if self.stale:
            self.list_modes()
        if wanted in self.labels:
            mode = self.modes[self.labels.index(wanted)]
            self.session.take_mode(mode)
        else:
            self.session.problem = (
                f"there is no assembly mode '{wanted}' at these active coordinates"
            )

    def _add_efforts(self) -> None:
        robot = self.session.robot
        mass = sum(link.mass for link in robot.description.links.values())
        with self.gui.add_folder("Efforts of the drives"):
            self._efforts = self.gui.add_html("")
            heaviest = round_value(0.5 * mass) if mass else 10.0
            scope = Range("payload", "kg", 0.0, heaviest)
            self._payload = Slider(self.gui, scope, 0.0)
        self._payload.on_request("payload", self.enqueue, self.session.lift)
