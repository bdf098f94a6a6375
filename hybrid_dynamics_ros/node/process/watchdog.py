"""Ends a process whose loop stands still, so that whoever started it can start it anew."""

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
PATIENCE: Final = 600.0  # [s] for work that is known to take long: code for a robot
# The limit is counted in ticks: a process that was suspended for hours misses one of them.
_TICKS_PER_LIMIT: Final = 20
# Where it can run, the thread comes first: it writes the reason in the log.
_LAG: Final = 2.0  # [s] from the limit to the second alarm
_REARM_PERIOD: Final = 1.0  # [s] at least between two settings of the alarm, which cost a call each


class Watchdog:
    """Watches the beats of a loop, in two ways.

    A thread writes the reason and where each thread stands into the log, and ends the process. It
    cannot run where the loop hangs in a call that holds Python's interpreter. There an alarm of
    the system writes where each thread stands. A second alarm ends the process.
    """

    def __init__(self, limit: float = LIMIT) -> None:
        """Watch from now on.

        Args:
            limit: time without a beat after which the process ends [s].
        """
        self._limit = limit
        self._now_allowed = limit
        self._beats = 0
        self._armed = 0.0  # when the alarm was armed last [s]
        self._stopped = threading.Event()
        faulthandler.register(signal.SIGALRM, all_threads=True, chain=False)
        self._alarm = OneShotHandler(signal.SIGALRM)
        self._arm()
        # Named for what it does: where the interpreter is held, this name is the reason in the log.
        self._thread = threading.Thread(target=self._end_process_where_loop_stands_still)
        self._thread.daemon = True
        self._thread.start()

    def beat(self) -> None:
        """The loop goes on."""
        self._beats += 1
        if time.monotonic() > self._armed + _REARM_PERIOD:
            self._arm()

    @contextmanager
    def patient(self) -> Iterator[None]:
        """While this lasts the loop may stand still for `PATIENCE`."""
        self._now_allowed = PATIENCE
        self._arm()
        try:
            yield
        finally:
            self._beats += 1
            self._now_allowed = self._limit
            self._arm()

    def stop(self) -> None:
        """Watch no more."""
        self._stopped.set()
        _disarm()

    def _arm(self) -> None:
        """Put both alarms off: the handler takes the first, the default action the second."""
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
