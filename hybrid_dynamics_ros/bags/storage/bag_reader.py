"""Reading bags: rosbag2 folders or single files, MCAP or sqlite3, split, compressed, or damaged.

All that can be read is read. What could not be read is told in `BagReader.losses`.
"""

from __future__ import annotations

import re
import shutil
import tempfile
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Final

from hybrid_dynamics_core.ground.file_kinds import (
    BAG_METADATA,
    FileKind,
    classify_path,
    storage_suffix,
)

from ..errors import BagError, wrong_kind
from .compression import ZSTD_ERRORS, zstd
from .mcap_reader import McapReader
from .metadata import read_metadata
from .sqlite_reader import SqliteReader
from .storage import Losses, Messages, RawMessage, Storage, Topic

RECORDING: Final = (
    "a recording (a rosbag2 folder, a .mcap or .db3 file, or one of them with .zstd behind)"
)
_COPY_SIZE: Final = 1 << 20  # [bytes]


class BagReader:
    """An open bag; a context manager.

    Attributes:
        path: the folder or file.
        topics: its topics by name.
        losses: what could not be read.
    """

    def __init__(self, path: Path) -> None:
        """Open a folder or a file.

        Raises:
            BagCallError: there is no bag.
            BagError: nothing of it can be read.
        """
        require_recording(path)
        self.path = path
        self.losses = Losses()
        self._stack = ExitStack()
        self._metadata = read_metadata(path, self.losses)
        try:
            self._files = [self._open(file) for file in self._paths()]
        except BaseException:
            self._stack.close()
            raise
        self.topics = self._merge_topics()

    def __enter__(self) -> BagReader:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    @property
    def message_count(self) -> int:
        """Messages of all topics, as the bag says; a topic without a number counts as none."""
        return sum(topic.message_count or 0 for topic in self.topics.values())

    def read(self, wanted: frozenset[str] | None = None) -> Iterator[tuple[str, Messages]]:
        """Messages in pieces of one topic, each topic in the order of log times.

        Args:
            wanted: names of topics; None for all.
        """
        counts: Counter[str] = Counter()
        for file in self._files:
            for name, messages in file.read(wanted):
                counts[name] += len(messages)
                yield name, messages
        for name, topic in self.topics.items():
            if wanted is None or name in wanted:
                self._check_count(topic, counts[name])

    def _check_count(self, topic: Topic, count: int) -> None:
        """Add a loss where there are not as many messages as the bag says."""
        expected = topic.message_count
        if expected is not None and count != expected:
            self.losses.add(
                f"{topic.name}: {count} messages could be read of {expected} that the bag says"
                " it has"
            )

    def _paths(self) -> list[Path]:
        """The files that there are of this bag."""
        if self.path.is_file():
            return [self.path]
        files = []
        for name in self._metadata.file_names:
            file = self.path / name
            if file.is_file():
                files.append(file)
            else:
                self.losses.add(f"{name}: the file is missing")
        if not files:
            files = sorted(file for file in self.path.iterdir() if storage_suffix(file) is not None)
        if not files:
            raise BagError(f"{self.path}: no .mcap or .db3 file is left of this recording")
        return files

    def _open(self, file: Path) -> Storage:
        reader: type[McapReader | SqliteReader] = SqliteReader
        if storage_suffix(file) == ".mcap":
            reader = McapReader
        if file.suffix == ".zstd":
            file = self._decompress(file)
        compressed = self._metadata.message_compression
        storage: Storage = reader(file, self.losses, message_compression=compressed)
        self._stack.callback(storage.close)
        return storage

    def _decompress(self, file: Path) -> Path:
        """Decompress a file into a temporary one, as far as it goes."""
        folder = Path(self._stack.enter_context(tempfile.TemporaryDirectory()))
        target = folder / file.stem
        with target.open("wb") as out:
            try:
                with zstd.open(file, "rb") as compressed:
                    shutil.copyfileobj(compressed, out, _COPY_SIZE)
            except (*ZSTD_ERRORS, OSError) as error:
                self.losses.add(
                    f"{file.name}: cannot be unpacked beyond byte {out.tell()} ({error})"
                )
        return target

    def _merge_topics(self) -> dict[str, Topic]:
        """The topics of all files; the metadata come before what the files say."""
        topics: dict[str, Topic] = {}
        for file in self._files:
            for topic in file.topics():
                topics[topic.name] = _with_count_of(topic, topics.get(topic.name))
        for topic in self._metadata.topics:
            stored = topics.get(topic.name, topic)
            qos = topic.qos or stored.qos
            topics[topic.name] = replace(topic, qos=qos, definition=stored.definition)
        return topics


def _with_count_of(topic: Topic, earlier: Topic | None) -> Topic:
    """A topic with the messages that an earlier file has of it."""
    if earlier is None or topic.message_count is None or earlier.message_count is None:
        return topic
    return replace(topic, message_count=topic.message_count + earlier.message_count)


def read_raw(path: Path, topic: str) -> list[RawMessage]:
    """All messages of one topic, in the order of their log times; none without the topic.

    Raises:
        BagError: there is no bag, or not all of it can be read.
    """
    messages: list[RawMessage] = []
    with BagReader(path) as bag:
        for _, part in bag.read(frozenset([topic])):
            messages += part.raw()
        losses = bag.losses.describe()
    if losses:
        raise BagError(f"{path}: {'; '.join(losses)}")
    return messages


def require_recording(path: Path) -> None:
    """Refuse a path that is no bag.

    Raises:
        BagCallError: there is nothing, or something of another kind.
    """
    is_bag = classify_path(path).kind is FileKind.BAG
    if not is_bag or (path.is_file() and storage_suffix(path) is None):
        raise wrong_kind(path, RECORDING)


def bags_of(path: Path) -> list[Path]:
    """The bags that a path means: itself, or those in a folder of bags.

    Raises:
        BagCallError: there are none.
    """
    if not path.is_dir() or (path / BAG_METADATA).is_file():
        require_recording(path)
        return [path]
    entries = sorted(entry for entry in path.iterdir() if not entry.name.startswith("."))
    bags = [entry for entry in entries if _is_bag(entry)]
    if not bags:
        raise wrong_kind(path, RECORDING)
    if _are_parts_of(path, bags):
        return [path]
    return bags


def _is_bag(path: Path) -> bool:
    if storage_suffix(path) is not None:
        return True
    if not path.is_dir():
        return False
    if (path / BAG_METADATA).is_file():
        return True
    return any(storage_suffix(file) is not None for file in path.iterdir())


def _are_parts_of(folder: Path, files: list[Path]) -> bool:
    """Whether these are the files of one bag that lost its metadata."""
    stems = {re.sub(r"_\d+$", "", file.stem) for file in files}
    return stems == {folder.name} and all(file.is_file() for file in files)
