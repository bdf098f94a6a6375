"""Messages for unknown names: a suggestion, and the existing names."""

from __future__ import annotations

import difflib
import unicodedata
from collections.abc import Iterable

MAX_WARNINGS = 3  # listed in an error
MAX_NAMES = 40  # listed in a message


def suggestion(name: str, candidates: Iterable[str]) -> str:
    """A hint such as ` (did you mean 'mass'?)`, or ""; case and accents are ignored."""
    originals: dict[str, str] = {}
    for candidate in candidates:
        originals.setdefault(fold_name(candidate), candidate)
    matches = difflib.get_close_matches(fold_name(name), list(originals), n=1)
    if not matches:
        return ""
    return did_you_mean(originals[matches[0]])


def did_you_mean(word: str) -> str:
    """The text of a suggestion, the same in all messages."""
    return f" (did you mean '{word}'?)"


def no_such_name(kind: str, name: str, existing: Iterable[str]) -> str:
    """The message that no frame, loop or other item has this name."""
    names = list(existing)
    listed = ", ".join(names[:MAX_NAMES]) or "none"
    if len(names) > MAX_NAMES:
        listed += ", ..."
    return f"there is no {kind} '{name}'{suggestion(name, names)}; known: {listed}"


def with_warnings(problem: str, warnings: Iterable[str]) -> str:
    """A problem, followed by the warnings on the file, which may be its cause."""
    causes = [f"perhaps for this reason: {warning}" for warning in warnings]
    lines = [problem, *causes[:MAX_WARNINGS]]
    remaining = len(causes) - MAX_WARNINGS
    if remaining > 0:
        lines.append(f"and {remaining} more like this, told by `check` once these are mended")
    return "\n  ".join(lines)


def fold_name(name: str) -> str:
    """A name in lower case without accents."""
    letters = unicodedata.normalize("NFKD", name)
    return "".join(c for c in letters if not unicodedata.combining(c)).casefold()
