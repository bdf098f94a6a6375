"""SIGINT and SIGTERM: the first one stops the node, the second one ends its process."""

from __future__ import annotations

import os
import signal
import threading
import time
from typing import Final

from .last_words import say
from .one_shot import OneShotHandler

NUMBERS: Final = (signal.SIGINT, signal.SIGTERM)
_GRACE: Final = 0.5  # [s] least time for clean-up before a second signal is effective


class StopSignals:
    """The handlers of the process.

    Attributes:
        requested: event that is set by the first signal.
    """

    def __init__(self) -> None:
        """Install the handlers."""
        self.requested = threading.Event()
        self._first = 0.0  # [s] time of the first signal
        self._one_shots: dict[int, OneShotHandler] = {}
        for number in NUMBERS:
            signal.signal(number, self._on_signal)
            self._one_shots[number] = OneShotHandler(number)

    def ignore(self) -> None:
        """Ignore signals from now on.

        Python removes its handlers before the process ends.
        """
        for number in NUMBERS:
            signal.signal(number, signal.SIG_IGN)

    def _on_signal(self, number: int, _frame: object) -> None:
        self._one_shots[number].arm()
        now = time.monotonic()
        if not self.requested.is_set():
            self._first = now
            self.requested.set()
            return
        # A terminal and a launch file may both forward one Ctrl-C.
        timer = threading.Timer(max(0.0, self._first + _GRACE - now), _end)
        timer.daemon = True
        timer.start()


def _end() -> None:
    say("WARN", "stopped: by a second signal, before all was cleaned up")
    os._exit(0)
