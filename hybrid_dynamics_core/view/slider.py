"""A slider with a number box, which refuses values out of range."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
import viser

from ..errors import InputError
from .gui_events import Enqueue, in_order, is_from_browser, set_value
from .ranges import Range, decimals, on_round_steps, on_step

Value = Callable[[], float]  # returns a checked value

ROOM: Final = 5  # significant digits that fit into the box


class Slider:
    """The slider of one quantity. It shows round steps; its ends stand for those of the range.

    Args:
        gui: the GUI of viser.
        scope: range of the quantity.
        value: initial value.
        step: step of the slider; None: round, and at most a thousandth of the range.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        scope: Range,
        value: float,
        step: float | None = None,
    ) -> None:
        self.scope = scope
        if step is None:
            first, last, self.step = on_round_steps(scope.low, scope.high)
        else:
            first, last, self.step = _on_given_steps(scope, step)
        self._ends = first, last
        self.label = f"{scope.name} [{scope.unit}]"
        start = self._on_slider(value)
        self.handle = gui.add_slider(self.label, first, last, self.step, start)
        self.shown = value
        # The slider's position after the last request, and the value that it stands for.
        self._position = self.handle.value
        self._meaning = value
        self._request: Callable[[Value], None] = lambda _: None

    def on_request(self, key: str, enqueue: Enqueue, act: Callable[[float], None]) -> None:
        """Call `act` with each value that a user sets within the range."""
        self._request = lambda value: enqueue(key, lambda: act(value()))

        @self.handle.on_update
        @in_order
        def _(event: viser.GuiEvent[Any]) -> None:
            if is_from_browser(event):
                wanted = float(event.target.value)
                self._request(lambda: self.take(wanted))

    def request_typed(self, read: Callable[[Range], float]) -> None:
        """Request a typed value; `read` raises InputError if it is no number."""
        self._request(lambda: self.take_typed(read(self.scope)))

    def take(self, wanted: float) -> float:
        """The value that a slider position stands for.

        Raises:
            InputError: it is out of range; the slider then returns to the shown value.
        """
        self._position = wanted
        try:
            self._meaning = self.scope.take(wanted, 0.5 * self.step)
        except InputError:
            self.show(self.shown)
            raise
        return self._meaning

    def take_typed(self, wanted: float) -> float:
        """The typed number; the slider's round ends are replaced by the ends of the range.

        Raises:
            InputError: it is out of range.
        """
        slack = 0.5 * self.step if wanted in self._ends else 0.0
        self._meaning = self.scope.take(wanted, slack)
        rounded = float(f"{wanted:.{ROOM}g}")
        digits = max(decimals(rounded), decimals(self.step))
        self._stand(rounded, digits)
        return self._meaning

    def show(self, value: float) -> None:
        """Show a value, or the nearest end of the range."""
        self.shown = value
        self._meaning = value
        self._stand(self._on_slider(value), decimals(self.step))

    def follow(self, value: float) -> None:
        """Show a value, unless it is shown already or a newer request is pending.

        In that case a user may be moving the slider.
        """
        self.shown = value
        is_settled = self.handle.value == self._position
        if is_settled and abs(value - self._meaning) > 1e-6 * self.step:
            self.show(value)

    def _stand(self, value: float, digits: int) -> None:
        self._position = value
        self.handle.precision = digits  # decimals of the box, set before the value
        set_value(self.handle, value)

    def _on_slider(self, value: float) -> float:
        nearest = float(np.clip(value, *self._ends))
        return on_step(nearest, self.step)


def _on_given_steps(scope: Range, step: float) -> tuple[float, float, float]:
    """Lower end, upper end and step of a slider with a given step."""
    first = on_step(scope.low, step)
    last = max(on_step(scope.high, step), step)
    return first, last, step
