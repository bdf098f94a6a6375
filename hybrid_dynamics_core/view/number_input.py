"""Numbers that are typed: they come from the page as text, and are read as the command line reads them."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterable
from typing import Any, Final

import viser

from ..description.expressions import evaluate
from ..errors import InputError
from .gui_events import by_person
from .ranges import Range
from .slider import Dial

_NUMBER: Final = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")
_DEGREES: Final = re.compile(r"\s*\*?\s*(deg|degs|degree|degrees|°)$")
LONGEST: Final = 40  # characters of what was typed that are told again


class Typed:
    """Where the page puts what was typed into the box of a dial: a line of text that nobody sees, see `script`."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._line = gui.add_text("typed", "")

    def listen(self, dials: Iterable[Dial], begin: Callable[[], None]) -> None:
        """Have each of these dials take what is typed into its box; `begin` is called when somebody goes to one."""
        known = {dial.label: dial for dial in dials}

        @self._line.on_update
        def _(event: viser.GuiEvent[Any]) -> None:
            if not by_person(event):
                return
            label, text = json.loads(event.target.value)[:2]
            if text is None:
                begin()
            else:
                known[label].typed(lambda scope: number_typed(text, scope))


def number_typed(text: str, scope: Range) -> float:
    """The number that a text is, in the unit of a range: 0.25, 5e-2; of angles also a term, 30*deg, pi/6.

    Raises InputError with the text and with what to type instead, never another number.
    """
    value = _read(text.strip(), scope.unit)
    if value is None:
        told = text if len(text) <= LONGEST else f"{text[:LONGEST]}..."
        raise InputError(
            f"{scope.name}: '{told}' was not taken: {_instead(text.strip(), scope.unit)}"
        )
    return value


def _read(text: str, unit: str) -> float | None:
    try:
        if _NUMBER.fullmatch(text):
            value = float(text)
        elif unit == "rad":
            value = evaluate(text, {}, names_are="")
        else:
            return None
    except (ValueError, ArithmeticError):
        return None
    return value if math.isfinite(value) else None


def _instead(text: str, unit: str) -> str:
    """What to type for it, as far as that is plain."""
    guess = (
        _DEGREES.sub("*deg", text.replace("−", "-").replace(",", ".")).removesuffix(unit).strip()
    )
    if guess == text or _read(guess, unit) is None:
        angle = ", or degrees, as 30*deg" if unit == "rad" else ""
        return f"write the number alone, in {unit}, as 0.25 or 5e-2{angle}"
    return f"{'decimals have a point, ' if ',' in text else ''}write {guess}"
