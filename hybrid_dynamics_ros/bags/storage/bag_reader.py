"""Bags in: rosbag2 folders or single files, MCAP or sqlite3, split, compressed, or damaged.

Reads what can be read, and says exactly what could not.
"""

from __future__ import annotations

import re
import shutil
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final, Protocol

import numpy as np
import yaml
from numpy.typing import NDArray
from rosbags.interfaces import Qos
from rosbags.rosbag2.metadata import parse_qos

from hybrid_dynamics_core.ground.file_kinds import (
    BAG_METADATA,
    FileKind,
    classify_path,
    storage_suffix,
)

from ...messages.cdr import Bytes
from ..errors import BagError, wrong_kind

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

RECORDING: Final = (
    "a recording (a rosbag2 folder, a .mcap or .db3 file, or one of them with .zstd behind)"
)
MOST_LOSSES: Final = 1000  # sentences
_KINDS: Final = 20  # of further losses
_OTHERS: Final = "of other kinds"
_NUMBER: Final = re.compile(r"(?<![\w/.-])\d+(?![\w/])")  # those of a name stay
_COPY: Final = 1 << 20  # [bytes] at a time


@dataclass(frozen=True)
class Topic:
    """A topic of a bag: name, message type, and the profiles that its publishers offered."""

    name: str
    kind: str
    qos: tuple[Qos, ...] = ()
    definition: str = ""
    digest: str = ""
    told: int | None = None  # messages, as the bag says


@dataclass(frozen=True, eq=False)
class Messages:
    """Messages of one topic: log times (N,) [ns], and where in `data` each is."""

    log_ns: NDArray[np.int64]
    data: Bytes
    offsets: NDArray[np.int64]
    lengths: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.log_ns)

    def sizes(self) -> list[int]:
        """The lengths that there are, in order."""
        lengths = self.lengths
        alike = len(lengths) > 0 and (lengths == lengths[0]).all()
        return [int(lengths[0])] if alike else [int(size) for size in np.unique(lengths)]

    def message(self, row: int) -> bytes:
        """The bytes of one message."""
        start = int(self.offsets[row])
        return self.data[start : start + int(self.lengths[row])].tobytes()

    def block(self, rows: NDArray[np.intp], size: int) -> Bytes:
        """Messages of one size, (k, size)."""
        offsets = self.offsets[rows]
        step = int(offsets[1] - offsets[0]) if len(rows) > 1 else size
        if step > 0 and (np.diff(offsets) == step).all():
            return np.lib.stride_tricks.as_strided(
                self.data[int(offsets[0]) :], (len(rows), size), (step, 1), writeable=False
            )
        found: Bytes = self.data[offsets[:, None] + np.arange(size)]
        return found

    def part(self, rows: NDArray[Any]) -> Messages:
        """Some of them, in the order asked for."""
        return Messages(self.log_ns[rows], self.data, self.offsets[rows], self.lengths[rows])

    @staticmethod
    def of(log_ns: list[int], messages: list[bytes]) -> Messages:
        """From single messages."""
        lengths = np.array([len(m) for m in messages], dtype=np.int64)
        data = np.frombuffer(b"".join(messages), dtype=np.uint8)
        return Messages(
            np.array(log_ns, dtype=np.int64), data, np.cumsum(lengths) - lengths, lengths
        )


class Storage(Protocol):
    """One file of a bag."""

    def topics(self) -> list[Topic]:
        """What it says it holds."""

    def read(self, wanted: frozenset[str] | None) -> Iterator[tuple[str, Messages]]:
        """Messages of the wanted topics (None: of all), in the order of their log times within a topic."""

    def close(self) -> None:
        """Let go of the file."""


@dataclass(eq=False)
class Losses:
    """What could not be read, a sentence each; after a thousand they are only counted, by kind."""

    _texts: dict[str, None] = field(default_factory=dict)
    _more: Counter[str] = field(default_factory=Counter)

    def add(self, text: str) -> None:
        """One more, unless it is one of those that were told already."""
        if text in self._texts:
            return
        if len(self._texts) < MOST_LOSSES:
            self._texts[text] = None
            return
        kind = _NUMBER.sub("N", text)
        self._more[kind if kind in self._more or len(self._more) < _KINDS else _OTHERS] += 1

    @property
    def told(self) -> list[str]:
        """The sentences, and how many more there were of each kind."""
        return [
            *self._texts,
            *(f"... and {count} more: {kind}" for kind, count in self._more.items()),
        ]


