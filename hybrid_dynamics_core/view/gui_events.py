"""From viser's threads to the one that moves the robot."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import viser

Wish = Callable[[], None]
Ask = Callable[[str, Wish], None]  # a key, of which only the last wish counts, and what to do


def put(control: viser.GuiInputHandle[Any], value: float | str) -> None:
    """Move a control from the program."""
    control.value = value  # type: ignore[misc]  # mypy does not see viser's setter


def by_person(event: viser.GuiEvent[Any]) -> bool:
    """Whether a control was moved in a browser; it calls back as well where the program moves it."""
    return event.client is not None
