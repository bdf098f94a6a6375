"""Typed numbers: they come from the page as text, and are read as the command reads them."""

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
LONGEST: Final = 40  # characters of what was typed that a message repeats


class NumberInput:
    """A hidden line of the page. `script` puts there what was typed into the box of a slider.

    Args:
        gui: of viser.
    """

    def __init__(self, gui: viser.GuiApi) -> None:
        self._line = gui.add_text("typed", "")

    def listen(self, sliders: Iterable[Slider], begin: Callable[[], None]) -> None:
        """Have each slider take what is typed into its box.

        Args:
            sliders: with boxes.
            begin: called when somebody goes to a box.
        """
        by_label = {slider.label: slider for slider in sliders}

        @self._line.on_update
        @in_order
        def _(event: viser.GuiEvent[Any]) -> None:
            if not is_from_browser(event):
                return
            label, text, *_time = json.loads(event.target.value)
            # without a text: somebody went to the box
            if text is None:
                begin()
            else:
                by_label[label].request_typed(partial(parse_number, text))


def parse_number(text: str, scope: Range) -> float:
    """The number that a text is, in the unit of a range.

    Args:
        text: 0.25 or 5e-2; 65*mm or 30*deg in another unit; for an angle also a term, pi/6.
        scope: range of the quantity.

    Raises:
        InputError: the text is none of these. The message says what to type instead.
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
    """What to type instead, as far as that is plain."""
    # the minus sign and the comma of a text that was copied from a page
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
