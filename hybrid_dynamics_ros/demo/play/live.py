"""The live view: the newest messages as a table on a terminal, otherwise as lines."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Mapping, Sequence
from typing import Final, TextIO

from ..expectation import Expectation
from .snapshot import take_snapshot
from .table import Progress, Row, line, table

TABLE_PERIOD: Final = 0.2  # [s]
LINE_PERIOD: Final = 1.0  # [s]

_HIDE_CURSOR: Final = "\x1b[?25l"
_SHOW_CURSOR: Final = "\x1b[?25h"
_CLEAR_LINE: Final = "\x1b[2K"
_BOLD: Final = "\x1b[1m"
_PLAIN: Final = "\x1b[0m"
_BAR: Final = "━─"
_ASCII_BAR: Final = "#-"


class LiveView:
    """Draws on a stream, at most a few times a second."""

    def __init__(self, stream: TextIO, expected: Expectation, prismatic: frozenset[str]) -> None:
        """Store the arguments.

        Args:
            stream: the output stream.
            expected: the expected output.
            prismatic: coordinates that are lengths; the others are angles.
        """
        self._stream = stream
        self._expected = expected
        self._prismatic = prismatic
        self._animated = stream.isatty() and os.environ.get("TERM", "dumb") != "dumb"
        self._bar = _BAR if _can_show(_BAR, stream) else _ASCII_BAR
        self._height = 0  # rows drawn above the cursor
        self._next = 0.0  # [s] time of the next drawing

    def update(self, latest: Mapping[str, bytes], counts: Mapping[str, int]) -> None:
        """Draw the newest messages if a period has passed.

        Args:
            latest: CDR bytes of the newest message, by topic.
            counts: number of messages so far, by topic.
        """
        now = time.monotonic()
        if now >= self._next:
            self._draw(latest, counts)
            period = TABLE_PERIOD if self._height else LINE_PERIOD
            self._next = now + period

    def close(self, latest: Mapping[str, bytes], counts: Mapping[str, int]) -> None:
        """Draw the last state, and leave the cursor below it; arguments are those of `update`."""
        self._draw(latest, counts)
        if self._height:
            self._write(_SHOW_CURSOR)
            self._height = 0

    def _draw(self, latest: Mapping[str, bytes], counts: Mapping[str, int]) -> None:
        snapshot = take_snapshot(latest)
        if snapshot is None or not snapshot.effort:  # the active joints are those with efforts
            return
        played = (snapshot.stamp_ns - int(self._expected.stamp_ns[0])) * 1e-9
        progress = Progress(played, self._expected.duration, counts)
        rows = table(snapshot, progress, self._prismatic, self._bar)
        size = shutil.get_terminal_size()
        if self._animated and len(rows) < size.lines:
            self._redraw(rows, size.columns - 1)
        else:
            self._write(line(snapshot, progress, self._prismatic) + "\n")

    def _redraw(self, rows: Sequence[Row], width: int) -> None:
        """Draw the table over the last one."""
        start = f"\x1b[{self._height}A" if self._height else _HIDE_CURSOR
        lines = [_styled(row, width) for row in rows]
        self._write("\r" + start + "".join(lines))
        self._height = len(rows)

    def _write(self, text: str) -> None:
        self._stream.write(text)
        self._stream.flush()


def _styled(row: Row, width: int) -> str:
    """A row with terminal codes, cut to a width [letters]."""
    text = row.text[:width]
    if row.heading:
        text = f"{_BOLD}{text}{_PLAIN}"
    return f"{_CLEAR_LINE}{text}\n"


def _can_show(text: str, stream: TextIO) -> bool:
    try:
        text.encode(stream.encoding or "ascii")
    except UnicodeEncodeError:
        return False
    return True
