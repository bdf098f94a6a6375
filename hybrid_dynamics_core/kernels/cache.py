"""A cache on disk: facts (plain data, JSON) and code (bytes) by key.

An entry is a file named by its key, a digest of all that the entry was made from. It contains the
key and a checksum. A truncated, damaged or renamed entry counts as missing. So entries need not be
durable. Any number of processes may start at once. Only the user may have access to the folder.

`HYBRID_DYNAMICS_CACHE` names another folder, or is `off`.
"""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import json
import os
import platform
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..ground.atomic_files import atomic_file
from ..ground.regular_files import open_regular

VARIABLE = "HYBRID_DYNAMICS_CACHE"
MAX_ENTRIES = 10_000  # of some 20 kB each; beyond some more the oldest tenth is removed
_OFF = ("", "0", "off", "no", "none")
_MAGIC = b"hybrid_dynamics kernel 2\n"
_CHECKSUM = 32  # [bytes] of a SHA-256
_LENGTH = 8  # [bytes] of the length of the facts
_SUFFIX = ".kernel"

_writes = itertools.count()  # entries that this process has written


@dataclass(frozen=True)
class Entry:
    """The content of an entry.

    Attributes:
        facts: plain data (JSON).
        code: bytes that a backend can load.
    """

    facts: dict[str, Any] = field(default_factory=dict)
    code: bytes = b""


def folder() -> Path | None:
    """The folder of the entries; None if caching is off, or others can write to it."""
    setting = os.environ.get(VARIABLE)
    if setting is None:
        place = user_folder() / "hybrid_dynamics"
    elif setting.strip().lower() in _OFF:
        return None
    else:
        place = Path(setting)
    try:
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
        status = place.stat()
    except OSError:
        return None
    return place if _is_private(status) else None


@contextlib.contextmanager
def at_least_meanwhile() -> Iterator[None]:
    """Without a cache folder, use a temporary one for a while, so that processes share code."""
    if folder() is not None:
        yield
        return
    setting = os.environ.get(VARIABLE)
    with tempfile.TemporaryDirectory(prefix="hybrid_dynamics_") as place:
        os.environ[VARIABLE] = place
        try:
            yield
        finally:
            os.environ.pop(VARIABLE)
            if setting is not None:
                os.environ[VARIABLE] = setting


def _is_private(status: os.stat_result) -> bool:
    if not hasattr(os, "getuid"):
        return True
    return status.st_uid == os.getuid() and not status.st_mode & 0o022


def user_folder() -> Path:
    """The user's cache folder, such as ~/.cache."""
    home = Path.home
    system = platform.system()
    if system == "Windows":
        return Path(os.environ.get("LOCALAPPDATA") or home() / "AppData" / "Local")
    if system == "Darwin":
        return home() / "Library" / "Caches"
    setting = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return setting if setting.is_absolute() else home() / ".cache"


def read(key: str) -> Entry | None:
    """The entry of a key; None if there is no valid one."""
    place = folder()
    if place is None:
        return None
    path = place / (key + _SUFFIX)
    try:
        with open_regular(path) as file:
            data = file.read()
    except OSError:
        return None
    with contextlib.suppress(OSError):
        os.utime(path)  # marks the last use
    return _unpack(key, data)


def write(key: str, entry: Entry) -> None:
    """Store an entry; failures are ignored, since it can be built again."""
    place = folder()
    if place is None:
        return
    with contextlib.suppress(OSError):
        with atomic_file(place / (key + _SUFFIX)) as new:
            new.write_bytes(_pack(key, entry))
        # Listing thousands of files takes longer than writing one.
        if next(_writes) % max(1, MAX_ENTRIES // 100) == 0:
            _prune(place)


def _pack(key: str, entry: Entry) -> bytes:
    facts = json.dumps({"key": key, "facts": entry.facts}).encode()
    body = len(facts).to_bytes(_LENGTH, "little") + facts + entry.code
    return _MAGIC + hashlib.sha256(body).digest() + body


def _unpack(key: str, data: bytes) -> Entry | None:
    start = len(_MAGIC) + _CHECKSUM
    magic, checksum, body = data[: len(_MAGIC)], data[len(_MAGIC) : start], data[start:]
    if magic != _MAGIC or checksum != hashlib.sha256(body).digest():
        return None
    end = _LENGTH + int.from_bytes(body[:_LENGTH], "little")
    head = json.loads(body[_LENGTH:end])
    return Entry(head["facts"], body[end:]) if head["key"] == key else None


def _prune(place: Path) -> None:
    with os.scandir(place) as files:  # much faster than a glob
        names = [file.name for file in files]
    if len(names) <= MAX_ENTRIES:
        return
    paths = [place / name for name in names if name.endswith(_SUFFIX)]
    paths.sort(key=_last_use)
    for path in paths[: len(paths) - MAX_ENTRIES * 9 // 10]:
        path.unlink(missing_ok=True)


def _last_use(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except FileNotFoundError:  # another process removed it
        return 0.0
