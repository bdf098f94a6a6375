"""Replacement of URDF joints by spherical, universal or fixed joints."""

from __future__ import annotations

import re

from ...description.document import Data, KeyPath
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader

_UNIVERSAL = re.compile(r"^U(?:JOINT|NIVERSAL)_([XYZ])([XYZ])$")
_EXPECTED = "SPHERICAL, FIXED, UJOINT_XY and the like"


def add_replacement(
    xml: XmlReader, element: LocatedElement, entry: Data, kind: str, written: KeyPath
) -> None:
    """Add the joints that replace one: about axes of its frame, with massless links in between.

    Args:
        xml: the URDF.
        element: the joint.
        entry: type, parent, child and origin of the joint.
        kind: SPHERICAL, FIXED, UJOINT_XY and so on.
        written: path of the kind's entry.

    Raises:
        DescriptionError: the kind is unknown, or a name is taken.
    """
    name = element.get("name")
    if kind == "FIXED":
        xml.add(("joints", name), {**entry, "type": "fixed"}, element)
        xml.document.notes.append(f"{name}: fixed at its zero")
        return
    letters = _axes(kind)
    if not letters:
        raise xml.document.error(written, f"is '{kind}'; expected {_EXPECTED}")
    parent = entry["parent"]
    origin = entry["origin"]
    for letter in letters[:-1]:
        link = f"{name}_{letter}"  # name of both link and joint
        xml.add(("links", link), {}, element)
        joint = _revolute(parent, link, origin, letter)
        xml.add(("joints", link), joint, element)
        parent = link
        origin = {}
    last_letter = letters[-1]
    joint = _revolute(parent, entry["child"], origin, last_letter)
    xml.add(("joints", f"{name}_{last_letter}"), joint, element)


def _axes(kind: str) -> str:
    """Letters of the axes about which a joint turns; empty for an unknown kind."""
    if kind == "SPHERICAL":
        return "XYZ"
    universal = _UNIVERSAL.match(kind)
    if universal is None or universal[1] == universal[2]:
        return ""
    return universal[1] + universal[2]


def _revolute(parent: str, child: str, origin: Data, letter: str) -> Data:
    return {
        "type": "revolute",
        "parent": parent,
        "child": child,
        "origin": origin,
        "axis": letter.lower(),
    }