class Source:
    """An open bag; a context manager."""

    def __init__(self, path: Path) -> None:
        """Open a folder or a file.

        Raises:
            BagCallError: there is no bag.
            BagError: nothing of it can be read.
        """
        require_recording(path)
        self.path, self.losses = path, Losses()
        self.read_counts: dict[str, int] = {}
        self._stack = ExitStack()
        self._told = self._metadata()
        try:
            self._files = [self._opened(file) for file in self._paths()]
        except BaseException:
            self._stack.close()
            raise
        self.topics = self._topics()

    def __enter__(self) -> Source:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    @property
    def size(self) -> int:
        """Bytes of all files."""
        return sum(file.stat().st_size for file in self._paths())

    @property
    def expected(self) -> int:
        """Messages of all topics, as the bag tells it; 0 where it does not."""
        return sum(topic.told or 0 for topic in self.topics.values())

    def read(self, wanted: frozenset[str] | None = None) -> Iterator[tuple[str, Messages]]:
        """Messages topic by topic in pieces, each topic in the order of log times; what is lost is in `losses`."""
        self.read_counts = {}
        for file in self._files:
            for found, messages in file.read(wanted):
                self.read_counts[found] = self.read_counts.get(found, 0) + len(messages)
                yield found, messages
        for name, topic in self.topics.items():
            there = self.read_counts.get(name, 0)
            if (
                (wanted is None or name in wanted)
                and topic.told is not None
                and there != topic.told
            ):
                self.losses.add(
                    f"{name}: {there} messages could be read of {topic.told} that the bag says"
                    " it has"
                )

    def _metadata(self) -> Mapping[str, Any]:
        file = self.path / BAG_METADATA
        if not self.path.is_dir() or not file.is_file():
            return {}
        try:
            told = yaml.safe_load(file.read_text(encoding="utf-8"))["rosbag2_bagfile_information"]
            return {
                **told,
                "topics": [_topic_of(entry) for entry in told["topics_with_message_count"]],
            }
        except (OSError, ValueError, KeyError, TypeError, AttributeError, yaml.YAMLError) as error:
            self.losses.add(
                f"{file.name}: cannot be read ({type(error).__name__}); its files are read"
                " without it"
            )
            return {}

    def _paths(self) -> list[Path]:
        if self.path.is_file():
            return [self.path]
        named = [
            self.path / Path(str(name)).name for name in self._told.get("relative_file_paths") or ()
        ]
        for file in named:
            if not file.is_file():
                self.losses.add(f"{file.name}: the file is missing")
        there = [file for file in named if file.is_file()]
        there = there or sorted(f for f in self.path.iterdir() if storage_suffix(f) is not None)
        if not there:
            raise BagError(f"{self.path}: no .mcap or .db3 file is left of this recording")
        return there

    def _opened(self, file: Path) -> Storage:
        from .mcap_reader import McapFile  # noqa: PLC0415 - they use what is here
        from .sqlite_reader import SqliteFile  # noqa: PLC0415

        kind = storage_suffix(file)
        if file.suffix == ".zstd":
            file = self._unpacked(file)
        packed = str(self._told.get("compression_mode") or "").lower() == "message"
        made: Storage = (McapFile if kind == ".mcap" else SqliteFile)(file, self.losses, packed)
        self._stack.callback(made.close)
        return made

    def _unpacked(self, file: Path) -> Path:
        folder = Path(self._stack.enter_context(tempfile.TemporaryDirectory()))
        target = folder / file.stem
        with target.open("wb") as out:
            try:
                with zstd.open(file, "rb") as packed:
                    shutil.copyfileobj(packed, out, _COPY)
            except (zstd.ZstdError, EOFError, OSError) as error:
                self.losses.add(
                    f"{file.name}: cannot be unpacked beyond byte {out.tell()} ({error})"
                )
        return target

    def _topics(self) -> dict[str, Topic]:
        found: dict[str, Topic] = {}
        for file in self._files:
            for topic in file.topics():
                before = found.get(topic.name)
                if before is not None and topic.told is not None and before.told is not None:
                    topic = replace(topic, told=topic.told + before.told)  # noqa: PLW2901
                found[topic.name] = topic
        for topic in self._told.get("topics", ()):
            known = found.get(topic.name, topic)
            found[topic.name] = Topic(
                topic.name,
                topic.kind,
                topic.qos or known.qos,
                known.definition,
                topic.digest,
                topic.told,
            )
        return found


def _topic_of(entry: Mapping[str, Any]) -> Topic:
    told = entry["topic_metadata"]
    name, kind = str(told["name"]), str(told["type"])
    digest = str(told.get("type_description_hash") or "")
    return Topic(
        name,
        kind,
        qos_of(told.get("offered_qos_profiles")),
        "",
        digest,
        int(entry["message_count"]),
    )


def qos_of(told: Any) -> tuple[Qos, ...]:
    """Profiles as bags write them; none where they cannot be read."""
    try:
        return tuple(parse_qos(told or []))
    except Exception:  # noqa: BLE001 - a profile is no reason to refuse a bag
        return ()


def unpack_each(messages: Messages, losses: Losses, where: str) -> Messages:
    """Messages that are compressed one by one."""
    kept, times = [], []
    for row in range(len(messages)):
        try:
            kept.append(zstd.decompress(messages.message(row)))
        except (zstd.ZstdError, EOFError) as error:
            losses.add(
                f"{where}: the message logged at {messages.log_ns[row]} ns cannot be unpacked"
                f" ({error})"
            )
            continue
        times.append(int(messages.log_ns[row]))
    return Messages.of(times, kept)


def require_recording(path: Path) -> None:
    """Refuse what is no bag, before anything else is asked of it.

    Raises:
        BagCallError: there is nothing, or something of another kind.
    """
    there = classify_path(path).kind
    if there is not FileKind.BAG or (path.is_file() and storage_suffix(path) is None):
        raise wrong_kind(path, RECORDING)


def bags_of(path: Path) -> list[Path]:
    """The bags that a path means: itself, or those in a folder of bags.

    Raises:
        BagCallError: there are none.
    """
    if not path.is_dir() or (path / BAG_METADATA).is_file():
        require_recording(path)
        return [path]
    inside = sorted(p for p in path.iterdir() if not p.name.startswith("."))
    found = [p for p in inside if storage_suffix(p) is not None or (p.is_dir() and _is_bag(p))]
    parts = {re.sub(r"_\d+$", "", p.stem) for p in found}
    if found and parts == {path.name} and all(p.is_file() for p in found):
        return [path]  # a bag that lost its metadata
    if not found:
        raise wrong_kind(path, RECORDING)
    return found


def _is_bag(folder: Path) -> bool:
    return (folder / BAG_METADATA).is_file() or any(
        storage_suffix(file) is not None for file in folder.iterdir()
    )
