"""Conversion of colours between entries of a description and four numbers."""

from __future__ import annotations

import re
from collections.abc import Sequence

from ..model import Colour

EXPECTED = "expected '#rrggbb', or [red, green, blue] with numbers from 0 to 1, opacity behind"
_HEX = re.compile(r"#([0-9a-fA-F]{6})([0-9a-fA-F]{2})?")


def colour_from_text(text: str) -> Colour:
    """The colour of '#rrggbb' or '#rrggbbaa'.

    Raises:
        ValueError: the text has another form.
    """
    if not _HEX.fullmatch(text):
        raise ValueError(f"is '{text}'; {EXPECTED}")
    digits = text.removeprefix("#").ljust(8, "f")
    red, green, blue, opacity = (byte / 255.0 for byte in bytes.fromhex(digits))
    return red, green, blue, opacity


def colour_from_numbers(numbers: Sequence[float]) -> Colour:
    """The colour with three or four numbers from 0 to 1.

    Raises:
        ValueError: a number is out of range, or their count is wrong.
    """
    if len(numbers) not in (3, 4) or not all(0.0 <= number <= 1.0 for number in numbers):
        listed = ", ".join(f"{number:g}" for number in numbers)
        raise ValueError(f"is [{listed}]; {EXPECTED}")
    red, green, blue, *opacity = numbers
    return red, green, blue, opacity[0] if opacity else 1.0


def colour_text(colour: Colour) -> str | list[float]:
    """The entry of a colour in a description: a text if it is exact, otherwise numbers."""
    levels = [round(255.0 * number) for number in colour]
    if tuple(level / 255.0 for level in levels) == colour:
        text = "#" + "".join(f"{level:02x}" for level in levels)
        return text.removesuffix("ff") if levels[3] == 255 else text
    return list(colour[:3]) if colour[3] == 1.0 else list(colour)
