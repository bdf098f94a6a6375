"""Word of compiling while one waits for it: after a second of silence, at most once a second, and never twice the same.

It goes to the logger of this module, at level INFO. Where nobody listens there, a terminal gets it
as a line on stderr; a program whose output goes elsewhere, and one that finds everything in the
cache, gets none.
"""

from __future__ import annotations

import logging
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

PATIENCE = 1.0  # [s] of compiling, of one program or of several, before a word is said

_log = logging.getLogger(__name__)


class Waiting:
    """How long compiling has gone on without a word."""

    def __init__(self) -> None:
        self._silent = 0.0
        self._said: set[str] = set()

    @contextmanager
    def during(self, label: str) -> Iterator[None]:
        """Around compiling: says `label` when it has lasted too long.

        A thread waits, since LLVM cannot be asked.
        """
        if label in self._said:  # another part of the same
            yield
            return
        told = threading.Event()
        timer = threading.Timer(max(0.0, PATIENCE - self._silent), _tell, (label, told))
        timer.daemon = True
        start = time.monotonic()
        timer.start()
        try:
            yield
        finally:
            timer.cancel()
            self._silent += time.monotonic() - start
            if told.is_set():
                self._said.add(label)
                self._silent = 0.0


def _tell(label: str, told: threading.Event) -> None:
    told.set()
    line = f"compiling {label}"
    if _log.isEnabledFor(logging.INFO):
        _log.info("%s", line)
    elif sys.stderr is not None and sys.stderr.isatty():
        sys.stderr.write(f"{line} ...\n")
        sys.stderr.flush()


WAITING = Waiting()
