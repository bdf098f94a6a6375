"""Sliders, buttons and tables beside the scene."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import viser

from ..assembly import AssemblyMode
from ..description.model import Array
from . import page
from .asking import Ask, by_person, put
from .playback import Playback
from .ranges import on_round_steps, on_step, round_value, slider_ranges
from .session import Efforts, Session


class Panel:
    """The controls. What a person does is handed to `ask`; nothing of the robot is touched in viser's threads."""

    def __init__(self, server: viser.ViserServer, session: Session, size: float, ask: Ask) -> None:
        self.gui, self.session, self.ask = server.gui, session, ask
        self.target = np.array(session.state.u)
        self.modes: tuple[AssemblyMode, ...] = ()
        self.labels: list[str] = []
        self.stale = bool(session.state.loops)  # the list of modes
        self.gui.add_html(page.SHEET)
        self._problem = self.gui.add_html("", visible=False)
        self.playback = None if session.motion is None else Playback(self.gui, session, session.motion, ask)
        self._add_sliders(slider_ranges(session.robot, session.home, size))
        with self.gui.add_folder("State"):
            self._state = self.gui.add_html("")
        self._add_efforts()
        self._add_modes()

    @property
    def playing(self) -> bool:
        """Whether a motion goes on by itself."""
        return self.playback is not None and self.playback.playing

    # -- what is shown -------------------------------------------------------------------------------------------------

    def refresh(self, efforts: Efforts) -> None:
        """Numbers of the present state; sliders where it is, unless it could not follow them."""
        self.tell_problem()
        self._state.content = page.state_html(self.session)
        self._modes.content = page.modes_html(self.session.state)
        put(self._payload, self.session.payload)
        self._efforts.content = page.efforts_html(self.session.robot, efforts)
        self.stale = bool(self.session.state.loops)
        if not self.session.problem:
            self._follow()
        if self.playback is not None:
            self.playback.refresh()

    def tell_problem(self) -> None:
        """Why the last wish was refused, if it was."""
        self._problem.visible = bool(self.session.problem)
        self._problem.content = page.problem_html(self.session.problem)

    def _follow(self) -> None:
        self.target = np.array(self.session.state.u)
        for slider, value in zip(self.sliders, self.target.tolist(), strict=True):
            if abs(value - slider.value) > slider.step:  # a slider that a person holds is left alone
                put(slider, on_step(float(np.clip(value, slider.min, slider.max)), slider.step))

    def list_modes(self) -> None:
        """Look for the assembly modes at the present coordinates."""
        self.stale = False  # whatever comes of it: not to be tried again and again
        self.modes = self.session.modes()
        self.labels = page.mode_labels(self.modes, self.session.home.branch)
        present = self.session.present(self.modes)
        self._mode.options = tuple(self.labels) or ("none",)
        if present is not None:
            put(self._mode, self.labels[present])

    # -- what there is -------------------------------------------------------------------------------------------------

    def _add_sliders(self, ranges: Array) -> None:
        robot = self.session.robot
        self.sliders: list[viser.GuiSliderHandle[float]] = []
        with self.gui.add_folder("Active joints"):
            for k, name in enumerate(robot.active):
                unit = "rad" if robot.joint_types[name] == "revolute" else "m"
                low, high, step = on_round_steps(*ranges[k].tolist())
                start = on_step(float(np.clip(self.target[k], low, high)), step)
                slider = self.gui.add_slider(f"{name} [{unit}]", low, high, step, start)
                slider.on_update(self._moved(k))
                self.sliders.append(slider)
            button = self.gui.add_button("Reset to the reference")
        button.on_click(lambda _: self.ask("reset", self._reset))

    def _moved(self, k: int) -> Callable[[viser.GuiEvent[Any]], None]:
        def moved(event: viser.GuiEvent[Any]) -> None:
            if by_person(event):
                value = float(event.target.value)
                self.ask(f"move {k}", lambda: self._move(k, value))

        return moved

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
            self.session.problem = f"there is no assembly mode '{wanted}' at these active coordinates"

    def _add_efforts(self) -> None:
        robot = self.session.robot
        mass = sum(link.mass for link in robot.description.links.values())
        with self.gui.add_folder("Efforts of the drives"):
            self._efforts = self.gui.add_html("")
            most = round_value(0.5 * mass) if mass else 10.0
            self._payload = self.gui.add_slider("payload [kg]", 0.0, most, most / 200.0, 0.0)

        @self._payload.on_update
        def _(event: viser.GuiEvent[Any]) -> None:
            if by_person(event):
                value = float(event.target.value)
                self.ask("payload", lambda: setattr(self.session, "payload", value))
