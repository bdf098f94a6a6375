"""sqlite3 files of rosbag2."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from hybrid_dynamics_core.ground.wording import counted

from ..errors import BagError
from .bag_reader import Losses, Messages, Topic, qos_of, unpack_each

_AT_ONCE: Final = 8192  # messages


class SqliteFile:
    """One .db3 file, read only."""

    def __init__(self, path: Path, losses: Losses, packed: bool) -> None:
        """Open it.

        Raises:
            BagError: it is no database of rosbag2.
        """
        self._path, self._losses, self._packed = path, losses, packed
        self._base = sqlite3.connect(f"{path.absolute().as_uri()}?immutable=1", uri=True)
        try:
            rows = self._base.execute("SELECT * FROM topics").fetchall()
            columns = [column[1] for column in self._base.execute("PRAGMA table_info(topics)")]
            self._topics = [dict(zip(columns, row, strict=True)) for row in rows]
            self._ids = {str(topic["name"]): int(topic["id"]) for topic in self._topics}
        except (sqlite3.Error, KeyError, ValueError, TypeError, UnicodeDecodeError) as error:
            self._base.close()
            raise BagError(f"{path.name}: cannot be read as a sqlite3 bag ({error})") from error

    def close(self) -> None:
        """Let go of the file."""
        self._base.close()

    def topics(self) -> list[Topic]:
        """What it says it holds."""
        found = []
        for told in self._topics:
            query = "SELECT COUNT(*) FROM messages WHERE topic_id = ?"
            try:
                (count,) = self._base.execute(query, (told["id"],)).fetchone()
            except sqlite3.Error:
                count = None  # reading tells what is wrong
            digest = str(told.get("type_description_hash") or "")
            qos = qos_of(told.get("offered_qos_profiles"))
            found.append(Topic(str(told["name"]), str(told["type"]), qos, "", digest, count))
        return found

    def read(self, wanted: frozenset[str] | None) -> Iterator[tuple[str, Messages]]:
        """Messages, topic after topic, each in the order of log times."""
        for name, number in self._ids.items():
            if wanted is None or name in wanted:
                for messages in self._rows(name, number):
                    yield name, messages

    def _rows(self, name: str, number: int) -> Iterator[Messages]:
        query = "SELECT timestamp, data FROM messages WHERE topic_id = ? ORDER BY timestamp, id"
        done = 0
        try:
            cursor = self._base.execute(query, (number,))
            while rows := cursor.fetchmany(_AT_ONCE):
                good = [(t, d) for t, d in rows if isinstance(t, int) and isinstance(d, bytes)]
                if len(good) < len(rows):
                    self._losses.add(
                        f"{self._path.name}: {name}: {counted(len(rows) - len(good), 'row')}"
                        " without a message"
                    )
                messages = Messages.of([t for t, _ in good], [d for _, d in good])
                done += len(good)
                yield (
                    unpack_each(messages, self._losses, self._path.name)
                    if self._packed
                    else messages
                )
        except (sqlite3.Error, OverflowError) as error:
            self._losses.add(
                f"{self._path.name}: {name}: cannot be read beyond message {done} ({error})"
            )
