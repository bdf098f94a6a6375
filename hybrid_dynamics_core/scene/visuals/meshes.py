"""Conversion of mesh files to triangles, with trimesh in another process."""

from __future__ import annotations

import contextlib
import json
import subprocess
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any, Final
from urllib.parse import unquote

import numpy as np

from ...description.model import Colour
from ...formats.mesh_files import MAX_BYTES, reason_against
from ...ground.arrays import Array
from ...ground.regular_files import read_regular
from ...ground.worker_limits import OUT_OF_TIME, environment
from .primitives import Faces

MAX_SUM: Final = 200_000_000  # [bytes] all meshes of a robot
MAX_TRIANGLES: Final = 2_000_000  # all triangles of a robot
MAX_SECONDS: Final = 20  # computing time for one mesh
_MAX_WAIT: Final = 60.0  # [s] timeout of the process
_MAX_BROKEN: Final = 3  # number of crashes after which no more meshes are read
_WORKER: Final = Path(__file__).with_name("worker.py")
_ENVIRONMENT: Final = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
_MAX_CACHED: Final = 500  # largest number of cached meshes
_DOCTYPE: Final = (b"<!DOCTYPE", b"<!ENTITY")
_ARCHIVES: Final = (
    b"PK\x03\x04",
    b"\x1f\x8b",
    b"BZh",
    b"\xfd7zXZ",
    b"7z\xbc\xaf",
    b"\x28\xb5\x2f\xfd",
)
_INSTALL: Final = "meshes need trimesh: pip install trimesh pycollada"


@dataclass(frozen=True, eq=False)
class MeshPart:
    """Part of a mesh, in the frame of its file.

    Attributes:
        vertices: (k, 3) [m].
        faces: (m, 3) indices of vertices.
        colour: colour; None if the file has none.
    """

    vertices: Array
    faces: Faces
    colour: Colour | None


class MeshError(Exception):
    """A mesh could not be read; the message is a clause."""


Result = tuple[MeshPart, ...] | MeshError
_Stamp = tuple[Path, int, int]  # a file, its modification time [ns], and its size [bytes]
_CACHE: dict[_Stamp, tuple[MeshPart, ...]] = {}


