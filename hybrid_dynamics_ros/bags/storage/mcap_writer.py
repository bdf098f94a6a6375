"""Bags out: rosbag2 folders with one MCAP file, whose chunks are made and written by a thread beside the caller.

A bag appears under its name when all of it is written; before, it is a hidden folder beside it.
"""

from __future__ import annotations

import re
import shutil
import struct
import tempfile
import time
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, Final

import yaml
from rosbags.interfaces import Qos
from rosbags.rosbag2.metadata import dump_qos_v9

from hybrid_dynamics_core.ground.file_kinds import BAG_METADATA

from ...messages.interfaces import typestore
from ..errors import BagCallError
from .bag_reader import Topic
from .mcap_chunk import Block, Packer
from .mcap_reader import (
    CHANNEL,
    CHUNK,
    CHUNK_INDEX,
    DATA_END,
    FOOTER,
    HEADER,
    INDEX,
    MAGIC,
    SCHEMA,
    STATISTICS,
)

THERE: Final = "there is a bag already; name a new folder, or give --overwrite"
_QUEUED: Final = 4  # chunks that wait to be made and written


class BagWriter:
    """An open bag."""

    def __init__(
        self, folder: Path, topics: Sequence[Topic], notes: Mapping[str, str] | None = None
    ) -> None:
        """Begin a bag in a folder that does not exist, with all of its topics."""
        folder.mkdir()
        self._folder, self._topics, self._notes = folder, list(topics), dict(notes or {})
        self._name = f"{folder.name}.mcap"
        self.channels = {topic.name: k + 1 for k, topic in enumerate(self._topics)}
        self._counts = dict.fromkeys(self.channels.values(), 0)
        self._chunks: list[bytes] = []
        self._first, self._last = 2**63 - 1, 0
        self.beside = 0.0  # [s] that the thread has worked
        self._packer, self._thread = Packer(), ThreadPoolExecutor(1)
        self._waiting: deque[Future[None]] = deque()
        self._file = (folder / self._name).open("wb")
        self._file.write(MAGIC + _record(HEADER, _text("ros2") + _text("hybrid_dynamics")))
        self._described = b"".join(self._descriptions())
        self._file.write(self._described)

    def write(self, blocks: Sequence[Block]) -> None:
        """One chunk of messages. Raises what went wrong with this one or one before."""
        blocks = [block for block in blocks if len(block)]
        if not blocks:
            return
        self._waiting.append(self._thread.submit(self._put, blocks))
        while len(self._waiting) > _QUEUED:
            self._waiting.popleft().result()

    def close(self) -> None:
        """Write what waits, the index, and the metadata."""
        while self._waiting:
            self._waiting.popleft().result()
        self._thread.shutdown()
        self._file.write(_record(DATA_END, struct.pack("<I", 0)))
        start = self._file.tell()
        count = sum(self._counts.values())
        first, last = (self._first, self._last) if count else (0, 0)
        counts = b"".join(struct.pack("<HQ", channel, n) for channel, n in self._counts.items())
        schemas = len({topic.kind for topic in self._topics})
        told = struct.pack("<QHIIIIQQI", count, schemas, len(self._topics), 0, 0, len(self._chunks), first, last,
                           len(counts))  # fmt: skip
        self._file.write(
            self._described + b"".join(self._chunks) + _record(STATISTICS, told + counts)
        )
        self._file.write(_record(FOOTER, struct.pack("<QQI", start, 0, 0)) + MAGIC)
        self._file.close()
        text = yaml.safe_dump(self._metadata(count, first, last), sort_keys=False)
        (self._folder / BAG_METADATA).write_text(text, encoding="utf-8")

    def abort(self) -> None:
        """Let go of everything."""
        self._thread.shutdown(cancel_futures=True)
        self._file.close()

    # -- parts

    def _descriptions(self) -> Iterator[bytes]:
        numbers: dict[str, int] = {}
        for topic in self._topics:
            if topic.kind not in numbers:
                numbers[topic.kind] = len(numbers) + 1
                head = struct.pack("<H", numbers[topic.kind]) + _text(topic.kind)
                yield _record(SCHEMA, head + _text("ros2msg") + _text(_definition(topic)))
            extra = (
                _text("offered_qos_profiles")
                + _text(_profiles(topic.qos))
                + _text("topic_type_hash")
                + _text(_digest(topic))
            )
            head = struct.pack("<HH", self.channels[topic.name], numbers[topic.kind])
            tail = _text(topic.name) + _text("cdr") + struct.pack("<I", len(extra)) + extra
            yield _record(CHANNEL, head + tail)

    def _put(self, blocks: Sequence[Block]) -> None:
        """Make and write a chunk; the thread does this."""
        begun = time.perf_counter()
        chunk = self._packer.chunk(blocks)
        self._first, self._last = min(self._first, chunk.first), max(self._last, chunk.last)
        start, size = self._file.tell(), len(chunk.packed)
        body = struct.pack("<QQQI", chunk.first, chunk.last, chunk.size, chunk.checksum) + _text(
            "zstd"
        )
        self._file.write(
            struct.pack("<BQ", CHUNK, len(body) + 8 + size) + body + struct.pack("<Q", size)
        )
        self._file.write(chunk.packed)
        end, places = self._file.tell(), b""
        for channel, entries in chunk.indices.items():
            self._counts[channel] += len(entries)
            places += struct.pack("<HQ", channel, self._file.tell())
            raw = entries.tobytes()
            self._file.write(_record(INDEX, struct.pack("<HI", channel, len(raw)) + raw))
        told = (
            struct.pack("<QQQQI", chunk.first, chunk.last, start, end - start, len(places)) + places
        )
        told += (
            struct.pack("<Q", self._file.tell() - end)
            + _text("zstd")
            + struct.pack("<QQ", size, chunk.size)
        )
        self._chunks.append(_record(CHUNK_INDEX, told))
        self.beside += time.perf_counter() - begun

    def _metadata(self, count: int, first: int, last: int) -> dict[str, Any]:
        span = {
            "starting_time": {"nanoseconds_since_epoch": first},
            "duration": {"nanoseconds": last - first},
        }
        topics = [
            {
                "topic_metadata": {
                    "name": topic.name,
                    "type": topic.kind,
                    "serialization_format": "cdr",
                    "offered_qos_profiles": dump_qos_v9(list(topic.qos)),
                    "type_description_hash": _digest(topic),
                },
                "message_count": self._counts[self.channels[topic.name]],
            }
            for topic in self._topics
        ]
        told: dict[str, Any] = {
            "version": 9,
            "storage_identifier": "mcap",
            **{key: dict(value) for key, value in span.items()},
            "message_count": count,
            "topics_with_message_count": topics,
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [self._name],
            "files": [{"path": self._name, **span, "message_count": count}],
            "custom_data": self._notes or None,
            "ros_distro": "jazzy",
        }
        return {"rosbag2_bagfile_information": told}


