"""Writing of files that are whole whenever they are there."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def atomic_file(path: Path, *, is_durable: bool = False) -> Iterator[Path]:
    """Write a new file that replaces another one at the end of the block.

    If the block raises, nothing is left of the new file, and the other one stays as it was. Any
    number of threads, processes and machines may replace the same file at once.

    Args:
        path: the file that is written or replaced.
        is_durable: whether a loss of power leaves either file whole; this waits for the disk.

    Yields:
        Path of the new file, with the same suffix.

    Raises:
        OSError: the file cannot be written.
    """
    new = path.with_name(f".{secrets.token_hex(8)}.{path.name}")
    try:
        yield new
        if is_durable:
            _wait_for_disk(new)
        new.replace(path)
    finally:
        new.unlink(missing_ok=True)


def _wait_for_disk(path: Path) -> None:
    with path.open("r+b") as file:
        os.fsync(file.fileno())
