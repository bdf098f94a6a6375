"""A description as it was written, from which it is built again with other numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ...errors import InputError
from ...ground.lazy import lazy
from ..document import Document, KeyPath
from ..expand.short_forms import expand_short_forms
from ..model import RobotDescription
from .entries_at import entry_at, has_entry, with_entry

Build = Callable[[Document], RobotDescription]

_NOT_WRITTEN = (
    "has no parameters: it was not read from a file, or was changed after that; load a file"
)


class Written:
    """The document of a description before its short forms are expanded.

    Attributes:
        document: the document; not changed.
        changes: numbers in place of those of the document, by path.
        code: code that robots of this document share, by the numbers that they differ in.
    """

    def __init__(
        self, document: Document, build: Build, changes: Mapping[KeyPath, Any] | None = None
    ) -> None:
        """Keep a document.

        Args:
            document: of format 1, with the links of a URDF that it names.
            build: makes the description of an expanded document; a function of a module.
            changes: numbers in place of those of the document, by path.
        """
        self.document = document
        self.changes: dict[KeyPath, Any] = dict(changes or {})
        self._build = build
        self.code: dict[Any, Any] = {}

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle without the cached documents."""
        return Written, (self.document, self._build, self.changes)

    @lazy
    def expanded(self) -> tuple[Document, Document]:
        """The document with its changes, before and after short forms are expanded: to read."""
        return self._expanded()

    def _expanded(self) -> tuple[Document, Document]:
        document = self.document.copy()
        later: dict[KeyPath, Any] = {}
        for path, value in self.changes.items():
            if has_entry(document.data, path[:2]):
                _change(document, path, value)
            else:
                later[path] = value
        before = document.copy()
        expand_short_forms(document)
        for path, value in later.items():
            _change(document, path, value)
        return before, document

    def document_to_build(self) -> Document:
        """The expanded document with the changes, to build from."""
        _, document = self._expanded()
        return document

    def described(self) -> RobotDescription:
        """The description with the changes.

        Raises:
            DescriptionError: a number does not fit.
        """
        return carry(self._build(self.document_to_build()), self)

    def changed(self, changes: Mapping[KeyPath, Any]) -> Written:
        """The same with further changes."""
        other = Written(self.document, self._build, {**self.changes, **changes})
        other.code = self.code
        return other


def carry(description: RobotDescription, written: Written | None) -> RobotDescription:
    """Let a description carry what it was built from; `dataclasses.replace` drops it."""
    object.__setattr__(description, "written", written)
    return description


def add_note(description: RobotDescription, note: str) -> None:
    """Add a note to a description that was just made."""
    object.__setattr__(description, "notes", (*description.notes, note))


def written_of(description: RobotDescription) -> Written:
    """What a description was built from.

    Raises:
        InputError: it was made or changed by a program.
    """
    written = description.written
    if not isinstance(written, Written):
        raise InputError(f"{description.name} {_NOT_WRITTEN}")
    return written


def _change(document: Document, path: KeyPath, value: Any) -> None:
    """Set an entry, with a note."""
    former = entry_at(document.data, path)
    document.note(path, f"{value}, as given in the call, in place of {former}")
    document.data = with_entry(document.data, path, value)
