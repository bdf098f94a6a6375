"""What a caller may choose."""

from __future__ import annotations

from typing import Literal, get_args

from ..errors import InputError

Names = Literal["none", "active", "joints", "all"]
Colour = Literal["singularity", "limits"]


def known_names(names: str) -> Names:
    """One of the choices. Raises InputError for others."""
    for known in get_args(Names):
        if names == known:
            return known  # type: ignore[no-any-return]
    raise InputError(f"names: '{names}' is none of {', '.join(get_args(Names))}")


def known_colour(colour: str) -> Colour:
    """One of the choices. Raises InputError for others."""
    for known in get_args(Colour):
        if colour == known:
            return known  # type: ignore[no-any-return]
    raise InputError(f"colour: '{colour}' is none of {', '.join(get_args(Colour))}")
