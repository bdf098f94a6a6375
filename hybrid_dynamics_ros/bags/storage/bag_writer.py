"""Writer of bags: rosbag2 folders with one MCAP file.

A bag is written in a hidden folder beside its path, and renamed when it is complete.
"""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Final

from hybrid_dynamics_core.ground.file_kinds import BAG_METADATA

from ..errors import BagCallError
from .mcap_chunk import RecordBlock
from .mcap_writer import McapWriter
from .metadata import metadata_text
from .storage import Messages, RawMessage, Topic

THERE: Final = "there is a bag already; name a new folder, or give --overwrite"
_MAX_BUFFERED: Final = 1024  # single messages per chunk
_BAG_FILE: Final = re.compile(r"metadata\.yaml|.*\.(mcap|db3)(\.zstd|-shm|-wal)?")


class BagWriter:
    """An open bag.

    Attributes:
        channels: number of the channel of each topic.
    """

    def __init__(
        self, folder: Path, topics: Sequence[Topic], notes: Mapping[str, str] | None = None
    ) -> None:
        """Begin a bag.

        Args:
            folder: its folder, which must not exist.
            topics: all topics of the bag.
            notes: custom data for its metadata.
        """
        folder.mkdir()
        self._folder = folder
        self._topics = [topic.with_type_description() for topic in topics]
        self._notes = dict(notes or {})
        self._file_name = f"{folder.name}.mcap"
        self._file = McapWriter(folder / self._file_name, self._topics)
        self._buffer: list[tuple[int, RawMessage]] = []  # (channel, message)
        self.channels = self._file.channels

    @property
    def thread_time(self) -> float:
        """Time of the thread that compresses and writes chunks [s]."""
        return self._file.thread_time

    def write(self, blocks: Sequence[RecordBlock]) -> None:
        """Write one chunk of messages; raises errors of this or an earlier chunk."""
        self._file.write(blocks)

    def write_message(self, topic: str, log_ns: int, data: bytes) -> None:
        """Append one message, which is written with a later chunk.

        Args:
            topic: name of its topic.
            log_ns: log time [ns].
            data: CDR bytes.
        """
        self._buffer.append((self.channels[topic], RawMessage(log_ns, data)))
        if len(self._buffer) >= _MAX_BUFFERED:
            self._write_buffer()

    def close(self) -> None:
        """Write pending messages, index and metadata."""
        self._write_buffer()
        self._file.close()
        counts = self._file.counts
        topics = [
            replace(topic, message_count=counts[self.channels[topic.name]])
            for topic in self._topics
        ]
        text = metadata_text(self._file_name, topics, self._file.log_span, self._notes)
        (self._folder / BAG_METADATA).write_text(text, encoding="utf-8")

    def abort(self) -> None:
        """Discard the bag."""
        self._file.abort()

    def _write_buffer(self) -> None:
        """Write the buffered messages as a chunk."""
        by_channel: dict[int, list[RawMessage]] = {}
        for channel, message in self._buffer:
            by_channel.setdefault(channel, []).append(message)
        self._buffer = []
        blocks: list[RecordBlock] = []
        for channel, messages in by_channel.items():
            messages.sort(key=_log_time)
            times = [message.log_ns for message in messages]
            contents = [message.data for message in messages]
            blocks += RecordBlock.copies(channel, Messages.of(times, contents))
        self.write(blocks)


def _log_time(message: RawMessage) -> int:
    return message.log_ns


@contextmanager
def new_bag(
    path: Path, topics: Sequence[Topic], notes: Mapping[str, str] | None = None
) -> Iterator[BagWriter]:
    """Write a bag; an existing one is replaced.

    After an error or an interruption, `path` is unchanged.

    Args:
        path: folder of the bag.
        topics: all topics of the bag.
        notes: custom data for its metadata.

    Raises:
        BagCallError: `path` exists and is no bag.
    """
    path = path.absolute()
    require_replaceable(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = Path(tempfile.mkdtemp(prefix=f".{path.name}.", dir=path.parent))
    try:
        # It has the final name, since the bag's file is named after its folder.
        writer = BagWriter(aside / path.name, topics, notes)
        try:
            yield writer
            writer.close()
        except BaseException:
            writer.abort()
            raise
        _replace(path, aside / path.name, aside / "replaced")
    finally:
        shutil.rmtree(aside, ignore_errors=True)


def _replace(path: Path, new: Path, old: Path) -> None:
    """Move `path` to `old` and `new` to `path`; undo it on failure."""
    if path.exists():
        path.rename(old)
    try:
        new.rename(path)
    except BaseException:
        if old.exists():
            old.rename(path)
        raise


def require_replaceable(path: Path) -> None:
    """Check that a path is missing, an empty folder or a bag.

    Raises:
        BagCallError: the path is no bag.
    """
    if not path.exists():
        return
    if not path.is_dir():
        raise BagCallError(f"{path}: is a file; name a folder for the new bag")
    if path.resolve() == Path.cwd():
        raise BagCallError(f"{path}: is the folder you are in; name a new one for the bag")
    others = [entry.name for entry in path.iterdir() if not _is_bag_file(entry)]
    if others:
        raise BagCallError(
            f"{path}: holds other things than a bag ({min(others)}, ...); name a new folder"
        )


def require_new(path: Path) -> None:
    """Check that a path is missing or an empty folder.

    Raises:
        BagCallError: it exists.
    """
    require_replaceable(path)
    if path.exists() and any(path.iterdir()):
        raise BagCallError(f"{path}: {THERE}")


def _is_bag_file(path: Path) -> bool:
    return path.is_file() and _BAG_FILE.fullmatch(path.name) is not None
