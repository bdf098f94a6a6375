"""Decompression of files, chunks and messages: Zstandard and LZ4."""

from __future__ import annotations

import sys
from typing import Final

import lz4.frame

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

__all__ = ["ZSTD_ERRORS", "ZSTD_MARK", "decompress_chunk", "zstd"]

ZSTD_MARK: Final = b"\x28\xb5\x2f\xfd"  # first bytes of every frame, but of no CDR message
ZSTD_ERRORS: Final = (zstd.ZstdError, EOFError)
_MAX_CHUNK_SIZE: Final = 1 << 32  # [bytes], uncompressed; a larger size is damaged


def decompress_chunk(method: str, data: bytes, size: int) -> bytes:
    """The records of a chunk.

    Args:
        method: `zstd`, `lz4`, or empty if the chunk is not compressed.
        data: the records in the file.
        size: uncompressed size of the records [bytes].

    Raises:
        ValueError: the method is unknown, or the size exceeds 4 GiB.
        RuntimeError, ZstdError, EOFError: the data are damaged.
    """
    if size > _MAX_CHUNK_SIZE:
        raise ValueError(f"{size} bytes")
    if method == "zstd":
        return bytes(zstd.decompress(data))
    if method == "lz4":
        return bytes(lz4.frame.decompress(data))
    if method:
        raise ValueError(f"compression '{method[:16]}' is not known")
    return data
