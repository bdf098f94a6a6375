"""What somebody may have meant by a name that there is not."""

from __future__ import annotations

import difflib
import unicodedata
from collections.abc import Iterable

FEW = 3  # warnings that are told with an error
MANY = 40  # names that are told


def nearest(name: str, known: Iterable[str]) -> str:
    """A hint such as ' (did you mean "mass"?)', or nothing; capitals and accents count little."""
    words: dict[str, str] = {}
    for other in known:
        words.setdefault(plain(other), other)
    match = difflib.get_close_matches(plain(name), list(words), n=1)
    return meant(words[match[0]]) if match else ""


def meant(word: str) -> str:
    """The one form of a hint at what was meant."""
    return f" (did you mean '{word}'?)"


def none_such(kind: str, name: str, known: Iterable[str]) -> str:
    """That there is no frame, loop or whatever of this name, what may have been meant, and which there are."""
    names = list(known)
    told = (", ".join(names[:MANY]) or "none") + (", ..." if len(names) > MANY else "")
    return f"there is no {kind} '{name}'{nearest(name, names)}; known: {told}"


def with_warnings(problem: str, warnings: Iterable[str]) -> str:
    """A problem, with what fits the format and is hardly meant: most likely its cause."""
    told = [f"perhaps for this reason: {doubt}" for doubt in warnings]
    more = (
        [f"and {len(told) - FEW} more like this, told by `check` once these are mended"]
        if len(told) > FEW
        else []
    )
    return "\n  ".join([problem, *told[:FEW], *more])


def plain(name: str) -> str:
    """A name without capitals and accents."""
    letters = unicodedata.normalize("NFKD", name)
    return "".join(c for c in letters if not unicodedata.combining(c)).casefold()