def read_meshes(files: Sequence[Path]) -> dict[Path, Result]:
    """By file: the parts of the mesh, or the reason why it was not read.

    Args:
        files: mesh files of one robot.
    """
    results: dict[Path, Result] = {}
    contents: dict[Path, _Content] = {}
    total = 0
    for file in dict.fromkeys(files):
        try:
            cached = _CACHE.get(_stamp(file))
            if cached is not None:
                results[file] = cached
                continue
            contents[file] = _content(file, MAX_SUM - total)
            total += contents[file].size
        except (MeshError, OSError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            results[file] = MeshError(reason)
    if contents and find_spec("trimesh") is None:
        return results | dict.fromkeys(contents, MeshError(_INSTALL))
    for file, result in _parsed(contents):
        results[file] = result
        if not isinstance(result, MeshError):
            _keep(file, result)
    return results


def _stamp(file: Path) -> _Stamp:
    status = file.stat()
    return file, status.st_mtime_ns, status.st_size


def _keep(file: Path, parts: tuple[MeshPart, ...]) -> None:
    if len(_CACHE) >= _MAX_CACHED:
        _CACHE.clear()
    with contextlib.suppress(OSError):
        _CACHE[_stamp(file)] = parts


# -- files


@dataclass(frozen=True)
class _Content:
    """Content of a mesh file, and of the files that a glTF refers to."""

    kind: str
    data: bytes
    files: Mapping[str, bytes]

    @property
    def size(self) -> int:
        return len(self.data) + sum(map(len, self.files.values()))


def _content(file: Path, most: int) -> _Content:
    """The content of a file.

    Args:
        file: path of the mesh.
        most: largest number of bytes.

    Raises:
        MeshError: the file is too large, is an archive, or refers to files outside its folder.
        OSError: the file cannot be read.
    """
    reason = reason_against(file)
    if reason:
        raise MeshError(reason)
    data = _bounded(file)
    if data.startswith(_ARCHIVES):
        raise MeshError("an archive, which is not opened")
    kind = file.suffix.lower().removeprefix(".")
    if kind == "dae" and any(word in data for word in _DOCTYPE):
        raise MeshError("a document type, which could define entities")
    files = _named_in(file, data) if kind == "gltf" else {}
    content = _Content(kind, data, files)
    if content.size > most:
        raise MeshError(f"the meshes have more than {MAX_SUM} bytes")
    return content


def _bounded(file: Path) -> bytes:
    data = read_regular(file, MAX_BYTES + 1)
    if len(data) > MAX_BYTES:
        raise MeshError(f"more than {MAX_BYTES} bytes")
    return data


def _named_in(file: Path, data: bytes) -> dict[str, bytes]:
    """The buffers of a glTF from files below its folder."""
    try:
        buffers = json.loads(data).get("buffers", [])
        uris = [buffer.get("uri", "") for buffer in buffers]
    except (ValueError, AttributeError, TypeError, RecursionError) as error:
        raise MeshError("no glTF") from error
    files: dict[str, bytes] = {}
    folder = file.parent.resolve()
    for uri in uris:
        if not isinstance(uri, str) or not uri or uri.startswith("data:"):
            continue
        place = (folder / unquote(uri)).resolve()
        if "://" in uri or not place.is_relative_to(folder):
            raise MeshError(f"its buffer '{uri}' is not below its folder")
        files[uri] = _bounded(place)
    return files


# -- the process


def _parsed(contents: Mapping[Path, _Content]) -> Iterator[tuple[Path, Result]]:
    """The results of the meshes; a crashed process is replaced."""
    remaining = list(contents)
    broken = 0
    triangles = MAX_TRIANGLES
    while remaining:
        if broken >= _MAX_BROKEN:
            yield from ((file, MeshError("others ended the process")) for file in remaining)
            return
        with _Process() as process:
            while remaining:
                file = remaining.pop(0)
                result = process.ask(contents[file], triangles)
                yield file, result
                if isinstance(result, _EndedError):
                    broken += 1
                    break
                if not isinstance(result, MeshError):
                    triangles -= sum(len(part.faces) for part in result)


class _EndedError(MeshError):
    """The process ended before it answered."""


class _Process:
    """Process that reads meshes."""

    def __enter__(self) -> _Process:
        command = [sys.executable, "-I", "-S", "-B", str(_WORKER)]
        self.process = subprocess.Popen(  # noqa: S603 - this Python, on a file of this package
            command,
            cwd="/",
            env=environment(_ENVIRONMENT),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        self.source = _pipe(self.process.stdout)
        self.send(json.dumps({"path": sys.path}).encode() + b"\n")
        return self

    def __exit__(self, *_: object) -> None:
        with contextlib.suppress(OSError):
            _pipe(self.process.stdin).close()
        self.process.kill()
        self.process.wait()
        self.source.close()

    def ask(self, content: _Content, triangles: int) -> Result:
        """The parts of a mesh, or the reason why it was not read."""
        request = {
            "kind": content.kind,
            "size": len(content.data),
            "files": {name: len(data) for name, data in content.files.items()},
            "seconds": MAX_SECONDS,
            "triangles": triangles,
            "most": MAX_TRIANGLES,
        }
        timer = threading.Timer(_MAX_WAIT, self.process.kill)
        timer.daemon = True
        timer.start()
        try:
            line = json.dumps(request).encode() + b"\n"
            self.send(line, content.data, *content.files.values())
            return self.answer()
        finally:
            timer.cancel()

    def answer(self) -> Result:
        """The answer of the process to a request."""
        line = self.source.readline()
        if not line.endswith(b"\n"):
            return self.ended()
        reply = json.loads(line)
        if "error" in reply:
            return MeshError(f"not read: {reply['error']}")
        parts: list[MeshPart] = []
        for part in reply["parts"]:
            vertices = self.array(part["vertices"], "<f8")
            faces = self.array(part["faces"], "<i8")
            if vertices is None or faces is None:
                return self.ended()
            reason = _reason_against(vertices, faces)
            if reason:
                return MeshError(reason)
            parts.append(MeshPart(vertices, faces.astype(np.int64), _colour(part["colour"])))
        if not parts:
            return MeshError("it has no triangles")
        return tuple(parts)

    def array(self, rows: int, kind: str) -> Any:
        """An array (rows, 3) of numbers of eight bytes; None if the process ended before."""
        size = rows * 3 * np.dtype(kind).itemsize
        data = self.source.read(size)
        if len(data) < size:
            return None
        return np.frombuffer(data, kind).reshape(rows, 3)

    def send(self, *parts: bytes) -> None:
        """Write to the process. If it has ended, reading the answer will fail."""
        pipe = _pipe(self.process.stdin)
        with contextlib.suppress(OSError):
            for part in parts:
                pipe.write(part)
            pipe.flush()

    def ended(self) -> _EndedError:
        """The error for a process that ended."""
        try:
            code = self.process.wait(timeout=5.0)
        except subprocess.TimeoutExpired:
            code = 0
        if code == OUT_OF_TIME:
            return _EndedError(f"takes more than {MAX_SECONDS} s of computing")
        return _EndedError(f"its process ended with {code}, out of memory or time")


def _reason_against(vertices: Array, faces: Faces) -> str:
    if not np.isfinite(vertices).all():
        return "it has numbers that are not finite"
    if faces.size and not 0 <= int(faces.min()) <= int(faces.max()) < len(vertices):
        return "it has triangles of vertices that are not there"
    return ""


def _colour(levels: list[int] | None) -> Colour | None:
    if levels is None:
        return None
    red, green, blue, opacity = (level / 255.0 for level in levels)
    return red, green, blue, opacity


def _pipe(pipe: IO[bytes] | None) -> IO[bytes]:
    """A pipe of the process, without None."""
    assert pipe is not None  # noqa: S101
    return pipe
