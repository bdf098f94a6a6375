"""From viser's event loop to the thread that moves the robot."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import viser

Action = Callable[[], None]
Enqueue = Callable[[str, Action], None]  # (key, action): of one key, only the last action is done
Handler = Callable[["viser.GuiEvent[Any]"], Coroutine[Any, Any, None]]


def in_order(act: Callable[[viser.GuiEvent[Any]], None]) -> Handler:
    """A handler that receives events of controls in the order in which the browser sent them.

    viser runs plain functions in a thread pool, where a later event may overtake an earlier one.

    Args:
        act: function to call in viser's event loop; it must return at once.
    """

    async def handle(event: viser.GuiEvent[Any]) -> None:
        act(event)

    return handle


def set_value(control: viser.GuiInputHandle[Any], value: float | str) -> None:
    """Set a control from the program."""
    control.value = value  # type: ignore[misc]  # mypy does not see viser's setter


def is_from_browser(event: viser.GuiEvent[Any]) -> bool:
    """Whether a control was moved in a browser, since viser also reports moves of the program."""
    return event.client is not None
