"""The binary of a unit, made by the compiler of the machine where there is one."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from .description import FMI2

COMPILERS = ("gcc", "cc", "clang")
PATIENCE = 300  # [s] longest run of the compiler
FLAGS = ("-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden")
_MACHINES = {"amd64": "x86_64", "x86_64": "x86_64", "arm64": "aarch64", "aarch64": "aarch64"}
_SYSTEMS = {"linux": ("linux", ".so"), "darwin": ("darwin", ".dylib"), "win32": ("windows", ".dll")}
_FOLDERS_OF_2 = {
    "x86_64-linux": "linux64",
    "x86_64-darwin": "darwin64",
    "aarch64-darwin": "darwin64",
    "x86_64-windows": "win64",
}


@dataclass(frozen=True)
class Binary:
    """A shared library in a unit, or why there is none.

    Attributes:
        path: place in the unit; empty if there is none.
        content: the library.
        reason: why there is none.
    """

    path: str = ""
    content: bytes = b""
    reason: str = ""


def compiled(
    texts: Mapping[str, str], sources: Sequence[str], identifier: str, version: str
) -> Binary:
    """The library of C files.

    Args:
        texts: text of each file by its name.
        sources: names of files to compile.
        identifier: of the model; the name of the library.
        version: of FMI.
    """
    place = _place(version)
    compiler = _compiler()
    if not place:
        return Binary(reason=f"FMI {version} has no name for this machine")
    if compiler is None:
        return Binary(reason=f"there is no C compiler here ({', '.join(COMPILERS)})")
    suffix = _SYSTEMS[sys.platform][1]
    library = f"{identifier}{suffix}"
    with tempfile.TemporaryDirectory(prefix="hybrid_dynamics_") as folder:
        for name, text in texts.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        words = [compiler, *FLAGS, *sources, "-o", library, "-lm"]
        reason = _run(words, folder)
        if reason:
            return Binary(reason=reason)
        content = (Path(folder) / library).read_bytes()
    return Binary(f"binaries/{place}/{library}", content)


def _place(version: str) -> str:
    """Folder of binaries for this machine; empty if the version of FMI has none."""
    machine = _MACHINES.get(platform.machine().lower(), "")
    system = _SYSTEMS.get(sys.platform, ("", ""))[0]
    if not machine or not system:
        return ""
    name = f"{machine}-{system}"
    if version == FMI2:
        return _FOLDERS_OF_2.get(name, "")
    return name


def _compiler() -> str | None:
    for name in COMPILERS:
        place = shutil.which(name)
        if place is not None:
            return place
    return None


def _run(words: Sequence[str], folder: str) -> str:
    """Run the compiler; what went wrong, or nothing."""
    environment = {**os.environ, "LC_ALL": "C"}
    try:
        done = subprocess.run(  # noqa: S603 - the compiler of the machine, on our own text
            words,
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"{words[0]} did not run: {error}"
    if done.returncode == 0:
        return ""
    lines = done.stderr.strip().splitlines()
    return f"{words[0]} failed: {lines[0] if lines else done.returncode}"
