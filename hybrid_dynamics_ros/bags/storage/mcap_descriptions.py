"""Schemas and channels of an MCAP file, which usually has several copies of each."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from .mcap_format import SCHEMA, unpack_pairs, unpack_text
from .qos import read_profiles
from .storage import Topic


@dataclass(frozen=True)
class _Schema:
    """A message type, and its definition in some language."""

    kind: str
    language: str
    definition: str

    def __str__(self) -> str:
        return f"the definition of {self.kind}"


@dataclass(frozen=True)
class _Channel:
    """A topic with the type of a schema."""

    schema: int
    topic: Topic

    def __str__(self) -> str:
        return f"channel {self.topic.name}"


T = TypeVar("T", _Schema, _Channel)


@dataclass(frozen=True)
class _Copy(Generic[T]):
    """A description, its record, and whether a checksum verified it."""

    content: T
    record: bytes
    is_verified: bool


class Descriptions:
    """All schemas and channels; copies are compared to detect damage."""

    def __init__(self, lose: Callable[[str], None]) -> None:
        """Start without descriptions.

        Args:
            lose: receives sentences on losses.
        """
        self._lose = lose
        self._schemas: dict[int, _Copy[_Schema]] = {}
        self._channels: dict[int, _Copy[_Channel]] = {}
        self._is_frozen = False

    @property
    def has_channels(self) -> bool:
        """Whether there is any channel."""
        return bool(self._channels)

    def add(self, code: int, record: bytes, *, is_verified: bool) -> None:
        """Add a schema or channel; of two that differ, the verified one is used.

        Raises:
            IndexError, UnicodeDecodeError, struct.error: the record is damaged.
        """
        (number,) = struct.unpack_from("<H", record)
        if code == SCHEMA:
            self._take(self._schemas, number, record, _schema_of, is_verified=is_verified)
        else:
            self._take(self._channels, number, record, _channel_of, is_verified=is_verified)

    def topics(self) -> dict[int, Topic]:
        """Topics by channel number; they are final afterwards."""
        self._is_frozen = True
        return {number: self._topic(copy.content) for number, copy in self._channels.items()}

    def _take(
        self,
        copies: dict[int, _Copy[T]],
        number: int,
        record: bytes,
        read: Callable[[bytes], T],
        *,
        is_verified: bool,
    ) -> None:
        earlier = copies.get(number)
        if earlier is None:
            copies[number] = _Copy(read(record), record, is_verified)
            return
        is_better = is_verified and not earlier.is_verified
        if earlier.record == record:  # the usual case
            if is_better:
                copies[number] = replace(earlier, is_verified=True)
            return
        if earlier.is_verified and not is_verified:
            return
        content = read(record)
        if is_better and not self._is_frozen:
            copies[number] = _Copy(content, record, is_verified)
        elif content != earlier.content:
            self._lose(f"{earlier.content} is {content} in another place: one is damaged")

    def _topic(self, channel: _Channel) -> Topic:
        schema = self._schemas.get(channel.schema)
        if schema is None:
            return channel.topic
        described = schema.content
        return replace(
            channel.topic,
            kind=described.kind,
            definition=described.definition,
            language=described.language,
        )


def _schema_of(record: bytes) -> _Schema:
    kind, place = unpack_text(record, 2)
    language, place = unpack_text(record, place)
    definition, _ = unpack_text(record, place)
    return _Schema(kind, language, definition)


def _channel_of(record: bytes) -> _Channel:
    _, schema = struct.unpack_from("<HH", record)
    name, place = unpack_text(record, 4)
    encoding, place = unpack_text(record, place)
    notes = unpack_pairs(record, place)
    profiles = read_profiles(notes.get("offered_qos_profiles"))
    digest = notes.get("topic_type_hash", "")
    return _Channel(schema, Topic(name, "", profiles, digest=digest, encoding=encoding))
