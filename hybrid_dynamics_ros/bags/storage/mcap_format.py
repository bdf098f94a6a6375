"""Records of MCAP files: their codes, their heads, and the texts inside them.

The specification: https://mcap.dev/spec.
"""

from __future__ import annotations

import struct
from typing import Final

MAGIC: Final = b"\x89MCAP0\r\n"

HEADER: Final = 1
FOOTER: Final = 2
SCHEMA: Final = 3
CHANNEL: Final = 4
MESSAGE: Final = 5
CHUNK: Final = 6
MESSAGE_INDEX: Final = 7
CHUNK_INDEX: Final = 8
STATISTICS: Final = 0x0B
DATA_END: Final = 0x0F
LAST_CODE: Final = 0x0F

RECORD_HEAD: Final = struct.Struct("<BQ")  # code, bytes of the body
MESSAGE_HEAD: Final = struct.Struct("<HIQQ")  # channel, number, log time, time of publishing
PREFIX: Final = RECORD_HEAD.size + MESSAGE_HEAD.size  # bytes of a message record before its data
CHANNEL_OFFSET: Final = RECORD_HEAD.size  # where a message record has its channel
LOG_TIME_OFFSET: Final = RECORD_HEAD.size + 6  # where it has its log time


def pack_record(code: int, body: bytes) -> bytes:
    """A record: its head and its body."""
    return RECORD_HEAD.pack(code, len(body)) + body


def pack_text(text: str) -> bytes:
    """A text behind its length in bytes."""
    encoded = text.encode()
    return struct.pack("<I", len(encoded)) + encoded


def unpack_text(record: bytes, start: int) -> tuple[str, int]:
    """The text at a place of a record, and where it ends.

    Raises:
        IndexError, UnicodeDecodeError, struct.error: there is no text.
    """
    (size,) = struct.unpack_from("<I", record, start)
    end = start + 4 + size
    text = record[start + 4 : end]
    if len(text) != size:
        raise IndexError("a text without its end")
    return text.decode(), end


def unpack_pairs(record: bytes, start: int) -> dict[str, str]:
    """The map from text to text at a place of a record. Raises as `unpack_text`."""
    (size,) = struct.unpack_from("<I", record, start)
    end = start + 4 + size
    place = start + 4
    pairs: dict[str, str] = {}
    while place < end:
        key, place = unpack_text(record, place)
        pairs[key], place = unpack_text(record, place)
    return pairs
