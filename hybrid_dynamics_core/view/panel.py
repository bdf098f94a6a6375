"""Sliders, buttons and tables beside the scene."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import viser

from ..closed_state.assembly_modes import AssemblyMode
from ..ground.arrays import Array
from ..ground.units import coordinate_unit
from . import page
from .gui_events import Ask, by_person, put
from .number_input import Typed
from .playback import Playback
from .ranges import Range, round_value, slider_ranges
from .script import script_html
from .session import Efforts, Session
from .slider import Dial

Fit = Callable[
    [viser.ClientHandle | None], None
]  # has the camera of a browser show the whole robot


class Panel:
    """The controls.

    What a person does is handed to `ask`; nothing of the robot is touched in viser's threads.
    """

    def __init__(
        self, server: viser.ViserServer, session: Session, size: float, ask: Ask, fit: Fit
    ) -> None:
        self.gui, self.session, self.ask, self.fit = server.gui, session, ask, fit
        self.target = np.array(session.state.u)
        self.modes: tuple[AssemblyMode, ...] = ()
        self.labels: list[str] = []
        self.stale = True  # list of modes, and sliders that were left where a person put them
        self.gui.add_html(page.SHEET + script_html(session.robot.name))
        typed = Typed(self.gui)  # right behind, where the sheet hides it
        self._problem = self.gui.add_html("", visible=False)
        self.playback = (
            None if session.motion is None else Playback(self.gui, session, session.motion, ask)
        )
        self._add_sliders(slider_ranges(session.robot, session.home, size))
        with self.gui.add_folder("State"):
            self._state = self.gui.add_html("")
        self._add_efforts()
        self._add_modes()
        timed = [] if self.playback is None else [self.playback.dial]
        typed.listen([*timed, *self.dials, self._payload], self._at_a_box)

    @property
    def playing(self) -> bool:
        """Whether a motion goes on by itself."""
        return self.playback is not None and self.playback.playing

    # -- what is shown

    def refresh(self, efforts: Efforts) -> None:
        """Numbers of the present state; sliders where it is, unless it could not follow them."""
        self.tell_problem()
        self._state.content = page.state_html(self.session)
        self._modes.content = page.modes_html(self.session.state)
        self._payload.follow(self.session.payload)
        self._efforts.content = page.efforts_html(self.session.robot, efforts)
        self.stale = True
        if not self.session.problem:
            self._follow()
        if self.playback is not None:
            self.playback.refresh()

    def tell_problem(self) -> None:
        """Why the last wish was refused, if it was."""
        self._problem.content = page.problem_html(self.session.problem)
        self._problem.visible = bool(self.session.problem)

    def _follow(self) -> None:
        self.target = np.array(self.session.state.u)
        for dial, value in zip(self.dials, self.target.tolist(), strict=True):
            dial.follow(value)

    def settle(self) -> None:
        """While nothing is asked for: sliders back to the pose, and the assembly modes at its coordinates."""
        self.stale = False  # whatever comes of it: not to be tried again and again
        self._follow()
        if self.session.state.loops:
            self.list_modes()

    def list_modes(self) -> None:
        """Look for the assembly modes at the present coordinates."""
        self.modes = self.session.modes()
        self.labels = page.mode_labels(self.modes, self.session.home.branch)
        present = self.session.present(self.modes)
        self._mode.options = tuple(self.labels) or ("none",)
        if present is not None:
            put(self._mode, self.labels[present])

    # -- what there is

    def _add_sliders(self, ranges: Array) -> None:
        robot = self.session.robot
        self.dials: list[Dial] = []
        with self.gui.add_folder("Active joints"):
            for k, name in enumerate(robot.active):
                kind, limits = (
                    coordinate_unit(robot.joint_types[name]),
                    robot.description.joints[name].limits,
                )
                scope = Range(name, kind, ranges[k, 0], ranges[k, 1], limits)
                self.dials.append(Dial(self.gui, scope, float(self.target[k])))
                self.dials[k].on_wish(f"move {k}", self.ask, partial(self._move, k))
            reset = self.gui.add_button("Reset pose and payload")
            fit = self.gui.add_button("Fit the robot into the picture")
        reset.on_click(lambda _: self.ask("reset", self._reset))

        @fit.on_click
        def _(event: viser.GuiEvent[Any]) -> None:
            self.ask("fit", partial(self.fit, event.client))

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

    def _at_a_box(self) -> None:
        if self.playing:
            self.ask("pause", self._pause)

    def _add_modes(self) -> None:
        with self.gui.add_folder("Assembly mode", visible=bool(self.session.state.loops)):
            self._mode = self.gui.add_dropdown("mode", ("1",))
            self._modes = self.gui.add_html("")

        @self._mode.on_update
        def _(event: viser.GuiEvent[Any]) -> None:
            if by_person(event):
                wanted = str(event.target.value)
                self.ask("mode", lambda: self._take(wanted))

    def _take(self, wanted: str) -> None:
        self._pause()
        if self.stale:
            self.list_modes()
        if wanted in self.labels:
            self.session.take_mode(self.modes[self.labels.index(wanted)])
        else:
            self.session.problem = (
                f"there is no assembly mode '{wanted}' at these active coordinates"
            )

    def _add_efforts(self) -> None:
        robot = self.session.robot
        mass = sum(link.mass for link in robot.description.links.values())
        with self.gui.add_folder("Efforts of the drives"):
            self._efforts = self.gui.add_html("")
            most = round_value(0.5 * mass) if mass else 10.0
            self._payload = Dial(self.gui, Range("payload", "kg", 0.0, most), 0.0)
        self._payload.on_wish("payload", self.ask, self.session.lift)
