"""Hints at the verb that accepts a given file."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from hybrid_dynamics_core.ground.file_kinds import FileKind

PROGRAM: Final = "hybrid-dynamics"
CALLS: Final = {
    FileKind.ROBOT: "check {path}",
    FileKind.BAG: "bag report {path}",
    FileKind.BAG_PART: "bag report {folder}",
    FileKind.BAGS: "bag process {path} OUT --robot ROBOT",
    FileKind.TRAJECTORY: "view ROBOT --trajectory {path}",
    FileKind.SETTINGS: "bag process IN OUT --robot ROBOT --params {path}",
}


def taken_by(error: Any) -> str:
    """The hint `; try: ...` for an error about a file of another kind; otherwise an empty text."""
    kind = getattr(error, "kind", None)
    file = getattr(error, "file", None)
    if kind is FileKind.TABLES:
        return "; name the recording that these tables were exported from"
    if kind not in CALLS or file is None:
        return ""
    call = CALLS[kind].format(path=file, folder=Path(file).parent)
    return f"; try: {PROGRAM} {call}"
