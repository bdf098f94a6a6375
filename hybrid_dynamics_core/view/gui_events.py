"""From viser's threads to the one that moves the robot."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import viser

Action = Callable[[], None]
Enqueue = Callable[
    [str, Action], None
]  # a key, of which only the last action counts, and what to do


def set_value(control: viser.GuiInputHandle[Any], value: float | str) -> None:
    """Move a control from the program."""
    control.value = value  # type: ignore[misc]  # mypy does not see viser's setter


def is_from_browser(event: viser.GuiEvent[Any]) -> bool:
    """Whether a control was moved in a browser; viser calls back for moves of the program too."""
    return event.client is not None
