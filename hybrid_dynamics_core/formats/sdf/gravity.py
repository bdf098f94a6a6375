"""Gravity of an SDFormat model: that of its world, unless links switch it off."""

from __future__ import annotations

import numpy as np

from ...description.document import Document
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .poses import WORLD, ModelPoses

_GRAVITY = (0.0, 0.0, -9.8)  # [m/s^2] default of SDFormat
_STANDARD_GRAVITY = (0.0, 0.0, -9.81)
_NO = ("false", "0")


def gravity_entry(
    xml: XmlReader, poses: ModelPoses, model: LocatedElement, world: LocatedElement | None
) -> list[float]:
    """Gravity (3,) [m/s^2] in the base frame, which may be tilted in the world.

    Args:
        xml: the file, whose links and joints are in the document.
        poses: poses of the model.
        model: the model.
        world: the world, or None.
    """
    base = xml.document.data["base"]
    rotation = np.eye(3)
    if base != WORLD:
        rotation = poses.model.rotation @ poses.link(base).rotation
    gravity = _of_world(xml, world)
    if any(gravity) and _is_switched_off(xml, model):
        gravity = [0.0, 0.0, 0.0]
    in_base = rotation.T @ gravity + 0.0  # no minus zero
    entry: list[float] = in_base.tolist()
    return entry


def _of_world(xml: XmlReader, world: LocatedElement | None) -> list[float]:
    """Gravity (3,) in the world [m/s^2]; the default for a model without a world."""
    if world is None:
        return list(_STANDARD_GRAVITY)
    element = world.first("gravity")
    physics = world.first("physics")
    if element is None and physics is not None:
        element = physics.first("gravity")  # its place in older files
    return xml.text_numbers(element, 3, ("gravity",), _GRAVITY)


def _is_switched_off(xml: XmlReader, model: LocatedElement) -> bool:
    """Whether gravity acts on no link that moves; where on some, others get no weight."""
    links = xml.document.section("links")
    moving = _moving_links(xml.document)
    without: dict[str, LocatedElement] = {}
    is_felt = False
    for link in model.all("link"):
        name = link.get("name")
        word = link.first("gravity")
        is_off = word is not None and word.text.strip().lower() in _NO
        has_weight = name in moving and bool(links[name].get("mass"))
        if word is not None and is_off and has_weight:
            without[name] = word
        elif word is not None and is_off:
            xml.note(word, f"<gravity> of {name} is left out: nothing of it is lifted")
        elif has_weight:
            is_felt = True
    if is_felt:
        for name, word in without.items():
            links[name]["gravity_compensation"] = 1.0
            xml.note(word, f"<gravity> of {name} is off: its weight is not felt")
        return False
    for word in list(without.values())[:1]:
        xml.note(word, "<gravity> of all links that move is off; there is no gravity")
    return bool(without)


def _moving_links(document: Document) -> set[str]:
    """The links that a joint moves."""
    moving: set[str] = set()
    joints = list(document.section("joints").values())
    reached = {document.data["base"]}
    while True:
        steps = [joint for joint in joints if joint["parent"] in reached]
        steps = [joint for joint in steps if joint["child"] not in reached]
        if not steps:
            return moving
        for joint in steps:
            reached.add(joint["child"])
            if joint["type"] != "fixed" or joint["parent"] in moving:
                moving.add(joint["child"])
