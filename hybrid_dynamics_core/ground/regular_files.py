"""Reading of regular files without blocking: pipes, devices and dead mounts are refused.

Opening a pipe waits for a writer, and a file system that is gone may never answer.
"""

from __future__ import annotations

import errno
import os
import stat
import threading
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO, Final, TypeVar, cast

T = TypeVar("T")
TIMEOUT: Final = 10.0  # [s] for a file system to answer
_KINDS: Final = (
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISSOCK, "a socket"),
)
# O_NONBLOCK keeps `open` itself from waiting; not every system has it.
_FLAGS: Final = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)


def special_kind(path: Path) -> str:
    """Text for a path that is a pipe, device or socket; "" for files and folders.

    Raises:
        OSError: the path cannot be examined.
    """
    return _kind(path.stat().st_mode)


def open_regular(path: Path) -> BinaryIO:
    """Open a regular file for reading.

    Raises:
        OSError: it cannot be opened, or is a pipe, a device or a socket.
    """
    _require_regular(path, path.stat().st_mode)  # opening a device may already do something
    file = os.fdopen(os.open(path, _FLAGS), "rb")
    try:
        _require_regular(path, os.fstat(file.fileno()).st_mode)
    except OSError:
        file.close()
        raise
    return cast(BinaryIO, file)


def read_regular(path: Path, limit: int) -> bytes:
    """The first bytes of a file.

    Args:
        path: path of the file.
        limit: largest number of bytes to read.

    Raises:
        OSError: it cannot be read, is a pipe, a device or a socket, or gives no answer in time.
    """

    def read() -> bytes:
        with open_regular(path) as file:
            return file.read(limit)

    return answered_in_time(read)


def may_be_file(path: Path) -> bool:
    """Whether a path is a regular file; True if there is no answer, since reading will fail."""
    try:
        return answered_in_time(path.is_file)
    except TimeoutError:
        return True


def answered_in_time(ask: Callable[[], T], timeout: float = TIMEOUT) -> T:
    """The result of a call to the file system, within a timeout.

    Args:
        ask: the call.
        timeout: longest time of the call [s].

    Raises:
        TimeoutError: there is no result; the thread of the call keeps running.
        Exception: the error of the call.
    """
    answers: list[T] = []
    errors: list[Exception] = []

    def run() -> None:
        try:
            answers.append(ask())
        except Exception as error:  # noqa: BLE001 - it is raised where the answer is waited for
            errors.append(error)

    thread = threading.Thread(target=run, name="file system", daemon=True)
    thread.start()
    thread.join(timeout)
    if errors:
        raise errors[0]
    if not answers:
        text = f"no answer within {timeout:g} s; is its file system still there?"
        raise TimeoutError(errno.ETIMEDOUT, text)
    return answers[0]


def _kind(mode: int) -> str:
    for is_kind, words in _KINDS:
        if is_kind(mode):
            return words
    return ""


def _require_regular(path: Path, mode: int) -> None:
    words = _kind(mode)
    if words:
        raise OSError(errno.EINVAL, f"it is {words}; expected a regular file", str(path))
