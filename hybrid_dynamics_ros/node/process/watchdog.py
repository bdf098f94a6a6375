"""A watchdog that ends the process if its loop is blocked, so that it can be restarted."""

from __future__ import annotations

import faulthandler
import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from .last_words import say
from .one_shot import OneShotHandler

LIMIT: Final = 10.0  # [s] without a beat
PATIENCE: Final = 600.0  # [s] for work that takes long, such as compilation
# The limit is counted in ticks, since a suspended process misses only one tick.
_TICKS_PER_LIMIT: Final = 20
# The thread fires first if it can run, since it logs the reason.
_LAG: Final = 2.0  # [s] between the limit and the second alarm
_REARM_PERIOD: Final = 1.0  # [s] least time between two settings of the alarm


class Watchdog:
    """Watches the beats of a loop, by a thread and by alarms.

    The thread logs the reason and the stacks of all threads, and ends the process. It cannot run if
    the loop hangs in a call that holds the GIL. Then a system alarm writes the stacks, and a second
    alarm ends the process.
    """

    def __init__(self, limit: float = LIMIT) -> None:
        """Start watching.

        Args:
            limit: longest time without a beat [s].
        """
        self._limit = limit
        self._now_allowed = limit
        self._beats = 0
        self._armed = 0.0  # [s] time of the last setting of the alarm
        self._stopped = threading.Event()
        faulthandler.register(signal.SIGALRM, all_threads=True, chain=False)
        self._alarm = OneShotHandler(signal.SIGALRM)
        self._arm()
        # If the GIL is held, the name of this function is the only reason in the log.
        self._thread = threading.Thread(target=self._end_process_where_loop_stands_still)
        self._thread.daemon = True
        self._thread.start()

    def beat(self) -> None:
        """Register a beat of the loop."""
        self._beats += 1
        if time.monotonic() > self._armed + _REARM_PERIOD:
            self._arm()

    @contextmanager
    def patient(self) -> Iterator[None]:
        """A context in which the loop may be blocked for `PATIENCE`."""
        self._now_allowed = PATIENCE
        self._arm()
        try:
            yield
        finally:
            self._beats += 1
            self._now_allowed = self._limit
            self._arm()

    def stop(self) -> None:
        """Stop watching."""
        self._stopped.set()
        _disarm()

    def _arm(self) -> None:
        """Postpone both alarms: the handler serves the first, the default action the second."""
        self._armed = time.monotonic()
        self._alarm.arm()
        period = (self._now_allowed + _LAG) / 2
        signal.setitimer(signal.ITIMER_REAL, period, period)

    def _end_process_where_loop_stands_still(self) -> None:
        tick = self._limit / _TICKS_PER_LIMIT
        missed = 0
        before: int | None = None
        while not self._stopped.wait(tick):
            missed += 1
            if self._beats != before:
                missed = 0
                before = self._beats
            if missed * tick >= self._now_allowed:
                self._end()

    def _end(self) -> None:
        _disarm()
        stood = f"the loop of the node has stood still for {self._now_allowed:g} s"
        say("FATAL", f"{stood}: the process ends. Where its threads stand:")
        faulthandler.dump_traceback(all_threads=True)
        os._exit(1)


def _disarm() -> None:
    """Stop the timer of the alarms."""
    signal.setitimer(signal.ITIMER_REAL, 0.0)
