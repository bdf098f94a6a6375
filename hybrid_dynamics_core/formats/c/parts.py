"""Long functions in parts, since compilers take more than twice as long for twice the length.

Parts hand on what later ones need in an array.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

LONGEST = 16_000  # characters of a part: some 800 operations
PART = """\
/* parts stay apart: compilers need less time for them */
#if defined(__GNUC__)
#define PART static __attribute__((noinline))
#else
#define PART static
#endif
"""
_DEFINED = re.compile(r"^ *(?:const )?double ([vb]\d+)(?:\[(\d+)\])?", re.MULTILINE)
_NAME = re.compile(r"\b[vb]\d+\b")
_INPUT = re.compile(r"\ba(\d+)\[")


@dataclass(frozen=True)
class Text:
    """A function of arrays, `static KIND NAME(const double *a0, ..., double *out)`.

    Attributes:
        kind: what it returns.
        name: its name.
        vectors: number of its input arrays.
        statements: those that define values.
        last: those that hand out results; they stay together.
    """

    kind: str
    name: str
    vectors: int
    statements: Sequence[str]
    last: Sequence[str]


def in_parts(text: Text) -> list[str]:
    """The C functions of a text: its parts, then the function that calls them."""
    chunks = _chunks(text.statements)
    if len(chunks) == 1:
        return [_function(f"static {text.kind} {text.name}", text.vectors, _all(text), "out")]
    handed = _Handed(text, chunks)
    functions = [PART]
    calls = [f"double w[{handed.size}];"]
    listed = "".join(f"a{v}, " for v in range(text.vectors))
    for number, chunk in enumerate(chunks[:-1]):
        name = f"{text.name}_part{number}"
        functions.append(_function(f"PART void {name}", text.vectors, handed.part(chunk), "w"))
        calls.append(f"{name}({listed}w);")
    lines = [*calls, *handed.part([*chunks[-1], *text.last])]
    functions.append(_function(f"static {text.kind} {text.name}", text.vectors, lines, "out"))
    return functions


def _all(text: Text) -> list[str]:
    return [*text.statements, *text.last]


def _chunks(statements: Sequence[str]) -> list[list[str]]:
    """The statements, in order, in parts of about equal length."""
    total = sum(map(len, statements))
    count = total // LONGEST + 1
    chunks: list[list[str]] = [[]]
    length = 0
    for statement in statements:
        if length * count > total * len(chunks):
            chunks.append([])
        chunks[-1].append(statement)
        length += len(statement)
    return chunks


class _Handed:
    """The values that parts hand on, and their places in the array `w`.

    Attributes:
        size: length of the array.
    """

    def __init__(self, text: Text, chunks: Sequence[Sequence[str]]) -> None:
        self.size = 0
        self._places: dict[str, tuple[int, int]] = {}  # by name: first place, length or 0
        lengths: dict[str, int] = {}
        uses = [*map("\n".join, chunks[1:])]
        uses[-1] += "\n" + "\n".join(text.last)
        for number, later in enumerate(uses):
            for name, length in _DEFINED.findall("\n".join(chunks[number])):
                lengths[name] = int(length or 0)
            for name in dict.fromkeys(_NAME.findall(later)):
                if name in lengths and name not in self._places:
                    self._places[name] = (self.size, lengths[name])
                    self.size += lengths[name] or 1

    def part(self, statements: Sequence[str]) -> list[str]:
        """The statements with what they take from the array, and what they put there."""
        joined = "\n".join(statements)
        defined = {name for name, _ in _DEFINED.findall(joined)}
        names = dict.fromkeys(_NAME.findall(joined))
        lines = [self._taken(name) for name in names if name not in defined]
        for statement in statements:
            lines.append(statement)
            for name, _ in _DEFINED.findall(statement):
                lines += self._put(name)
        return lines

    def _taken(self, name: str) -> str:
        place, length = self._places[name]
        if length:
            return f"const double *const {name} = w + {place};"
        return f"const double {name} = w[{place}];"

    def _put(self, name: str) -> list[str]:
        if name not in self._places:
            return []
        place, length = self._places[name]
        if not length:
            return [f"w[{place}] = {name};"]
        return [f"w[{place + k}] = {name}[{k}];" for k in range(length)]


def _function(head: str, vectors: int, lines: Sequence[str], result: str) -> str:
    """A function; inputs that it does not read are named, so that compilers do not warn."""
    joined = "\n".join(lines)
    read = {int(v) for v in _INPUT.findall(joined)}
    unread = [f"(void)a{v};" for v in range(vectors) if v not in read and f"(a{v}," not in joined]
    arguments = "".join(f"const double *a{v}, " for v in range(vectors))
    body = "\n".join([*unread, joined])
    return f"{head}({arguments}double *{result})\n{{\n{indented(body)}\n}}\n"


def indented(text: str) -> str:
    """A text with each line four spaces further right."""
    return "\n".join(f"    {line}" for line in text.split("\n"))
