"""Reader of bags: rosbag2 folders or files, MCAP or sqlite3, also split, compressed or damaged.

It reads as much as possible. `BagReader.losses` has texts on all other parts.
"""

from __future__ import annotations

import shutil
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
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

from ...messages.interfaces import typestore
from ..errors import BagCallError, BagError, wrong_kind
from .compression import ZSTD_ERRORS, zstd
from .mcap_reader import McapReader
from .metadata import read_metadata
from .pieces import Storage, in_time_order
from .recording_files import are_one_recording, missing_parts, part_name, recording_files
from .sqlite_reader import SqliteReader
from .storage import CDR, Losses, Messages, RawMessage, Topic, unpack_messages

RECORDING: Final = (
    "a recording (a rosbag2 folder, a .mcap or .db3 file, or one of them with .zstd behind)"
)
_MAX_LISTED: Final = 3  # names or losses in an error
_COPY_SIZE: Final = 1 << 20  # [bytes]


class BagReader:
    """An open bag; a context manager.

    Attributes:
        path: the folder or file.
        topics: its topics by name.
        losses: texts on parts that could not be read.
    """

    def __init__(self, path: Path) -> None:
        """Open a folder or a file.

        Raises:
            BagCallError: there is no bag, or there are several.
            BagError: no part of it can be read.
        """
        require_recording(path)
        self.path = path
        self.losses = Losses()
        self._stack = ExitStack()
        self._metadata = read_metadata(path, self.losses)
        try:
            self._files = self._open_all(self._paths())
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
        """Number of messages of all topics in the metadata; a missing number counts as zero."""
        return sum(topic.message_count or 0 for topic in self.topics.values())

    def span(self) -> tuple[int, int] | None:
        """First and last log time [ns]; None without messages."""
        spans = [piece.span for file in self._files for piece in file.pieces(None)]
        if not spans:
            return None
        return min(first for first, _ in spans), max(last for _, last in spans)

    def read(self, wanted: frozenset[str] | None = None) -> Iterator[tuple[str, Messages]]:
        """Read messages in batches of one topic; each topic is in the order of log times.

        Args:
            wanted: names of topics; None for all.
        """
        counts: Counter[str] = Counter()
        pieces = [piece for file in self._files for piece in file.pieces(wanted)]
        is_packed = self._metadata.message_compression
        for name, packed in in_time_order(pieces):
            messages = unpack_messages(packed, self.losses, name, is_packed=is_packed)
            counts[name] += len(messages)
            yield name, messages
        for name, topic in self.topics.items():
            if wanted is None or name in wanted:
                self._check_count(topic, counts[name])

    def _check_count(self, topic: Topic, count: int) -> None:
        """Add a loss if there are fewer messages than in the metadata."""
        expected = topic.message_count
        if expected is not None and count < expected:
            self.losses.add(
                f"{topic.name}: {count} messages could be read of {expected} that the bag says"
                " it has"
            )

    def _paths(self) -> list[Path]:
        """The existing files of this bag."""
        if self.path.is_file():
            return [self.path]
        there = recording_files(self.path)
        if not there:
            raise BagError(f"{self.path}: no .mcap or .db3 file is left of this recording")
        names = self._metadata.file_names
        if not names:
            self._require_one(there)
            return there
        listed = [self.path / name for name in names if (self.path / name).is_file()]
        others = [file for file in there if file not in listed]
        missing = [name for name in names if self.path / name not in listed]
        if len(missing) == len(names) == len(others):  # all files were renamed
            return others
        for name in missing:
            self.losses.add(f"{name}: the file is missing")
        stems = {part_name(Path(name)).stem for name in names}
        parts = [file for file in others if not listed or part_name(file).stem in stems]
        for file in others:
            if file not in parts:
                self.losses.add(f"{file.name}: is not in {BAG_METADATA}, and is not read")
        return [*listed, *parts]

    def _require_one(self, files: Sequence[Path]) -> None:
        """Raise for a folder of several recordings; add losses for missing parts of one."""
        if not are_one_recording(self.path, files, span_of):
            names = ", ".join(file.name for file in files[:_MAX_LISTED])
            raise BagCallError(
                f"{self.path}: holds {len(files)} recordings ({names}, ...), and no"
                f" {BAG_METADATA} that makes them one; name one of them"
            )
        for name in missing_parts(files):
            self.losses.add(f"{name}: missing, though the parts before and behind are there")

    def _open_all(self, paths: Sequence[Path]) -> list[Storage]:
        """Open all files that can be read; raises BagError if there are none."""
        files: list[Storage] = []
        errors: list[BagError] = []
        for path in paths:
            try:
                files.append(self._open(path))
            except BagError as error:
                errors.append(error)
        if not files:
            losses = [f"; lost: {loss}" for loss in self.losses.describe()[:_MAX_LISTED]]
            raise BagError(f"{errors[0]}{''.join(losses)}") from errors[0]
        for problem in errors:
            self.losses.add(str(problem))
        return files

    def _open(self, file: Path) -> Storage:
        reader: type[McapReader | SqliteReader] = SqliteReader
        if storage_suffix(file) == ".mcap":
            reader = McapReader
        if file.suffix == ".zstd":
            file = self._decompress(file)
        storage: Storage = reader(file, self.losses)
        self._stack.callback(storage.close)
        return storage

    def _decompress(self, file: Path) -> Path:
        """Decompress as much of a file as possible into a temporary one."""
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
        """The topics of all files, completed by the metadata."""
        topics: dict[str, Topic] = {}
        for file in self._files:
            for topic in file.topics():
                topics[topic.name] = _with_count_of(topic, topics.get(topic.name))
        for topic in self._metadata.topics:
            stored = topics.get(topic.name)
            if stored is not None:
                topics[topic.name] = self._with_metadata(stored, topic)
            elif topic.message_count:
                self.losses.add(
                    f"{topic.name}: in {BAG_METADATA} with {topic.message_count} messages, and in"
                    " no file that can be read"
                )
            else:
                topics[topic.name] = topic
        return topics

    def _with_metadata(self, stored: Topic, topic: Topic) -> Topic:
        """A topic of the files, with missing data from the metadata."""
        if topic.kind != stored.kind and stored.kind:
            self.losses.add(
                f"{stored.name}: of type {topic.kind} in {BAG_METADATA}, and of {stored.kind} in"
                " its file: one is damaged"
            )
        kind = topic.kind if _is_better(topic.kind, stored.kind) else stored.kind
        encoding = stored.encoding
        if topic.encoding != stored.encoding:
            encoding = CDR
            self.losses.add(
                f"{stored.name}: in the encoding {topic.encoding} by {BAG_METADATA}, and in"
                f" {stored.encoding} by its file; {CDR} is taken"
            )
        count = max(stored.message_count or 0, topic.message_count or 0)
        return replace(
            stored,
            kind=kind,
            qos=topic.qos or stored.qos,
            digest=stored.digest or topic.digest,
            encoding=encoding,
            message_count=count or None,
        )


