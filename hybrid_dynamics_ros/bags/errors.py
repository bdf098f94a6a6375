"""Errors on bags, with texts for the terminal."""

from __future__ import annotations

from pathlib import Path

from hybrid_dynamics_core.errors import HybridDynamicsError, InputError
from hybrid_dynamics_core.ground.file_kinds import FileKind, classify_path, unexpected_content


class BagError(HybridDynamicsError):
    """A bag cannot be read or written; the text says which one, why, and what to do."""


class BagCallError(BagError, InputError):
    """An argument is wrong: a missing topic, an existing path, a file of another kind.

    Attributes:
        file: the file of an unexpected kind; None for other errors.
        kind: the kind of that file.
    """

    file: Path | None = None
    kind: FileKind | None = None


def wrong_kind(path: Path, expected: str) -> BagCallError:
    """The error for a path that is missing, or of another kind."""
    error = BagCallError(f"{path}: {unexpected_content(path, expected)}")
    error.file, error.kind = path, classify_path(path).kind
    return error
