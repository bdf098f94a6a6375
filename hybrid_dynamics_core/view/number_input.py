"""Numbers typed in the page, parsed as on the command line."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any, Final

import viser

from ..description.expressions import evaluate
from ..errors import InputError
from .gui_events import in_order, is_from_browser
from .ranges import Range
from .slider import Slider

_NUMBER: Final = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")
_WITH_UNIT: Final = re.compile(rf"{_NUMBER.pattern}\s*\*\s*[a-zA-Z]+")  # 65*mm
_DEGREES: Final = re.compile(r"\s*\*?\s*(deg|degs|degree|degrees|°)$")
LONGEST: Final = 40  # [characters] longest text repeated in a message


class NumberInput:
    """A hidden text field of the page, to which `script` copies texts typed into slider boxes.

    Args:
        gui: the GUI of viser.
    """

    def __init__(self, gui: viser.GuiApi) -> None:
        self._line = gui.add_text("typed", "")

    def listen(self, sliders: Iterable[Slider], begin: Callable[[], None]) -> None:
        """Pass texts typed into boxes to their sliders.

        Args:
            sliders: the sliders.
            begin: called when a box gets the focus.
        """
        by_label = {slider.label: slider for slider in sliders}

        @self._line.on_update
        @in_order
        def _(event: viser.GuiEvent[Any]) -> None:
            if not is_from_browser(event):
                return
            label, text, *_time = json.loads(event.target.value)
            # no text: a box got the focus
            if text is None:
                begin()
            else:
                by_label[label].request_typed(partial(parse_number, text))


def parse_number(text: str, scope: Range) -> float:
    """Parse a number in the unit of a range.

    Args:
        text: a number such as 0.25 or 5e-2, with another unit as in 65*mm or 30*deg, or for angles
            an expression such as pi/6.
        scope: the range.

    Raises:
        InputError: the text is none of these; the message says what to type instead.
    """
    value = _read(text.strip(), scope.unit)
    if value is None:
        shortened = text
        if len(text) > LONGEST:
            shortened = f"{text[:LONGEST]}..."
        raise InputError(
            f"{scope.name}: '{shortened}' was not taken: {_advice(text.strip(), scope.unit)}"
        )
    return value


def _read(text: str, unit: str) -> float | None:
    try:
        if _NUMBER.fullmatch(text):
            value = float(text)
        elif unit == "rad" or _WITH_UNIT.fullmatch(text):
            value = evaluate(text, {}, names_are="", units=(unit,))
        else:
            return None
    except (ValueError, ArithmeticError):
        return None
    return value if math.isfinite(value) else None


def _advice(text: str, unit: str) -> str:
    """Advice on what to type instead, if possible."""
    # typographic minus and comma of copied texts
    plain = text.replace("−", "-").replace(",", ".")
    guess = _DEGREES.sub("*deg", plain).removesuffix(unit).strip()
    if guess == text or _read(guess, unit) is None:
        angle = ""
        if unit == "rad":
            angle = ", or degrees, as 30*deg"
        return f"write the number alone, in {unit}, as 0.25 or 5e-2{angle}"
    if "," in text:
        return f"decimals have a point, write {guess}"
    return f"write {guess}"
