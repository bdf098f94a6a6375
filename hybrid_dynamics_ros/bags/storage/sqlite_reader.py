"""sqlite3 files of rosbag2."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

from hybrid_dynamics_core.ground.wording import counted

from ..errors import BagError
from .qos import read_profiles
from .storage import Losses, Messages, Topic, decompress_each

_BATCH: Final = 8192  # messages that are read together
_COUNT: Final = "SELECT COUNT(*) FROM messages WHERE topic_id = ?"
_ROWS: Final = "SELECT timestamp, data FROM messages WHERE topic_id = ? ORDER BY timestamp, id"
_NO_DATABASE: Final = (sqlite3.Error, KeyError, ValueError, TypeError, UnicodeDecodeError)


class SqliteReader:
    """One .db3 file, read only."""

    def __init__(self, path: Path, losses: Losses, *, message_compression: bool) -> None:
        """Open the file.

        Args:
            path: the file.
            losses: where to tell what cannot be read.
            message_compression: whether messages are compressed one by one.

        Raises:
            BagError: it is no database of rosbag2.
        """
        self._path = path
        self._losses = losses
        self._message_compression = message_compression
        self._base = sqlite3.connect(f"{path.absolute().as_uri()}?immutable=1", uri=True)
        try:
            rows = self._base.execute("SELECT * FROM topics").fetchall()
            columns = [column[1] for column in self._base.execute("PRAGMA table_info(topics)")]
            self._topics = [dict(zip(columns, row, strict=True)) for row in rows]
            self._ids = {str(topic["name"]): int(topic["id"]) for topic in self._topics}
        except _NO_DATABASE as error:
            self._base.close()
            raise BagError(f"{path.name}: cannot be read as a sqlite3 bag ({error})") from error

    def close(self) -> None:
        """Close the file."""
        self._base.close()

    def topics(self) -> list[Topic]:
        """The topics that the file says it holds."""
        return [self._topic(entry) for entry in self._topics]

    def read(self, wanted: frozenset[str] | None) -> Iterator[tuple[str, Messages]]:
        """Messages, topic after topic, each in the order of log times."""
        for name, number in self._ids.items():
            if wanted is None or name in wanted:
                for messages in self._batches(name, number):
                    yield name, messages

    def _topic(self, entry: dict[str, Any]) -> Topic:
        try:
            (count,) = self._base.execute(_COUNT, (entry["id"],)).fetchone()
        except sqlite3.Error:
            count = None  # reading tells what is wrong
        return Topic(
            name=str(entry["name"]),
            kind=str(entry["type"]),
            qos=read_profiles(entry.get("offered_qos_profiles")),
            digest=str(entry.get("type_description_hash") or ""),
            message_count=count,
        )

    def _batches(self, name: str, number: int) -> Iterator[Messages]:
        done = 0
        try:
            cursor = self._base.execute(_ROWS, (number,))
            while rows := cursor.fetchmany(_BATCH):
                messages = self._messages(name, rows)
                done += len(messages)
                yield self._decompress(messages)
        except (sqlite3.Error, OverflowError) as error:
            self._losses.add(
                f"{self._path.name}: {name}: cannot be read beyond message {done} ({error})"
            )

    def _messages(self, name: str, rows: Sequence[tuple[Any, Any]]) -> Messages:
        """The messages of some rows; rows of other types are lost."""
        times: list[int] = []
        contents: list[bytes] = []
        for log_ns, data in rows:
            if isinstance(log_ns, int) and isinstance(data, bytes):
                times.append(log_ns)
                contents.append(data)
        lost = len(rows) - len(times)
        if lost:
            self._losses.add(f"{self._path.name}: {name}: {counted(lost, 'row')} without a message")
        return Messages.of(times, contents)

    def _decompress(self, messages: Messages) -> Messages:
        if not self._message_compression:
            return messages
        return decompress_each(messages, self._losses, self._path.name)
