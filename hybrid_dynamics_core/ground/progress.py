"""A line on the terminal that shows the progress of a long run."""

from __future__ import annotations

import sys
import time

PATIENCE = 1.0  # [s] runs shorter than this show nothing
PAUSE = 0.1  # [s] between two updates
WIDTH = 30


class Progress:
    """Progress from 0 to a total; a context manager, which always ends the line.

    Short runs, and runs without a terminal, show nothing.

    Args:
        label: name of the run, at the beginning of the line.
        total: value at the end of the run.
        shown: True or False to force; None to show on terminals only.
    """

    def __init__(self, label: str, total: float, shown: bool | None = None) -> None:
        self._label = label
        self._total = total
        self._shown = sys.stderr.isatty() if shown is None else shown
        self._start = time.monotonic()
        self._next_update = self._start + PATIENCE
        self._drawn = False

    def update(self, done: float) -> None:
        """Show how far the run is, at most every `PAUSE` seconds."""
        now = time.monotonic()
        if not self._shown or now < self._next_update:
            return
        self._next_update = now + PAUSE
        self._drawn = True
        sys.stderr.write(f"\r{self._line(done, now - self._start)}   ")
        sys.stderr.flush()

    def _line(self, done: float, elapsed: float) -> str:
        share = 1.0
        if self._total > 0.0:
            share = min(max(done / self._total, 0.0), 1.0)
        remaining = ""
        if share > 0.0:
            remaining = f"{elapsed / share - elapsed:.0f} s left"
        bar = "#" * round(WIDTH * share)
        return (
            f"{self._label} |{bar:<{WIDTH}}| {100.0 * share:3.0f} %  {elapsed:.0f} s, {remaining}"
        )

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self._drawn:
            sys.stderr.write("\n")
            sys.stderr.flush()
