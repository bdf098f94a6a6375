"""Generated code kept on disk between runs.

An entry is a file named by its key, a digest of everything the code was made from. It holds the key
and a checksum again, so an entry that was cut off, damaged or renamed is not used but made anew.
Entries are written aside and renamed into place: any number of processes may start at once. The
folder must belong to the user, and to nobody else.

`HYBRID_DYNAMICS_CACHE` names another folder, or is `off`.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import platform
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

VARIABLE = "HYBRID_DYNAMICS_CACHE"
MAX_ENTRIES = 2000  # of some 20 kB; the oldest are taken out when there are more
_MAGIC = b"hybrid_dynamics kernel 1\n"
_SUFFIX = ".kernel"


@dataclass(frozen=True)
class Artifact:
    """Generated code and what is to be known of it: `facts` are plain data (JSON)."""

    facts: dict[str, Any]
    code: bytes


def folder() -> Path | None:
    """Where entries are kept; None where caching is off or the place is not the user's own."""
    told = os.environ.get(VARIABLE)
    if told is not None and told.strip().lower() in ("", "0", "off", "no", "none"):
        return None
    place = Path(told) if told is not None else _user_folder() / "hybrid_dynamics"
    try:
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
        status = place.stat()
    except OSError:
        return None
    if hasattr(os, "getuid") and (status.st_uid != os.getuid() or status.st_mode & 0o022):
        return None
    return place


def _user_folder() -> Path:
    home = Path.home
    if platform.system() == "Windows":
        return Path(os.environ.get("LOCALAPPDATA") or home() / "AppData" / "Local")
    if platform.system() == "Darwin":
        return home() / "Library" / "Caches"
    told = os.environ.get("XDG_CACHE_HOME", "")
    return Path(told) if Path(told).is_absolute() else home() / ".cache"


def read(key: str) -> Artifact | None:
    """The entry of a key, or None where there is none that is whole."""
    place = folder()
    if place is None:
        return None
    try:
        data = (place / (key + _SUFFIX)).read_bytes()
    except OSError:
        return None
    return _unpacked(key, data)


def write(key: str, artifact: Artifact) -> None:
    """Keep an entry; where that is not possible it is made again another time."""
    place = folder()
    if place is None:
        return
    with contextlib.suppress(OSError):
        handle, name = tempfile.mkstemp(prefix=key[:16], suffix=".new", dir=place)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(_packed(key, artifact))
            Path(name).replace(place / (key + _SUFFIX))
        except OSError:
            Path(name).unlink(missing_ok=True)
            raise
        _prune(place)


def _packed(key: str, artifact: Artifact) -> bytes:
    facts = json.dumps({"key": key, "facts": artifact.facts}).encode()
    body = len(facts).to_bytes(8, "little") + facts + artifact.code
    return _MAGIC + hashlib.sha256(body).digest() + body


def _unpacked(key: str, data: bytes) -> Artifact | None:
    start = len(_MAGIC) + 32
    body = data[start:]
    if data[: len(_MAGIC)] != _MAGIC or data[len(_MAGIC) : start] != hashlib.sha256(body).digest():
        return None
    end = 8 + int.from_bytes(body[:8], "little")
    told = json.loads(body[8:end])
    return Artifact(told["facts"], body[end:]) if told["key"] == key else None


def _prune(place: Path) -> None:
    entries = sorted(place.glob("*" + _SUFFIX), key=lambda path: path.stat().st_mtime)
    for path in entries[:-MAX_ENTRIES]:
        path.unlink(missing_ok=True)
