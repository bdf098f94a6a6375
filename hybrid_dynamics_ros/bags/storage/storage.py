"""Data of bags, independent of their storage: topics, messages and losses."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from rosbags.interfaces import Qos

from ...messages.cdr import Bytes
from ...messages.interfaces import typestore
from .compression import ZSTD_ERRORS, ZSTD_MARK, zstd

MAX_LOSSES: Final = 1000  # sentences
CDR: Final = "cdr"  # the encoding of ROS 2
ROS2_MSG: Final = "ros2msg"  # the language of .msg files
_MAX_LOSS_KINDS: Final = 20  # kinds of losses that are only counted
_OTHER_KINDS: Final = "of other kinds"
_NUMBER: Final = re.compile(r"(?<![\w/.-])\d+(?![\w/])")  # numbers outside of names


@dataclass(frozen=True)
class Topic:
    """A topic of a bag.

    Attributes:
        name: its name.
        kind: its message type.
        qos: the profiles that its publishers offered.
        definition: the text of its message definition.
        language: language of the definition in MCAP's terms; empty if there is none.
        encoding: encoding of its messages; only `cdr` can be read.
        digest: RIHS hash of its message type.
        message_count: number of messages in the metadata; None if unknown.
    """

    name: str
    kind: str
    qos: tuple[Qos, ...] = ()
    definition: str = ""
    language: str = ""
    encoding: str = CDR
    digest: str = ""
    message_count: int | None = None

    def with_type_description(self) -> Topic:
        """The topic with definition and hash of its type, if the type is known."""
        store = typestore()
        if self.kind not in store.types:
            return self
        definition, language = self.definition, self.language
        if not definition:
            definition, _ = store.generate_msgdef(self.kind, ros_version=2)
            language = ROS2_MSG
        digest = str(self.digest or store.hash_rihs01(self.kind))
        return replace(self, definition=definition, language=language, digest=digest)


class RawMessage(NamedTuple):
    """One message: log time [ns] and CDR bytes."""

    log_ns: int
    data: bytes


@dataclass(frozen=True, eq=False)
class Messages:
    """Messages of one topic.

    Attributes:
        log_ns: log times (N,) [ns].
        data: bytes that contain the messages.
        offsets: offset of each message in `data` (N,).
        lengths: size of each message [bytes] (N,).
    """

    log_ns: NDArray[np.int64]
    data: Bytes
    offsets: NDArray[np.int64]
    lengths: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.log_ns)

    def sizes(self) -> list[int]:
        """The distinct lengths, in ascending order."""
        lengths = self.lengths
        if len(lengths) and (lengths == lengths[0]).all():
            return [int(lengths[0])]
        return [int(size) for size in np.unique(lengths)]

    def message(self, row: int) -> bytes:
        """The bytes of one message."""
        start = int(self.offsets[row])
        return self.data[start : start + int(self.lengths[row])].tobytes()

    def raw(self) -> Iterator[RawMessage]:
        """The messages one by one."""
        for row, log_ns in enumerate(self.log_ns.tolist()):
            yield RawMessage(log_ns, self.message(row))

    def block(self, rows: NDArray[np.intp], size: int) -> Bytes:
        """Messages of one size (k, size); a view if they are equally spaced."""
        offsets = self.offsets[rows]
        step = size
        if len(rows) > 1:
            step = int(offsets[1] - offsets[0])
        if step > 0 and (np.diff(offsets) == step).all():
            start = self.data[int(offsets[0]) :]
            shape = (len(rows), size)
            return np.lib.stride_tricks.as_strided(start, shape, (step, 1), writeable=False)
        gathered: Bytes = self.data[offsets[:, None] + np.arange(size)]
        return gathered

    def part(self, rows: NDArray[Any]) -> Messages:
        """Some of the messages, in the order of `rows`."""
        return Messages(self.log_ns[rows], self.data, self.offsets[rows], self.lengths[rows])

    @staticmethod
    def of(log_ns: list[int], messages: list[bytes]) -> Messages:
        """Make messages from log times [ns] and the bytes of each."""
        lengths = np.array([len(message) for message in messages], dtype=np.int64)
        data = np.frombuffer(b"".join(messages), dtype=np.uint8)
        offsets = np.cumsum(lengths) - lengths
        return Messages(np.array(log_ns, dtype=np.int64), data, offsets, lengths)


@dataclass(eq=False)
class Losses:
    """Texts on parts that could not be read.

    After a thousand sentences, further losses are only counted by kind.
    """

    _texts: dict[str, None] = field(default_factory=dict)
    _counts: Counter[str] = field(default_factory=Counter)

    def add(self, text: str) -> None:
        """Add a sentence, without duplicates."""
        if text in self._texts:
            return
        if len(self._texts) < MAX_LOSSES:
            self._texts[text] = None
        else:
            self._counts[self._kind_of(text)] += 1

    def describe(self) -> list[str]:
        """The sentences, then numbers of further losses by kind."""
        counts = [f"... and {count} more: {kind}" for kind, count in self._counts.items()]
        return [*self._texts, *counts]

    def _kind_of(self, text: str) -> str:
        kind = _NUMBER.sub("N", text)
        if kind in self._counts or len(self._counts) < _MAX_LOSS_KINDS:
            return kind
        return _OTHER_KINDS


def unpack_messages(messages: Messages, losses: Losses, topic: str, *, is_packed: bool) -> Messages:
    """Decompress messages that were compressed one by one; damaged ones become losses.

    Args:
        messages: messages of one topic.
        losses: receives texts on damaged messages.
        topic: name of the topic.
        is_packed: whether all are compressed; otherwise those that begin like zstd frames are.
    """
    is_marked = _begin_with(messages, ZSTD_MARK) | is_packed
    if not is_marked.any():
        return messages
    times: list[int] = []
    contents: list[bytes] = []
    for (log_ns, data), is_compressed in zip(messages.raw(), is_marked, strict=True):
        content = data
        if is_compressed:
            try:
                content = zstd.decompress(data)
            except (*ZSTD_ERRORS, MemoryError) as error:
                losses.add(
                    f"{topic}: the message logged at {log_ns} ns cannot be unpacked ({error})"
                )
                continue
        times.append(log_ns)
        contents.append(content)
    return Messages.of(times, contents)


def _begin_with(messages: Messages, mark: bytes) -> NDArray[np.bool_]:
    """Mask (N,) of messages that begin with given bytes."""
    result = messages.lengths >= len(mark)
    for k, byte in enumerate(mark):
        result[result] &= messages.data[messages.offsets[result] + k] == byte
    return result
