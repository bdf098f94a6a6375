"""A notice for users who wait for compilation, after a second and at most once a second.

No line is repeated. It goes to the logger of this module, at level INFO. If this logger has no
handler, and stderr is a terminal, the line is written there. There is no notice if everything is in
the cache.
"""

from __future__ import annotations

import logging
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

PATIENCE = 1.0  # [s] of compilation, of one program or several, before a line is written

_log = logging.getLogger(__name__)


class CompileNotice:
    """Measures the time of compilation since the last line."""

    def __init__(self) -> None:
        self._silence = 0.0  # [s]
        self._labels: set[str] = set()  # labels that were written

    @contextmanager
    def during(self, label: str) -> Iterator[None]:
        """A context around compilation, which writes `label` if it takes too long.

        A thread measures the time, since LLVM reports no progress.
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
