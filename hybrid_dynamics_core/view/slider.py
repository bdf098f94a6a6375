"""A slider with its number box: takes what lies within its range, tells what does not, and goes back."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
import viser

from ..errors import InputError
from .gui_events import Ask, by_person, put
from .ranges import Range, decimals, on_round_steps, on_step

ROOM: Final = 5  # significant digits that its box has room for


class Dial:
    """The control of one quantity. It shows round steps; its ends are those of the range itself.

    step: of the slider; where none is given, round and at most a thousandth of the range.
    """

    def __init__(
        self, gui: viser.GuiApi, scope: Range, value: float, step: float | None = None
    ) -> None:
        self.scope = scope
        first, last, own = on_round_steps(scope.low, scope.high)
        if step is not None:
            first, last, own = on_step(scope.low, step), max(on_step(scope.high, step), step), step
        self.step = own
        self._ends = first, last
        self.label = f"{scope.name} [{scope.unit}]"
        self.slider = gui.add_slider(self.label, first, last, own, self._on_slider(value))
        self.shown = value
        self._known = self.slider.value  # what it stands at, as far as wishes were heard,
        self._meant = value  # and what that stands for
        self._wish: Callable[[Callable[[], float]], None] = lambda _: None

    def on_wish(self, key: str, ask: Ask, act: Callable[[float], None]) -> None:
        """Call `act` with each value that a person gives and that lies within the range."""
        self._wish = lambda value: ask(key, lambda: act(value()))

        @self.slider.on_update
        def _(event: viser.GuiEvent[Any]) -> None:
            if by_person(event):
                wished = float(event.target.value)
                self._wish(lambda: self.take(wished))

    def typed(self, read: Callable[[Range], float]) -> None:
        """Wish for what was typed into the number box; `read` raises InputError where that is no number."""
        self._wish(lambda: self.take_typed(read(self.scope)))

    def take(self, wished: float) -> float:
        """What a value of the slider stands for.

        Beyond the range: back to what is shown, and InputError.
        """
        self._known = wished
        try:
            self._meant = self.scope.take(wished, 0.5 * self.step)
        except InputError:
            self.show(self.shown)
            raise
        return self._meant

    def take_typed(self, wished: float) -> float:
        """The very number that was typed; of the round ends that the slider shows, the range's own.

        Or InputError.
        """
        self._meant = self.scope.take(wished, 0.5 * self.step if wished in self._ends else 0.0)
        rounded = float(f"{wished:.{ROOM}g}")
        self._stand(rounded, max(decimals(rounded), decimals(self.step)))
        return self._meant

    def show(self, value: float) -> None:
        """Stand at a value, or at the end that is nearest to it."""
        self.shown = self._meant = value
        self._stand(self._on_slider(value), decimals(self.step))

    def follow(self, value: float) -> None:
        """Stand at a value; where it stands for that, or a newer wish is under way, it stays: a person may hold it."""
        self.shown = value
        if self.slider.value == self._known and abs(value - self._meant) > 1e-6 * self.step:
            self.show(value)

    def _stand(self, value: float, digits: int) -> None:
        self._known = value
        self.slider.precision = digits  # of the box, before what has so many
        put(self.slider, value)

    def _on_slider(self, value: float) -> float:
        return on_step(float(np.clip(value, *self._ends)), self.step)
