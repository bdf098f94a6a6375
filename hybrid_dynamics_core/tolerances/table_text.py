"""Tables of tolerances as text: an entry a line, or several with commas."""

from __future__ import annotations

import re
from typing import Final

from ..errors import InputError

FORM: Final = "expected PATH=VALUE, such as joints.q2.play=0.05*mm"
_COMMENT: Final = re.compile(r"#.*")


def table_of(text: str) -> dict[str, str]:
    """The entries of a text such as `L2=0.1*mm, joints.q2.play=0.05*mm`.

    Args:
        text: entries with commas between them or on lines of their own; what follows a # is a
            comment.

    Raises:
        InputError: an entry has another form, or a path is given twice.
    """
    table: dict[str, str] = {}
    plain = _COMMENT.sub("", text)
    for part in re.split(r"[,\n]", plain):
        if not part.strip():
            continue
        path, equals, value = part.partition("=")
        name = path.strip()
        if not equals or not name or not value.strip():
            raise InputError(f"tolerances: '{part.strip()}': {FORM}")
        if name in table:
            raise InputError(f"tolerances: '{name}' is given twice")
        table[name] = value.strip()
    return table
