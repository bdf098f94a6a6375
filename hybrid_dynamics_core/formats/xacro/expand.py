"""Expansion of a xacro file to elements with their original file and line."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any

from ...description.files import read_text
from ...errors import DescriptionError, InputError
from ...ground.file_options import FileOptions
from ...ground.suggestions import suggestion
from ...ground.wording import one_line
from ...ground.worker_limits import OUT_OF_TIME, environment
from ..packages import PackageError, Packages
from ..xml.located_xml import MAX_DEPTH, MAX_ELEMENTS, LocatedElement

SUFFIX = ".xacro"
_WORKER = Path(__file__).with_name("worker.py")
_MAX_FILES = 500  # included by one file
_MAX_TEXT = 20_000_000  # [characters] of all included files, and of the result
_MAX_COMPUTING = 4  # [s] limit of processor time
_MAX_SECONDS = 60.0  # [s] timeout of the process


_INSTALLED = "; where a package has it only once it is built and installed, set AMENT_PREFIX_PATH"


@dataclass(frozen=True)
class Expansion:
    """The result of an expansion.

    Attributes:
        root: root element; every element has its file and line.
        notes: warnings of xacro.
        files: files that were read.
    """

    root: LocatedElement
    notes: list[str]
    files: list[Path]


def is_xacro_name(path: Path) -> bool:
    """Whether a file's name ends in .xacro; only then its expressions are evaluated."""
    return path.suffix == SUFFIX


def expand_xacro(path: Path, options: FileOptions) -> Expansion:
    """Expand a .xacro file.

    Args:
        path: path of the file.
        options: arguments, and the search path of packages.

    Raises:
        InputError: the file has no argument of a name in the options.
        DescriptionError: the file cannot be expanded, or an expression is not allowed.
    """
    if find_spec("xacro") is None:
        raise DescriptionError("xacro files need xacro: pip install xacro", file=path)
    return _Expander(path, options).expand()


class _Expander:
    """Runs the worker for one file, and answers its requests."""

    def __init__(self, path: Path, options: FileOptions) -> None:
        self.path = path
        self.options = options
        self.packages = Packages(path, options.search_path)
        self.place = str(self.packages.folder / path.name)
        self.files: list[Path] = []
        self.notes: list[str] = []
        self.length = 0

    def expand(self) -> Expansion:
        result = self.result()
        if "error" in result:
            raise self.error(result["error"], result.get("place"))
        declared = set(result["declared"])
        for name in self.options.xacro_args:
            if name not in declared:
                hint = suggestion(name, declared)
                listed = ", ".join(sorted(declared)) or "none"
                raise InputError(
                    f"xacro_args: {self.path} has no argument '{name}'{hint}; it has: {listed}"
                )
        root = self.tree(result["elements"])
        notes = [f"{self.path.name}: xacro: {one_line(line)}" for line in result["printed"]]
        notes.extend(self.notes)
        return Expansion(root, notes, self.files)

    def result(self) -> dict[str, Any]:
        """The result of the worker."""
        command = [sys.executable, "-I", "-S", "-B", str(_WORKER)]
        request = {
            "path": sys.path,
            "seconds": _MAX_COMPUTING,
            "file": self.place,
            "arguments": dict(self.options.xacro_args),
        }
        with subprocess.Popen(  # noqa: S603 - this Python, on a file of this package
            command,
            cwd=self.packages.folder,
            env=environment(),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            encoding="utf-8",
        ) as process:
            timer = threading.Timer(_MAX_SECONDS, process.kill)
            timer.start()
            try:
                result = self.answer_all(process, request)
            finally:
                timer.cancel()
                process.kill()
        if result is None:
            raise self.error(_ended(process.returncode), None)
        return result

    def answer_all(
        self, process: subprocess.Popen[str], request: dict[str, Any]
    ) -> dict[str, Any] | None:
        """Answer the worker until it is done; None if it ends without a result."""
        assert process.stdin is not None  # noqa: S101 - it is a pipe
        assert process.stdout is not None  # noqa: S101
        message: Any = request
        while True:
            if not _send(process.stdin, message):
                break
            line = process.stdout.readline(_MAX_TEXT)
            if not line.endswith("\n"):
                break
            question = json.loads(line)
            if "result" in question:
                result: dict[str, Any] = question["result"]
                return result
            message = self.answer(question)
        process.wait(timeout=_MAX_SECONDS)
        return None

    def answer(self, question: dict[str, str]) -> dict[str, Any]:
        """The answer to a request of the worker."""
        try:
            if "find" in question:
                return {"value": str(self.packages.find(question["find"]))}
            if "glob" in question:
                return {"value": self.matching(Path(question["glob"]))}
            return self.text_of(Path(question["read"]))
        except (PackageError, DescriptionError) as error:
            return {"error": str(error)}

    def matching(self, pattern: Path) -> list[str]:
        """Files of one folder whose names match a pattern."""
        self.packages.require(pattern.parent)
        return sorted(map(str, pattern.parent.glob(pattern.name)))[:_MAX_FILES]

    def text_of(self, path: Path) -> dict[str, Any]:
        """The text of an included file."""
        self.packages.require(path)
        asked = path
        if not path.exists():
            path = self.packages.before_installation(path) or path
        if not path.exists():
            return {"error": f"there is no file {path}{_INSTALLED}", "missing": True}
        if path != asked:
            self.packages.require(path)
            self.notes.append(f"{asked} is there once its package is installed; read: {path}")
        text = read_text(path)
        self.length += len(text)
        if str(path) != self.place:
            self.files.append(path)
        if len(self.files) > _MAX_FILES or self.length > _MAX_TEXT:
            problem = f"includes more than {_MAX_FILES} files, or {_MAX_TEXT} characters"
            return {"error": problem}
        return {"value": text}

    def error(self, problem: str, place: list[Any] | None) -> DescriptionError:
        file, line = place or (self.place, None)
        return DescriptionError(f"xacro: {one_line(problem)}", file=self.named(file), line=line)

    def named(self, file: str) -> Path:
        """The path of a file in messages; for the main file, that of the call."""
        return self.path if file == self.place else Path(file)

    def tree(self, rows: list[Any]) -> LocatedElement:
        """The root of a tree of elements from rows in the order of the file."""
        if len(rows) > MAX_ELEMENTS:
            raise self.error(f"becomes more than {MAX_ELEMENTS} elements", None)
        open_elements: list[LocatedElement] = []
        root = LocatedElement("", {}, 1)
        for depth, tag, attributes, place, text in rows:
            if depth >= MAX_DEPTH:
                raise self.error(f"has elements inside more than {MAX_DEPTH} others", place)
            file, line = place or (self.place, 1)
            element = LocatedElement(tag, attributes, line, text=text, file=self.named(file))
            del open_elements[depth:]
            if open_elements:
                open_elements[-1].children.append(element)
            else:
                root = element
            open_elements.append(element)
        return root


def _send(pipe: IO[str], message: dict[str, Any]) -> bool:
    """Send a message; returns whether the worker is still running."""
    try:
        pipe.write(json.dumps(message) + "\n")
        pipe.flush()
    except OSError:
        return False
    return True


def _ended(code: int) -> str:
    """The reason why a worker gave no result."""
    if code == OUT_OF_TIME:
        return f"takes too long to expand: more than {_MAX_COMPUTING} s of computing"
    return f"cannot be expanded: xacro ended with {code}, out of memory or time"
