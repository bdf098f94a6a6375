"""Reading and writing rosbag2 recordings in MCAP files."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from rosbags.interfaces import (
    Connection,
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import CompressionFormat, CompressionMode, Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

_QOS_DEPTH = 50
_INFINITE = QosTime(9223372036, 854775807)  # as ROS writes "no deadline"


class RawMessage(NamedTuple):
    """A message as it is in a bag: log time [ns] and CDR bytes."""

    log_ns: int
    data: bytes


@cache
def typestore() -> Typestore:
    """The message types of ROS 2 Jazzy."""
    return get_typestore(Stores.ROS2_JAZZY)


def read_raw(bag: Path, topic: str) -> list[RawMessage]:
    """All messages of one topic, in the order of their log times.

    Raises:
        rosbags.rosbag2.ReaderError: there is no bag, or it cannot be read.
    """
    with Reader(bag) as reader:
        connections = [connection for connection in reader.connections if connection.topic == topic]
        if not connections:
            return []
        return [RawMessage(stamp, bytes(data)) for _, stamp, data in reader.messages(connections)]


def decode(data: bytes, kind: str) -> Any:
    """A message from its CDR bytes."""
    return typestore().deserialize_cdr(data, kind)


class BagWriter:
    """An open bag with a fixed set of topics."""

    def __init__(self, writer: Writer, topics: Mapping[str, str]) -> None:
        """An open writer, and the message type of each topic."""
        self._writer = writer
        self._connections: dict[str, Connection] = {
            topic: writer.add_connection(
                topic, kind, typestore=typestore(), offered_qos_profiles=[_reliable()]
            )
            for topic, kind in topics.items()
        }

    def write(self, topic: str, log_ns: int, data: bytes) -> None:
        """Append one message: its log time [ns] and its CDR bytes."""
        self._writer.write(self._connections[topic], log_ns, data)


@contextmanager
def new_bag(
    path: Path, topics: Mapping[str, str], notes: Mapping[str, str] | None = None
) -> Iterator[BagWriter]:
    """Write a bag of compressed MCAP. It appears at ``path``, in place of one there, when all of it is written.

    After an error or an interruption ``path`` is as it was before.

    Args:
        path: folder of the bag.
        topics: message type of each topic.
        notes: what the metadata says about the recording.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = Path(tempfile.mkdtemp(prefix=f".{path.name}.", dir=path.parent))
    try:
        # Of the final name already: the bag's file is named after its folder.
        writer = Writer(aside / path.name, version=9, storage_plugin=StoragePlugin.MCAP)
        writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        for key, value in (notes or {}).items():
            writer.set_custom_data(key, value)
        with writer:
            yield BagWriter(writer, topics)
        if path.exists():
            path.rename(aside / "replaced")
        (aside / path.name).rename(path)
    finally:
        shutil.rmtree(aside, ignore_errors=True)


def _reliable() -> Qos:
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=_QOS_DEPTH,
        reliability=QosReliability.RELIABLE,
        durability=QosDurability.VOLATILE,
        deadline=_INFINITE,
        lifespan=_INFINITE,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=_INFINITE,
        avoid_ros_namespace_conventions=False,
    )
