"""From viser's event loop to the thread that moves the robot."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import viser

Action = Callable[[], None]
Enqueue = Callable[
    [str, Action], None
]  # a key, of which only the last action counts, and what to do
Handler = Callable[["viser.GuiEvent[Any]"], Coroutine[Any, Any, None]]


def in_order(act: Callable[[viser.GuiEvent[Any]], None]) -> Handler:
    """Hear of events of controls in the order in which the browser sent them.

    viser gives plain functions to a pool of threads, where a later event may overtake.

    Args:
        act: returns at once, it runs in viser's event loop.
    """

    async def handle(event: viser.GuiEvent[Any]) -> None:
        act(event)

    return handle


def set_value(control: viser.GuiInputHandle[Any], value: float | str) -> None:
    """Move a control from the program."""
    control.value = value  # type: ignore[misc]  # mypy does not see viser's setter


def is_from_browser(event: viser.GuiEvent[Any]) -> bool:
    """Whether a control was moved in a browser; viser calls back for moves of the program too."""
    return event.client is not None
