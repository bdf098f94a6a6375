"""Plain data of a description, with file and line of every entry."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from copy import copy, deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import DescriptionError
from ..ground.file_options import NO_OPTIONS, FileOptions
from ..ground.suggestions import with_warnings
from .model import MultiDofJoint

Data = dict[str, Any]  # plain data of a mapping
KeyPath = tuple[str | int, ...]  # keys and list indices down to an entry
FilePath = str | Path | None

_RENAME = "rename one of the two"


@dataclass(frozen=True)
class Provenance:
    """The origin of an expanded entry.

    Attributes:
        path: path of the entry that the user wrote.
        note: the template entry that it came through, as text.
    """

    path: KeyPath
    note: str = ""


class Document:
    """Nested dictionaries and lists that remember file and line of every entry.

    Short forms `add` the entries that they stand for. An error at an added entry names the one that
    the user wrote.

    Attributes:
        data: the dictionaries and lists.
        file: the file they were read from.
        notes: assumptions of the loader, for `RobotDescription.notes`.
        warnings: on entries that are allowed but likely wrong, for `RobotDescription.warnings`.
        impossible: problem of each inertia that no rigid body has, by dotted key.
        rounded_links: links whose numbers were printed with few digits.
        multi_dof: joints of several freedoms by name, for `RobotDescription.multi_dof`.
        charts: charts of ball and free joints at the reference, for `RobotDescription.charts`.
        options: arguments of the call that reads the file.
    """

    def __init__(
        self,
        data: Any,
        file: FilePath,
        lines: Mapping[KeyPath, int],
        options: FileOptions = NO_OPTIONS,
    ) -> None:
        self.data = data
        self.file = file
        self.options = options
        self.notes: list[str] = []
        self.warnings: list[str] = []
        self.impossible: dict[str, str] = {}
        self.rounded_links: set[str] = set()
        self.multi_dof: dict[str, MultiDofJoint] = {}
        self.charts: dict[str, float] = {}
        self._locations: dict[KeyPath, tuple[FilePath, int]] = {}
        for path, line in lines.items():
            self._locations[path] = (file, line)
        self._provenance: dict[KeyPath, Provenance] = {}
        self._scopes: dict[KeyPath, Mapping[str, float]] = {}

    def section(self, name: str) -> Data:
        """A top-level mapping; added if it is missing."""
        section: Data = self.data.setdefault(name, {})
        return section

    def entries(self, name: str) -> Data:
        """A top-level mapping; empty if it is missing."""
        entries: Data = self.data.get(name) or {}
        return entries

    def copy(self) -> Document:
        """An independent copy."""
        other = copy(self)
        other.data = deepcopy(self.data)
        for name, value in vars(self).items():
            if name != "data" and isinstance(value, (dict, list, set)):
                setattr(other, name, copy(value))
        return other

    # -- entries

    def add(
        self,
        path: tuple[str, str],
        value: Any,
        provenance: KeyPath | Provenance,
        scope: Mapping[str, float] | None = None,
        remedy: str = _RENAME,
    ) -> None:
        """Add an entry that results from one that the user wrote.

        Args:
            path: section and name of the new entry.
            value: the entry.
            provenance: the entry that the user wrote.
            scope: names that its expressions may use; None for the parameters of the document.
            remedy: advice in the error if the name is taken.

        Raises:
            DescriptionError: the section has an entry of this name.
        """
        if not isinstance(provenance, Provenance):
            provenance = Provenance(provenance)
        section, name = path
        if name in self.section(section):
            problem = self._name_taken(path, remedy)
            if provenance.note:
                problem += f" ({provenance.note})"
            raise self.error(provenance.path, problem)
        self._provenance[path] = provenance
        if scope is not None:
            self._scopes[path] = scope
        self.section(section)[name] = value

    def add_located(self, path: tuple[str, str], value: Any, file: FilePath, line: int) -> None:
        """Add an entry that was read from another file.

        Raises:
            DescriptionError: the section has an entry of this name.
        """
        section, name = path
        if name in self.section(section):
            problem = self._name_taken(path, _RENAME)
            raise DescriptionError(problem, key=dotted(path), file=file, line=line)
        self._locations[path] = (file, line)
        self.section(section)[name] = value

    def alias(self, path: KeyPath, written: KeyPath) -> None:
        """Record where the user wrote a value that is now inside an added entry."""
        self._provenance[path] = Provenance(written)

    def set_location(self, path: KeyPath, file: FilePath, line: int) -> None:
        """Set the location of an entry inside an added one."""
        self._locations[path] = (file, line)

    def add_files(self, files: Iterable[Path]) -> None:
        """Record files that were read but contain no entry."""
        for file in files:
            self._locations["read", len(self._locations)] = (file, 1)

    def subdocument(self, name: str) -> Document:
        """A top-level mapping as a document of its own; empty where there is none."""
        lines: dict[KeyPath, int] = {}
        for path, (_, line) in self._locations.items():
            if path[:1] == (name,):
                lines[path[1:]] = line
        return Document(deepcopy(self.entries(name)), self.file, lines)

    def merge(self, other: Document) -> None:
        """Merge another document into this one; mappings are joined, other values replaced."""
        for path, location in other._locations.items():
            if path:
                self._locations[path] = location
        _merge_mappings(self.data, other.data)

    def scope(self, path: KeyPath, parameters: Mapping[str, float]) -> Mapping[str, float]:
        """The names that an expression may use: those of its template, or the parameters."""
        written_elsewhere = len(path) > 2 and path[:3] in self._provenance
        if written_elsewhere:
            return parameters
        return self._scopes.get(path[:2], parameters)

    # -- locations

    def as_written(self, path: KeyPath) -> tuple[KeyPath, str]:
        """The path of the user's entry, and the template entry that it came through."""
        for n in range(len(path), 0, -1):
            provenance = self._provenance.get(path[:n])
            if provenance is None:
                continue
            inner_path = path[n:]
            outer_path, outer_note = self.as_written(provenance.path)
            if not provenance.note:
                return (*outer_path, *inner_path), outer_note
            note = provenance.note
            if inner_path:
                note = dotted((note, *inner_path))
            if outer_note:
                note = f"{note} in {outer_note}"
            return outer_path, note
        return path, ""

    def location(self, path: KeyPath) -> tuple[FilePath, int | None]:
        """File and line of the entry, or of the nearest enclosing one that has them."""
        path, _ = self.as_written(path)
        while path and path not in self._locations:
            path = path[:-1]
        return self._locations.get(path, (self.file, None))

    def lines(self) -> dict[str, int]:
        """Line of every entry by dotted key, with those of added entries."""
        lines: dict[str, int] = {}
        for path in (*self._locations, *self._provenance):
            _, line = self.location(path)
            if line is not None:
                lines[dotted(path)] = line
        return lines

    def files(self) -> dict[str, FilePath]:
        """File of the entries that stand in another one, by dotted key."""
        files: dict[str, FilePath] = {}
        for path, (file, _) in self._locations.items():
            if file != self.file:
                files[dotted(path)] = file
        return files

    # -- messages

    def error(self, path: KeyPath, problem: str) -> DescriptionError:
        """A DescriptionError that points at the entry as the user wrote it, with all warnings."""
        return self._located(path, with_warnings(problem, self.warnings))

    def warn(self, path: KeyPath, problem: str) -> None:
        """Add a warning, once, on an entry that is allowed but likely wrong."""
        warning = str(self._located(path, problem))
        if warning not in self.warnings:
            self.warnings.append(warning)

    def note(self, path: KeyPath, remark: str) -> None:
        """Add a note on what was changed at an entry."""
        self.notes.append(str(self._located(path, remark)))

    def warn_of_inertia(self, path: KeyPath, problem: str) -> None:
        """Add a note on an inertia that no rigid body has, but which is used as given."""
        self.impossible[dotted(path)] = problem
        self.note(path, f"{problem}; it is taken as it stands")

    def _located(self, path: KeyPath, problem: str) -> DescriptionError:
        written, note = self.as_written(path)
        if note:
            problem += f" ({note})"
        file, line = self.location(path)
        return DescriptionError(problem, key=dotted(written), file=file, line=line)

    def _name_taken(self, path: tuple[str, str], remedy: str) -> str:
        section, name = path
        file, line = self.location(path)
        where = f"{file}:{line}"
        if file == self.file:
            where = f"line {line}"
        return f"the name '{name}' is given twice in {section} (first in {where}); {remedy}"


def dotted(path: KeyPath) -> str:
    """('links', 'l1', 'com', 0) -> 'links.l1.com[0]'."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        elif text:
            text += f".{part}"
        else:
            text = part
    return text


def _merge_mappings(data: Data, others: Data) -> None:
    for key, value in others.items():
        if isinstance(value, dict) and isinstance(data.get(key), dict):
            _merge_mappings(data[key], value)
        else:
            data[key] = value
