"""Files that are read without waiting for ever: pipes, devices and dead mounts are refused.

Opening a pipe waits for whoever writes into it, and a file system that is gone may never answer.
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
# Not opening for reading alone may wait; os.O_NONBLOCK is not everywhere.
_FLAGS: Final = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)


def special_kind(path: Path) -> str:
    """What a path is that is neither a file nor a folder, in words; "" for files and folders.

    Raises:
        OSError: it cannot be asked.
    """
    return _kind(path.stat().st_mode)


def open_regular(path: Path) -> BinaryIO:
    """Open a file for reading, if it is one.

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
        path: of the file.
        limit: bytes that are read at most.

    Raises:
        OSError: it cannot be read, is a pipe, a device or a socket, or gives no answer in time.
    """

    def read() -> bytes:
        with open_regular(path) as file:
            return file.read(limit)

    return answered_in_time(read)


def may_be_file(path: Path) -> bool:
    """Whether a path is a regular file; True where nobody answers, since reading it says so."""
    try:
        return answered_in_time(path.is_file)
    except TimeoutError:
        return True


def answered_in_time(ask: Callable[[], T], timeout: float = TIMEOUT) -> T:
    """What a question to the file system is answered with.

    Args:
        ask: asks it.
        timeout: how long that may take [s].

    Raises:
        TimeoutError: there is no answer; the thread that asks is left behind.
        Exception: what the question raises.
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
