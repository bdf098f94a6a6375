"""Which verb takes a file that another verb does not."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from hybrid_dynamics_core.ground.file_kinds import FileKind

PROGRAM: Final = "hybrid-dynamics"
TAKERS: Final = {
    FileKind.ROBOT: "check {path}",
    FileKind.BAG: "bag report {path}",
    FileKind.BAG_PART: "bag report {folder}",
    FileKind.BAGS: "bag process {path} OUT --robot ROBOT",
    FileKind.TRAJECTORY: "view ROBOT --trajectory {path}",
    FileKind.SETTINGS: "bag process IN OUT --robot ROBOT --params {path}",
}


def taken_by(error: Any) -> str:
    """`; it is taken by: ...` for an error about a file of another kind; else nothing."""
    kind, file = getattr(error, "kind", None), getattr(error, "file", None)
    if kind is FileKind.TABLES:
        return "; name the recording that these tables were exported from"
    if kind not in TAKERS or file is None:
        return ""
    return f"; try: {PROGRAM} {TAKERS[kind].format(path=file, folder=Path(file).parent)}"
