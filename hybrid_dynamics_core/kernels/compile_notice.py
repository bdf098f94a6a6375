"""A notice to people who wait for a compiler: after a second of silence, at most once a second.

No line comes twice. It goes to the logger of this module, at level INFO. Where nobody listens
there, a terminal gets it as a line on stderr. A program whose output goes elsewhere gets none, nor
does one that finds everything in the cache.
"""

from __future__ import annotations

import logging
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

PATIENCE = 1.0  # [s] of compiling, of one program or of several, before a line is written

_log = logging.getLogger(__name__)


class CompileNotice:
    """How long compiling has gone on in silence."""

    def __init__(self) -> None:
        self._silence = 0.0  # [s]
        self._labels: set[str] = set()  # that were written

    @contextmanager
    def during(self, label: str) -> Iterator[None]:
        """Around compiling: writes `label` when it has lasted too long.

        A thread waits, since LLVM cannot be asked.
        """
        if label in self._labels:  # another part of the same program
            yield
            return
        written = threading.Event()
        patience = max(0.0, PATIENCE - self._silence)
        timer = threading.Timer(patience, _write, (label, written))
        timer.daemon = True
        start = time.monotonic()
        timer.start()
        try:
            yield
        finally:
            timer.cancel()
            self._silence += time.monotonic() - start
            if written.is_set():
                self._labels.add(label)
                self._silence = 0.0


def _write(label: str, written: threading.Event) -> None:
    written.set()
    line = f"compiling {label}"
    if _log.isEnabledFor(logging.INFO):
        _log.info("%s", line)
    elif sys.stderr is not None and sys.stderr.isatty():
        sys.stderr.write(f"{line} ...\n")
        sys.stderr.flush()


NOTICE = CompileNotice()
