"""Flexes (deformable bodies) of MJCF, left out if not attached to moving bodies."""

from __future__ import annotations

from ...xml.located_xml import LocatedElement
from ...xml.reader import XmlReader

FLEX = "flexcomp"
_JOINTS = ("joint", "freejoint")


def leave_out_flexes(xml: XmlReader) -> list[LocatedElement]:
    """Remove flexes on fixed bodies, which affect the robot only by contacts.

    Args:
        xml: the file, with includes inserted.

    Returns:
        The removed elements; each has a note.

    Raises:
        DescriptionError: a flex is attached to a moving body, on which it would exert forces.
    """
    flexes: list[LocatedElement] = []
    for world in xml.root.all("worldbody"):
        _take_out(xml, world, False, flexes)
    if flexes:
        _take_out_keyframes(xml)
    return flexes


def _take_out(
    xml: XmlReader, element: LocatedElement, is_moving: bool, flexes: list[LocatedElement]
) -> None:
    is_moving = is_moving or any(element.first(tag) for tag in _JOINTS)
    kept: list[LocatedElement] = []
    for child in element.children:
        if child.tag != FLEX:
            _take_out(xml, child, is_moving, flexes)
            kept.append(child)
            continue
        name = child.get("name") or FLEX
        if is_moving:
            problem = (
                "is fixed to a body that moves, which it loads and pulls; a flex is no rigid body:"
                " take it out, or fix it to the world"
            )
            raise xml.error(child, ("flexes", name), problem)
        xml.note(child, f"<{FLEX}> {name} is left out: a flex is no rigid body")
        flexes.append(child)
    element.children = kept


def _take_out_keyframes(xml: XmlReader) -> None:
    """Remove keyframes, since they contain coordinates of flexes too."""
    for keyframe in xml.root.all("keyframe"):
        xml.note(keyframe, "<keyframe> is left out: it has coordinates of a flex")
    xml.root.children = [child for child in xml.root.children if child.tag != "keyframe"]
