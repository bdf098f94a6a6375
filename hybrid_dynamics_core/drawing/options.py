"""Checks of the options of drawings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, cast, get_args

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arrays import real_array
from ..ground.suggestions import no_such_name
from ..robot.robot import Robot

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


def vectors_of_links(robot: Robot, displacements: Mapping[str, ArrayLike]) -> dict[str, Array]:
    """Check displacements (6,) of links.

    Raises:
        InputError: there is no such link, or one is not 6 finite numbers.
    """
    vectors: dict[str, Array] = {}
    for name, values in displacements.items():
        if name not in robot.description.links:
            raise InputError(no_such_name("link", name, robot.description.links))
        vector = real_array(f"displacements: {name}", values)
        if vector.shape != (6,) or not np.isfinite(vector).all():
            raise InputError(f"displacements: {name} is no vector of 6 finite numbers")
        vectors[name] = vector
    return vectors


def _checked(option: str, value: str, choices: tuple[str, ...]) -> str:
    if value not in choices:
        raise InputError(f"{option}: '{value}' is none of {', '.join(choices)}")
    return value
