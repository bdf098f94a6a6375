"""Plain data of a description, and for every entry the place where it was written: what messages point at."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import DescriptionError
from ..ground.suggestions import with_warnings

Path_ = tuple[str | int, ...]
File = str | Path | None


@dataclass(frozen=True)
class Origin:
    """What an expanded entry was written as: its path in the file, and what stood between (an entry of a template)."""

    path: Path_
    note: str = ""


class Document:
    """Nested dictionaries and lists (`data`) that remember file and line.

    Expansions `add` entries; an error at an added entry names the entry that the user wrote.
    """

    def __init__(self, data: Any, file: File, lines: Mapping[Path_, int]) -> None:
        self.data = data
        self.file = file
        self.notes: list[str] = []  # what the loader assumed, for `RobotDescription.notes`
        self.warnings: list[
            str
        ] = []  # what fits the format and is hardly meant, for `RobotDescription.warnings`
        self.printed: set[str] = (
            set()
        )  # links whose numbers were rounded by the tool that printed them
        self._places: dict[Path_, tuple[File, int]] = {
            path: (file, line) for path, line in lines.items()
        }
        self._origins: dict[Path_, Origin] = {}
        self._scopes: dict[Path_, Mapping[str, float]] = {}

    def section(self, name: str) -> dict[str, Any]:
        """A top-level mapping, made where it is missing."""
        section: dict[str, Any] = self.data.setdefault(name, {})
        return section

    def add(
        self,
        path: tuple[str, str],
        value: Any,
        origin: Path_ | Origin,
        scope: Mapping[str, float] | None = None,
        mend: str = "rename one of the two",
    ) -> None:
        """Add an entry (section, name) that stands for the one at `origin`; `scope`: what its expressions may name."""
        section, name = path
        origin = origin if isinstance(origin, Origin) else Origin(origin)
        if name in self.section(section):
            note = f" ({origin.note})" if origin.note else ""
            raise self.error(origin.path, self._taken(path, mend) + note)
        self._origins[path] = origin
        if scope is not None:
            self._scopes[path] = scope
        self.section(section)[name] = value

    def _taken(self, path: Path_, mend: str = "rename one of the two") -> str:
        file, line = self.place(path)
        where = f"line {line}" if file == self.file else f"{file}:{line}"
        return f"the name '{path[-1]}' is given twice in {path[0]} (first in {where}); {mend}"

    def add_located(self, path: tuple[str, str], value: Any, file: File, line: int) -> None:
        """Add an entry that was read from another file."""
        if path[1] in self.section(path[0]):
            raise DescriptionError(self._taken(path), key=dotted(path), file=file, line=line)
        self._places[path] = (file, line)
        self.section(path[0])[path[1]] = value

    def mark(self, path: Path_, file: File, line: int) -> None:
        """Tell where an entry inside an added one stands."""
        self._places[path] = (file, line)

    def part(self, name: str) -> Document:
        """A top-level mapping as a document of its own; empty where there is none."""
        lines = {path[1:]: place[1] for path, place in self._places.items() if path[:1] == (name,)}
        return Document(deepcopy(self.data.get(name) or {}), self.file, lines)

    def merge(self, other: Document) -> None:
        """Take over the entries of another document: mappings are joined, everything else is replaced."""
        self._places.update({path: place for path, place in other._places.items() if path})
        _join(self.data, other.data)

    def alias(self, path: Path_, origin: Path_) -> None:
        """A value inside an added entry that the user wrote elsewhere."""
        self._origins[path] = Origin(origin)

    def scope(self, path: Path_, default: Mapping[str, float]) -> Mapping[str, float]:
        """The names that an expression at this place may use."""
        own = (
            len(path) > 2 and path[:3] in self._origins
        )  # a value inside, which the user wrote elsewhere
        return default if own else self._scopes.get(path[:2], default)

    def written(self, path: Path_) -> tuple[Path_, str]:
        """The path as the user wrote it, and what stood between."""
        for n in range(len(path), 0, -1):
            origin = self._origins.get(path[:n])
            if origin is None:
                continue
            outer, note = self.written(origin.path)
            if origin.note:
                return outer, " in ".join(
                    part for part in (_inside(origin.note, path[n:]), note) if part
                )
            return (*outer, *path[n:]), note
        return path, ""

    def place(self, path: Path_) -> tuple[File, int | None]:
        """File and line of the entry, or of the nearest enclosing one that has them."""
        path, _ = self.written(path)
        while path and path not in self._places:
            path = path[:-1]
        return self._places.get(path, (self.file, None))

    def error(self, path: Path_, problem: str) -> DescriptionError:
        """A DescriptionError that points at the entry as the user wrote it, and tells what was doubted before."""
        return self._located(path, with_warnings(problem, self.warnings))

    def _located(self, path: Path_, problem: str) -> DescriptionError:
        written, note = self.written(path)
        file, line = self.place(path)
        return DescriptionError(
            problem + (f" ({note})" if note else ""), key=dotted(written), file=file, line=line
        )

    def doubt(self, path: Path_, problem: str) -> None:
        """Keep what is allowed at this entry and hardly meant; a message as those of errors, told once."""
        told = str(self._located(path, problem))
        if told not in self.warnings:
            self.warnings.append(told)

    def lines(self) -> dict[str, int]:
        """Line of every entry by dotted key, those of added entries too."""
        lines = {dotted(path): self.place(path)[1] for path in (*self._places, *self._origins)}
        return {key: line for key, line in lines.items() if line is not None}

    def files(self) -> dict[str, File]:
        """File of the entries that stand in another one."""
        return {dotted(path): file for path, (file, _) in self._places.items() if file != self.file}


def _join(data: dict[str, Any], others: Mapping[str, Any]) -> None:
    for key, value in others.items():
        if isinstance(value, dict) and isinstance(data.get(key), dict):
            _join(data[key], value)
        else:
            data[key] = value


def _inside(note: str, rest: Path_) -> str:
    return dotted((note, *rest)) if rest else note


def dotted(path: Path_) -> str:
    """('links', 'l1', 'com', 0) -> 'links.l1.com[0]'."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else (f".{part}" if text else part)
    return text
