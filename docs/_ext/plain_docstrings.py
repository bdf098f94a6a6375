"""Docstrings here are plain text: `name: what it is` is a parameter, and no character but the backtick has a meaning."""

from __future__ import annotations

import inspect
import re
from typing import Any

from sphinx.application import Sphinx

ENTRY = re.compile(r"^(\w+(?:, \w+)*): (.*)$")
CODE = re.compile(r"(`[^`]+`)")
SPECIAL = re.compile(r"([\\*|])|(?<=\w)(_)(?!\w)")


def rewrite(app: Sphinx, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:  # noqa: ARG001
    """Turn one docstring into reStructuredText, in place."""
    known = parameters(thing) if what in {"function", "method", "class"} else set()
    result: list[str] = []
    in_attributes = in_entry = False
    for line in lines:
        bare = line.strip()
        if bare == "Attributes:":
            in_attributes = True
            result.append("")
            continue
        entry = ENTRY.match(bare)
        names = entry[1].split(", ") if entry else []
        if entry and (in_attributes or (known and set(names) <= known)):
            if not in_entry:
                result.append("")
            in_entry = True
            field = "ivar" if in_attributes else "param"
            result.append(f":{field} {', '.join(names) if in_attributes else names[0]}: {escaped(entry[2])}")
            if not in_attributes:  # every parameter has to be told by itself
                result += [f":param {other}: as {names[0]}" for other in names[1:]]
        elif in_entry and bare and line.startswith(" "):
            result.append(f"    {escaped(bare)}")
        else:
            if in_entry and bare:
                result.append("")
            in_entry = False
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
    parts = CODE.split(text)
    return "".join(part if part.startswith("`") else SPECIAL.sub(r"\\\1\2", part) for part in parts)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the rewriting."""
    app.connect("autodoc-process-docstring", rewrite)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