_BAG_FILE: Final = re.compile(r"metadata\.yaml|.*\.(mcap|db3)(\.zstd|-shm|-wal)?")


@contextmanager
def new_bag(
    path: Path, topics: Sequence[Topic], notes: Mapping[str, str] | None = None
) -> Iterator[BagWriter]:
    """Write a bag; one that is there is replaced. After an error or an interruption `path` is as it was before.

    Raises:
        BagCallError: there is something else than a bag at `path`.
    """
    path = path.absolute()
    require_replaceable(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = Path(tempfile.mkdtemp(prefix=f".{path.name}.", dir=path.parent))
    try:
        writer = BagWriter(aside / path.name, topics, notes)
        try:
            yield writer
            writer.close()
        except BaseException:
            writer.abort()
            raise
        if path.exists():
            path.rename(aside / "replaced")
        try:
            (aside / path.name).rename(path)
        except BaseException:
            if (aside / "replaced").exists():
                (aside / "replaced").rename(path)
            raise
    finally:
        shutil.rmtree(aside, ignore_errors=True)


def require_replaceable(path: Path) -> None:
    """Refuse a path where there is something else than nothing, an empty folder or a bag.

    Raises:
        BagCallError: what there is.
    """
    if not path.exists():
        return
    if not path.is_dir():
        raise BagCallError(f"{path}: is a file; name a folder for the new bag")
    if path.resolve() == Path.cwd():
        raise BagCallError(f"{path}: is the folder you are in; name a new one for the bag")
    others = [
        file.name
        for file in path.iterdir()
        if not (file.is_file() and _BAG_FILE.fullmatch(file.name))
    ]
    if others:
        raise BagCallError(
            f"{path}: holds other things than a bag ({min(others)}, ...); name a new folder"
        )


def require_new(path: Path) -> None:
    """Refuse a path where there is anything but an empty folder.

    Raises:
        BagCallError: there is.
    """
    require_replaceable(path)
    if path.exists() and any(path.iterdir()):
        raise BagCallError(f"{path}: {THERE}")


def _definition(topic: Topic) -> str:
    if topic.definition or topic.kind not in typestore().types:
        return topic.definition
    return str(typestore().generate_msgdef(topic.kind, ros_version=2)[0])


@cache  # most topics of a bag have the same
def _profiles(qos: tuple[Qos, ...]) -> str:
    return yaml.safe_dump(dump_qos_v9(list(qos)), sort_keys=False).strip()


def _digest(topic: Topic) -> str:
    known = topic.digest or topic.kind not in typestore().types
    return topic.digest if known else str(typestore().hash_rihs01(topic.kind))


def _record(code: int, body: bytes) -> bytes:
    return struct.pack("<BQ", code, len(body)) + body


def _text(text: str) -> bytes:
    encoded = text.encode()
    return struct.pack("<I", len(encoded)) + encoded
