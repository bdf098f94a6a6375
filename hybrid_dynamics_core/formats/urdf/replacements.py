"""Joints of a URDF that stand for spherical or universal joints, or are to be fixed."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from ...description.document import Document, KeyPath

_UNIVERSAL = re.compile(r"^U(?:JOINT|NIVERSAL)_([XYZ])([XYZ])$")
_EXPECTED = "SPHERICAL, FIXED, UJOINT_XY and the like"


def add_replacement(
    document: Document,
    location: tuple[Path, int],
    name: str,
    entry: dict[str, Any],
    kind: str,
    written: KeyPath,
) -> None:
    """Add the joints that stand in place of one: about axes of its frame, massless links between.

    Args:
        document: to which they are added.
        location: file and line of the joint.
        name: of the joint.
        entry: type, parent, child and origin of the joint.
        kind: SPHERICAL, FIXED, UJOINT_XY and the like.
        written: where the kind is written.

    Raises:
        DescriptionError: the kind is none of these, or a name is taken.
    """
    if kind == "FIXED":
        document.add_located(("joints", name), {**entry, "type": "fixed"}, *location)
        document.notes.append(f"{name}: fixed at its zero")
        return
    letters = _axes(kind)
    if not letters:
        raise document.error(written, f"is '{kind}'; expected {_EXPECTED}")
    parent = entry["parent"]
    origin = entry["origin"]
    for letter in letters[:-1]:
        joint = f"{name}_{letter}"  # its link has the same name
        document.add_located(("links", joint), {}, *location)
        _add_revolute(document, location, joint, (parent, joint), origin)
        parent = joint
        origin = {}
    _add_revolute(document, location, f"{name}_{letters[-1]}", (parent, entry["child"]), origin)


def _axes(kind: str) -> str:
    """Letters of the axes about which a joint turns; empty for an unknown kind."""
    if kind == "SPHERICAL":
        return "XYZ"
    universal = _UNIVERSAL.match(kind)
    if universal is None or universal[1] == universal[2]:
        return ""
    return universal[1] + universal[2]


def _add_revolute(
    document: Document,
    location: tuple[Path, int],
    name: str,
    links: tuple[str, str],
    origin: dict[str, Any],
) -> None:
    """A joint NAME_X about x, and so on, between two links."""
    parent, child = links
    entry = {
        "type": "revolute",
        "parent": parent,
        "child": child,
        "origin": origin,
        "axis": name[-1].lower(),
    }
    document.add_located(("joints", name), entry, *location)
