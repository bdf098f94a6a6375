"""Controls for playback of a motion: play, pause, speed, time."""

from __future__ import annotations

from functools import partial
from typing import Any, Final

import viser

from .gui_events import Enqueue, in_order
from .motion import Motion
from .panel_html import note_html
from .ranges import Range
from .session import ViewSession
from .slider import Slider

SPEEDS: Final = ("0.1 x", "0.25 x", "0.5 x", "1 x", "2 x", "5 x", "10 x")
_REAL_TIME: Final = "1 x"
STEP: Final = 1e-3  # [s] step of the time slider


class Playback:
    """Playback of a motion; `tick` advances it while `playing`.

    Args:
        gui: the GUI of viser.
        session: the session that shows the samples.
        motion: the motion.
        enqueue: receives actions of users.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        session: ViewSession,
        motion: Motion,
        enqueue: Enqueue,
    ) -> None:
        self.session = session
        self.motion = motion
        self.playing = False
        self.time = 0.0
        self.speed = 1.0
        with gui.add_folder(motion.title):
            self._play = gui.add_button("Play")
            scope = Range("time", "s", 0.0, motion.duration)
            self.slider = Slider(gui, scope, 0.0, STEP)
            if motion.note:
                gui.add_html(note_html(motion.note))
            speed = gui.add_dropdown("speed", SPEEDS, initial_value=_REAL_TIME)
        self._play.on_click(in_order(lambda _: enqueue("play", self._toggle)))
        self.slider.on_request("time", enqueue, self.seek)

        @speed.on_update
        @in_order
        def _(event: viser.GuiEvent[Any]) -> None:
            value = float(str(event.target.value).removesuffix(" x"))
            enqueue("speed", partial(self._set_speed, value))

    def seek(self, time: float) -> None:
        """Show the sample nearest to a time [s]."""
        self.time = time
        self.session.show_sample(self.motion.index(time))

    def tick(self, elapsed: float) -> None:
        """Advance while playing, and stop at the end.

        Args:
            elapsed: real time since the last tick [s].
        """
        if self.playing:
            time = self.time + elapsed * self.speed
            self.seek(min(time, self.motion.duration))
            self.playing = self.time < self.motion.duration

    def refresh(self) -> None:
        """Update the controls."""
        self._play.label = "Pause" if self.playing else "Play"
        self.slider.follow(self.time)

    def _set_speed(self, speed: float) -> None:
        self.speed = speed

    def _toggle(self) -> None:
        self.playing = not self.playing
        # at the end it restarts
        if self.playing and self.time >= self.motion.duration:
            self.time = 0.0
        self.seek(self.time)
