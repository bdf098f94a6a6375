"""Recovery of sqlite3 files whose recorder was killed, from the logs next to them.

A write-ahead log (`-wal`) has messages that are not in the file yet, in the worst case all of them.
A rollback journal (`-journal`) has the content before an incomplete write. SQLite applies both when
it opens the file, and changes it. This is done in a copy, so bags are not changed.
"""

from __future__ import annotations

import shutil
import sqlite3
import struct
import tempfile
from collections.abc import Callable
from operator import eq
from pathlib import Path
from typing import Final

LOG: Final = "-wal"
JOURNAL: Final = "-journal"
# https://www.sqlite.org/fileformat2.html#walformat: page size, and the salts that its frames repeat
_HEADER: Final = struct.Struct(">8xI4xII8x")
_FRAME: Final = struct.Struct(">8xII8x")
_JOURNAL_MARK: Final = bytes.fromhex("d9d505f920a163d7")  # of a journal to be rolled back

Lose = Callable[[str], None]


class Leftovers:
    """Logs that a recorder left next to a file, and the copy to which they are applied."""

    def __init__(self, path: Path, lose: Lose) -> None:
        """Copy the file and its logs, if there are any.

        Args:
            path: the file.
            lose: function with a text on content that cannot be recovered.
        """
        self._path, self._lose = path, lose
        self._beside = [place for place in map(self._place, (LOG, JOURNAL)) if _has_content(place)]
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        if self._beside:
            self._copy()

    def connect(self) -> sqlite3.Connection:
        """Open the file, or the copy if there are logs. Raises sqlite3.Error."""
        if self._folder is None:
            return sqlite3.connect(f"{self._path.absolute().as_uri()}?immutable=1", uri=True)
        base = sqlite3.connect(Path(self._folder.name) / self._path.name)
        try:
            base.execute("PRAGMA writable_schema = ON")
            base.execute("SELECT COUNT(*) FROM sqlite_master").fetchone()
            self._tell(base)
        except sqlite3.Error:
            base.close()
            raise
        return base

    def close(self) -> None:
        """Delete the copy."""
        if self._folder is not None:
            self._folder.cleanup()

    def _place(self, suffix: str) -> Path:
        return self._path.with_name(self._path.name + suffix)

    def _copy(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="bag_")
        try:
            for source in (*self._beside, self._path):
                shutil.copyfile(source, Path(self._folder.name) / source.name)
        except OSError as error:
            self._folder.cleanup()
            self._folder = None
            names = " and ".join(source.name for source in self._beside)
            self._lose(f"{names} beside it cannot be taken in, which takes a copy ({error})")

    def _tell(self, base: sqlite3.Connection) -> None:
        """Report the content of the logs that was not recovered."""
        for source in self._beside:
            if source.name.endswith(JOURNAL):
                self._tell_journal(source)
                continue
            _, taken, _ = base.execute("PRAGMA wal_checkpoint").fetchone()
            written = max(frames_of(source), 1)
            lost = written - max(int(taken), 0)
            if lost > 0:
                self._lose(
                    f"{source.name} beside it: {lost} of {written} pages are damaged, or of a write"
                    " that did not end; what they hold is lost"
                )

    def _tell_journal(self, source: Path) -> None:
        with source.open("rb") as file:
            is_open = file.read(len(_JOURNAL_MARK)) == _JOURNAL_MARK
        if is_open:
            self._lose(
                f"{source.name} beside it: its recorder did not end the last write, which is lost"
            )


def frames_of(log: Path) -> int:
    """Number of frames of the current run in a write-ahead log, complete or not.

    Frames of an earlier run, which are in the file already, have other salts.
    """
    with log.open("rb") as file:
        start = file.read(_HEADER.size)
        if len(start) < _HEADER.size:
            return 0
        page, *salts = _HEADER.unpack(start)
        last = count = 0
        while len(head := file.read(_FRAME.size)) == _FRAME.size:
            count += 1
            if any(map(eq, _FRAME.unpack(head), salts)):
                last = count
            file.seek(page, 1)
    return last


def _has_content(path: Path) -> bool:
    return path.is_file() and path.stat().st_size > 0
