"""Pins of loops by the role of their link, such as `loops.lift.pin.arm`."""

from __future__ import annotations

import re

from ..document import Document

_PIN = re.compile(r"loops\.(?P<loop>.+)\.pin\.(?P<role>base|arm|k1|k2)(?P<after>$|[.\[].*)")


def with_link(document: Document, name: str) -> str:
    """The path of a pin in which a role is replaced by the link in that place.

    Args:
        document: a document with the loop.
        name: a path; one without a role is returned as it is.
    """
    match = _PIN.fullmatch(name)
    if match is None:
        return name
    loop = document.entries("loops").get(match["loop"])
    role = match["role"]
    if not isinstance(loop, dict) or role not in loop:
        return name
    pins = loop.get("pin")
    if isinstance(pins, dict) and role in pins:
        return name  # a link of this name
    return f"loops.{match['loop']}.pin.{loop[role]}{match['after']}"
