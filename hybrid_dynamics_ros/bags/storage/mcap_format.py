"""Format of records of MCAP files: codes, headers and texts.

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

RECORD_HEAD: Final = struct.Struct("<BQ")  # code, size of the body
MESSAGE_HEAD: Final = struct.Struct("<HIQQ")  # channel, sequence number, log time, publish time
PREFIX: Final = RECORD_HEAD.size + MESSAGE_HEAD.size  # offset of the data in a message record
CHANNEL_OFFSET: Final = RECORD_HEAD.size  # offset of the channel in a message record
LOG_TIME_OFFSET: Final = RECORD_HEAD.size + 6  # offset of the log time in a message record


def pack_record(code: int, body: bytes) -> bytes:
    """A record from its code and body."""
    return RECORD_HEAD.pack(code, len(body)) + body


def pack_text(text: str) -> bytes:
    """A text with its length in bytes in front."""
    encoded = text.encode()
    return struct.pack("<I", len(encoded)) + encoded


def unpack_text(record: bytes, start: int) -> tuple[str, int]:
    """The text at an offset of a record, and its end.

    Raises:
        IndexError, UnicodeDecodeError, struct.error: there is no valid text.
    """
    (size,) = struct.unpack_from("<I", record, start)
    end = start + 4 + size
    text = record[start + 4 : end]
    if len(text) != size:
        raise IndexError("a text without its end")
    return text.decode(), end


def unpack_pairs(record: bytes, start: int) -> dict[str, str]:
    """The map from text to text at an offset of a record; raises as `unpack_text`."""
    (size,) = struct.unpack_from("<I", record, start)
    end = start + 4 + size
    place = start + 4
    pairs: dict[str, str] = {}
    while place < end:
        key, place = unpack_text(record, place)
        pairs[key], place = unpack_text(record, place)
    return pairs