def _is_better(kind: str, other: str) -> bool:
    """Whether a type is known and the other is not."""
    types = typestore().types
    return not other or (kind in types and other not in types)


def _with_count_of(topic: Topic, earlier: Topic | None) -> Topic:
    """A topic with the number of messages of an earlier file added."""
    if earlier is None or topic.message_count is None or earlier.message_count is None:
        return topic
    return replace(topic, message_count=topic.message_count + earlier.message_count)


def read_raw(path: Path, topic: str) -> list[RawMessage]:
    """All messages of one topic, in the order of log times; empty without the topic.

    Raises:
        BagError: there is no bag, or a part of it cannot be read.
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
    """Check that a path is a bag.

    Raises:
        BagCallError: the path is missing, or of another kind.
    """
    is_bag = classify_path(path).kind is FileKind.BAG
    if not is_bag or (path.is_file() and storage_suffix(path) is None):
        raise wrong_kind(path, RECORDING)


def span_of(path: Path) -> tuple[int, int] | None:
    """First and last log time of a bag [ns]; None if no part of it can be read."""
    try:
        with BagReader(path) as bag:
            return bag.span()
    except (BagError, OSError):
        return None


def bags_of(path: Path) -> list[Path]:
    """The bags at a path: itself, or those in a folder of bags.

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
    has_folders = any(entry.is_dir() for entry in bags)
    if not has_folders and are_one_recording(path, recording_files(path), span_of):
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
