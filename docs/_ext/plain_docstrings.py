"""Docstrings of the library are plain text.

`name: what it is` is a parameter; only backticks have a meaning.
"""

from __future__ import annotations

import inspect
import re
from typing import Any

from sphinx.application import Sphinx
from sphinx.util.inspect import TypeAliasForwardRef

ENTRY = re.compile(r"^(\w+(?:, \w+)*): (.*)$")
CODE = re.compile(r"(`[^`]+`)")
LISTED = re.compile(r"^(\s*)(\(?\w+[.)]\s|[-+]\s)")  # would begin a list
SPECIAL = re.compile(r"([\\*|])|(?<=\w)(_)(?!\w)")


def rewrite(app: Sphinx, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:  # noqa: ARG001
    """Turn one docstring into reStructuredText, in place."""
    known = parameters(thing) if what in {"function", "method", "class"} else set()
    result: list[str] = []
    attributes = entry = False
    for line in lines:
        bare = line.strip()
        told = ENTRY.match(bare)
        names = told[1].split(", ") if told else []
        if bare == "Attributes:":
            attributes = True
            result.append("")
        elif told and (attributes or line.startswith(" " * 4)) and not line.startswith(" " * 8):
            attributes = True
            result += [", ".join(f"``{each}``" for each in names), f"    {escaped(told[2])}"]
        elif attributes and bare:
            result.append(f"    {escaped(bare)}")
        elif told and known and set(names) <= known:
            result += ([] if entry else [""]) + [f":param {names[0]}: {escaped(told[2])}"]
            result += [
                f":param {other}: as {names[0]}" for other in names[1:]
            ]  # each is told by itself
            entry = True
        elif entry and bare and line.startswith(" "):
            result.append(f"    {escaped(bare)}")
        else:
            result += [""] if entry and bare else []
            entry = attributes = False
            result.append(line if bare.startswith((">>>", "...")) else escaped(line))
    lines[:] = [*result, ""]


def parameters(thing: Any) -> set[str]:
    """Names of what a function or class takes."""
    try:
        return set(inspect.signature(thing).parameters)
    except (TypeError, ValueError):
        return set()


def escaped(text: str) -> str:
    """Text whose stars, bars and ends in _ stay what they are."""
    parts = [
        part if part.startswith("`") else SPECIAL.sub(r"\\\1\2", part) for part in CODE.split(text)
    ]
    return LISTED.sub(r"\1\\\2", "".join(parts))


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the rewriting."""
    app.connect("autodoc-process-docstring", rewrite)
    TypeAliasForwardRef.__repr__ = lambda alias: (
        alias.name
    )  # in `Array | None` Sphinx shows how it keeps `Array`
    return {"parallel_read_safe": True, "parallel_write_safe": True}
