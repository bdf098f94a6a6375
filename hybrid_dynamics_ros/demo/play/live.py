"""The live view: the newest messages as a table in its place, or as lines without a terminal."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Mapping
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


class LiveView:
    """Draws on a stream, a few times a second at most, however often it is called."""

    def __init__(self, stream: TextIO, expected: Expectation, prismatic: frozenset[str]) -> None:
        """Where to draw, what will come, and which coordinates are lengths, not angles."""
        self._stream = stream
        self._expected = expected
        self._prismatic = prismatic
        self._animated = stream.isatty() and os.environ.get("TERM", "dumb") != "dumb"
        self._bar = "━─" if _can_show("━─", stream) else "#-"
        self._height = 0  # rows drawn above the cursor
        self._next = 0.0

    def update(self, latest: Mapping[str, bytes], counts: Mapping[str, int]) -> None:
        """Draw the newest messages if it is time to.

        Args:
            latest: CDR bytes of the newest message, by topic.
            counts: number of messages so far, by topic.
        """
        now = time.monotonic()
        if now >= self._next:
            self._draw(latest, counts)
            self._next = now + (TABLE_PERIOD if self._height else LINE_PERIOD)

    def close(self, latest: Mapping[str, bytes], counts: Mapping[str, int]) -> None:
        """Draw the last state, and leave the cursor below it."""
        self._draw(latest, counts)
        if self._height:
            self._write(_SHOW_CURSOR)
            self._height = 0

    def _draw(self, latest: Mapping[str, bytes], counts: Mapping[str, int]) -> None:
        snapshot = take_snapshot(latest)
        if (
            snapshot is None or not snapshot.effort
        ):  # without efforts it does not know the active joints yet
            return
        time_s = (snapshot.stamp_ns - int(self._expected.stamp_ns[0])) * 1e-9
        progress = Progress(time_s, self._expected.duration, counts)
        rows = table(snapshot, progress, self._prismatic, self._bar)
        size = shutil.get_terminal_size()
        if self._animated and len(rows) < size.lines:
            self._redraw(rows, size.columns - 1)
        else:
            self._write(line(snapshot, progress, self._prismatic) + "\n")

    def _redraw(self, rows: list[Row], width: int) -> None:
        back = f"\x1b[{self._height}A" if self._height else _HIDE_CURSOR
        drawn = [f"{_CLEAR_LINE}{_styled(row, width)}\n" for row in rows]
        self._write("\r" + back + "".join(drawn))
        self._height = len(rows)

    def _write(self, text: str) -> None:
        self._stream.write(text)
        self._stream.flush()


def _styled(row: Row, width: int) -> str:
    text = row.text[:width]
    return f"{_BOLD}{text}{_PLAIN}" if row.heading else text


def _can_show(text: str, stream: TextIO) -> bool:
    try:
        text.encode(stream.encoding or "ascii")
    except UnicodeEncodeError:
        return False
    return True
