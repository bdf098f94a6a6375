"""Messages about a name that does not exist: what may have been meant, and which names exist."""

from __future__ import annotations

import difflib
import unicodedata
from collections.abc import Iterable

MAX_WARNINGS = 3  # that an error lists
MAX_NAMES = 40  # that a message lists


def suggestion(name: str, candidates: Iterable[str]) -> str:
    """A hint such as ` (did you mean 'mass'?)`, or nothing; capitals and accents do not count."""
    originals: dict[str, str] = {}
    for candidate in candidates:
        originals.setdefault(fold_name(candidate), candidate)
    matches = difflib.get_close_matches(fold_name(name), list(originals), n=1)
    if not matches:
        return ""
    return did_you_mean(originals[matches[0]])


def did_you_mean(word: str) -> str:
    """The one form of a hint at what was meant."""
    return f" (did you mean '{word}'?)"


def no_such_name(kind: str, name: str, existing: Iterable[str]) -> str:
    """The message that no frame, loop or other kind of thing has this name."""
    names = list(existing)
    listed = ", ".join(names[:MAX_NAMES]) or "none"
    if len(names) > MAX_NAMES:
        listed += ", ..."
    return f"there is no {kind} '{name}'{suggestion(name, names)}; known: {listed}"


def with_warnings(problem: str, warnings: Iterable[str]) -> str:
    """A problem, and below it the warnings about the file: most likely its cause."""
    causes = [f"perhaps for this reason: {warning}" for warning in warnings]
    lines = [problem, *causes[:MAX_WARNINGS]]
    remaining = len(causes) - MAX_WARNINGS
    if remaining > 0:
        lines.append(f"and {remaining} more like this, told by `check` once these are mended")
    return "\n  ".join(lines)


def fold_name(name: str) -> str:
    """A name without capitals and accents."""
    letters = unicodedata.normalize("NFKD", name)
    return "".join(c for c in letters if not unicodedata.combining(c)).casefold()
