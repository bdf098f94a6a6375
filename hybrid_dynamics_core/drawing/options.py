"""Checks of the options of drawings."""

from __future__ import annotations

from typing import Literal, cast, get_args

from ..errors import InputError

Names = Literal["none", "active", "joints", "all"]
Colour = Literal["singularity", "limits"]


def checked_names(names: str) -> Names:
    """Check the option `names`.

    Raises:
        InputError: it is not one of `Names`.
    """
    return cast("Names", _checked("names", names, get_args(Names)))


def checked_colour(colour: str) -> Colour:
    """Check the option `colour`.

    Raises:
        InputError: it is not one of `Colour`.
    """
    return cast("Colour", _checked("colour", colour, get_args(Colour)))


def _checked(option: str, value: str, choices: tuple[str, ...]) -> str:
    if value not in choices:
        raise InputError(f"{option}: '{value}' is none of {', '.join(choices)}")
    return value
