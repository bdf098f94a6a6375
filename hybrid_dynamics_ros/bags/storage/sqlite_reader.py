"""Reader of sqlite3 files of rosbag2.

They have no checksums. So tables are compared with their indices, and rows with their topics.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

from hybrid_dynamics_core.ground.wording import counted

from ..errors import BagError
from .pieces import Piece
from .qos import read_profiles
from .sqlite_leftovers import Leftovers
from .storage import CDR, Losses, Messages, Topic

_BATCH: Final = 8192  # messages per query
_MAX_FAULTS: Final = 5  # reported per file
_COUNTS: Final = "SELECT topic_id, COUNT(*) FROM messages GROUP BY topic_id"
_SPAN: Final = "SELECT MIN(timestamp), MAX(timestamp) FROM messages"
_ROWS: Final = "SELECT timestamp, data FROM messages WHERE topic_id = ? ORDER BY timestamp, id"
# For a damaged file: without an index, up to the first error.
_READABLE_ROWS: Final = "SELECT timestamp, data FROM messages NOT INDEXED WHERE topic_id = ?"
_DEFINITIONS: Final = "SELECT * FROM message_definitions"
_NO_DATABASE: Final = (sqlite3.Error, KeyError, ValueError, TypeError, OverflowError, MemoryError)


class SqliteReader:
    """A reader of one .db3 file."""

    def __init__(self, path: Path, losses: Losses) -> None:
        """Open the file.

        Args:
            path: the file.
            losses: receives texts on parts that cannot be read.

        Raises:
            BagError: the file is no database of rosbag2.
        """
        self._path = path
        self._losses = losses
        self._leftovers = Leftovers(path, self._lose)
        try:
            self._base = self._leftovers.connect()
        except sqlite3.Error as error:
            self._leftovers.close()
            raise _no_bag(path, error) from error
        try:
            # Without this, truncated files are refused; nothing is written.
            self._base.execute("PRAGMA writable_schema = ON")
            topics = self._table("SELECT * FROM topics")
            self._topics = {str(topic["name"]): topic for topic in topics}
            self._numbers = {name: int(topic["id"]) for name, topic in self._topics.items()}
        except _NO_DATABASE as error:
            self.close()
            raise _no_bag(path, error) from error
        self._is_sound = self._check()
        self._definitions = self._read_definitions()
        self._counts = self._count()

    def close(self) -> None:
        """Close the file."""
        self._base.close()
        self._leftovers.close()

    def topics(self) -> list[Topic]:
        """The topics of the file."""
        return [self._topic(name, entry) for name, entry in self._topics.items()]

    def pieces(self, wanted: frozenset[str] | None) -> list[Piece]:
        """The whole file as one piece."""
        try:
            span = self._base.execute(_SPAN).fetchone()
        except sqlite3.Error:
            span = (0, 0)
        if not all(isinstance(time, int) for time in span):
            span = (0, 0)

        def read() -> Iterator[tuple[str, Messages]]:
            for name, number in self._numbers.items():
                if wanted is None or name in wanted:
                    for messages in self._batches(name, number):
                        yield name, messages

        return [Piece(span, read)]

    def _lose(self, what: str) -> None:
        self._losses.add(f"{self._path.name}: {what}")

    def _table(self, query: str) -> list[dict[str, Any]]:
        """Rows of a query as dictionaries; raises sqlite3.Error."""
        cursor = self._base.execute(query)
        columns = [column[0] for column in cursor.description]
        return [dict(zip(columns, row, strict=True)) for row in cursor]

    def _check(self) -> bool:
        """Whether the file passes SQLite's integrity check; faults are added to the losses."""
        try:
            rows = self._base.execute(f"PRAGMA integrity_check({_MAX_FAULTS})").fetchall()
            lines = [line for (text,) in rows for line in str(text).splitlines()]
            faults = [line for line in lines if line and not line.startswith("***")]
        except _NO_DATABASE as error:
            faults = [str(error)]
        if faults == ["ok"]:
            return True
        for fault in faults[:_MAX_FAULTS]:
            self._lose(f"is damaged: {fault}")
        return False

    def _read_definitions(self) -> dict[str, tuple[str, str]]:
        """Language and text of message definitions by type; empty for older files."""
        try:
            rows = self._table(_DEFINITIONS)
            return {
                str(row["topic_type"]): (
                    str(row["encoding"]),
                    str(row["encoded_message_definition"]),
                )
                for row in rows
            }
        except _NO_DATABASE:
            return {}

    def _count(self) -> dict[Any, int] | None:
        """Number of messages by topic number; rows without a topic are added to the losses."""
        try:
            counts = dict(self._base.execute(_COUNTS))
        except sqlite3.Error:
            return None  # reading reports the error
        numbers = set(self._numbers.values())
        lost = sum(count for number, count in counts.items() if number not in numbers)
        if lost:
            self._lose(f"{counted(lost, 'message')} of no topic that is in it")
        return counts

    def _topic(self, name: str, entry: dict[str, Any]) -> Topic:
        kind = str(entry["type"])
        language, definition = self._definitions.get(kind, ("", ""))
        count = None
        if self._counts is not None:
            count = self._counts.get(self._numbers[name], 0)
        return Topic(
            name=name,
            kind=kind,
            qos=read_profiles(entry.get("offered_qos_profiles")),
            definition=definition,
            language=language,
            encoding=str(entry.get("serialization_format") or CDR),
            digest=str(entry.get("type_description_hash") or ""),
            message_count=count,
        )

    def _batches(self, name: str, number: int) -> Iterator[Messages]:
        if not self._is_sound:
            yield self._readable(name, number)
            return
        done = 0
        try:
            cursor = self._base.execute(_ROWS, (number,))
            while rows := cursor.fetchmany(_BATCH):
                messages = self._messages(name, rows)
                done += len(messages)
                yield messages
        except _NO_DATABASE as error:
            self._lose(f"{name}: cannot be read beyond message {done} ({error})")

    def _readable(self, name: str, number: int) -> Messages:
        """The rows of a damaged file up to the first that cannot be read."""
        rows: list[tuple[Any, Any]] = []
        try:
            for row in self._base.execute(_READABLE_ROWS, (number,)):
                rows.append(row)  # noqa: PERF402 - those before an error count
        except _NO_DATABASE as error:
            self._lose(f"{name}: cannot be read beyond message {len(rows)} ({error})")
        messages = self._messages(name, rows)
        return messages.part(messages.log_ns.argsort(kind="stable"))

    def _messages(self, name: str, rows: Sequence[tuple[Any, Any]]) -> Messages:
        """The messages of some rows; rows of other types are added to the losses."""
        times: list[int] = []
        contents: list[bytes] = []
        for log_ns, data in rows:
            if isinstance(log_ns, int) and isinstance(data, bytes):
                times.append(log_ns)
                contents.append(data)
        lost = len(rows) - len(times)
        if lost:
            self._lose(f"{name}: {counted(lost, 'row')} without a message")
        return Messages.of(times, contents)


def _no_bag(path: Path, error: Exception) -> BagError:
    return BagError(f"{path.name}: cannot be read as a sqlite3 bag ({error})")
