"""A robot with other numbers in its description."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol, TypeVar

from ...description import parameters as numbers
from ...description.model import RobotDescription
from ...description.parameters.written import add_note
from ...errors import DescriptionError, InputError


class Described(Protocol):
    """What is made of a description."""

    def __init__(self, description: RobotDescription) -> None: ...

    @property
    def description(self) -> RobotDescription:
        """The description."""

    @property
    def mode_names(self) -> Mapping[str, tuple[str, ...]]:
        """Assembly modes of the loops that have closed forms."""


R = TypeVar("R", bound=Described)


def with_parameters(robot: R, values: Mapping[str, Any] | None = None, /, **parameters: Any) -> R:
    """A robot with other numbers, as if its file had them.

    Args:
        robot: the robot; not changed.
        values: numbers in SI units, or expressions, by name of `parameters:` or by path, such as
            `joints.q2.origin.xyz[0]`. A path that means several numbers takes as many.
        parameters: the same for names of `parameters:`, as keywords.

    Returns:
        The other robot. A note says which loops lost their closed forms. From the second robot with
        other values of the same numbers on, robots share compiled code.

    Raises:
        InputError: there is no such number, a value is none, or the robot was not read from a file.
        DescriptionError: the numbers do not fit; the loops do not close with them, for example.
    """
    given = dict(values or {})
    for name, value in parameters.items():
        if name in given:
            raise InputError(f"{name}: given twice, in the mapping and as a keyword")
        given[name] = value
    listed = ", ".join(f"{name} = {value}" for name, value in given.items())
    try:
        description = numbers.with_parameters(robot.description, given)
        other = type(robot)(description)
    except DescriptionError as error:
        error.args = (f"{error} (with {listed})",)
        raise
    for loop in robot.mode_names:
        if loop not in other.mode_names:
            note = f"{loop}: no closed form with {listed}; solved by iteration"
            add_note(other.description, note)
    return other
