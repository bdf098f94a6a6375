"""A line on the terminal that says how far a long run is; none where it is short or where no one watches."""

from __future__ import annotations

import sys
import time

PATIENCE = 1.0  # [s] a run has to last before anything is shown
PAUSE = 0.1  # [s] between two updates
WIDTH = 30


class Progress:
    """Progress from 0 to `total`; a context manager, so that the line is ended in any case.

    `shown`: None for a terminal only, True or False to force.
    """

    def __init__(self, label: str, total: float, shown: bool | None = None) -> None:
        self._label, self._total = label, total
        self._shown = sys.stderr.isatty() if shown is None else shown
        self._start = time.monotonic()
        self._next = self._start + PATIENCE
        self._drawn = False

    def update(self, done: float) -> None:
        """Tell how far it is."""
        now = time.monotonic()
        if not self._shown or now < self._next:
            return
        self._next, self._drawn = now + PAUSE, True
        share = min(max(done / self._total, 0.0), 1.0) if self._total > 0.0 else 1.0
        bar = "#" * round(WIDTH * share)
        spent = now - self._start
        left = f"{spent / share - spent:.0f} s left" if share > 0.0 else ""
        sys.stderr.write(
            f"\r{self._label} |{bar:<{WIDTH}}| {100.0 * share:3.0f} %  {spent:.0f} s, {left}   "
        )
        sys.stderr.flush()

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self._drawn:
            sys.stderr.write("\n")
            sys.stderr.flush()
