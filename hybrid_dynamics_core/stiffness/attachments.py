"""Places on links where something is attached: joints, closures, frames and masses."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from ..description.model import RobotDescription
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.suggestions import no_such_name

Key = tuple[str, str]  # kind and name of a place

MASS: Final[Key] = ("mass", "")


def places_on(description: RobotDescription, link: str) -> dict[Key, Array]:
    """Places (3,) on a link, in its frame [m]."""
    places: dict[Key, Array] = {}
    for joint in description.joints.values():
        if joint.parent == link:
            places["joint", joint.name] = joint.translation
    for closure in description.closures:
        for frame in closure.frames():
            if frame.link == link:
                places["closure", closure.name] = frame.translation
    places |= _frames_on(description, link)
    if link in description.links:
        places[MASS] = description.links[link].com
    return places


def _frames_on(description: RobotDescription, link: str) -> dict[Key, Array]:
    places: dict[Key, Array] = {}
    for name, frame in description.frames.items():
        if frame.link == link:
            places["frame", name] = frame.translation
    return places


def point_on(places: Mapping[Key, Array], place: object, link: str) -> Array:
    """A place on a link (3,), in its frame [m].

    Args:
        places: places on the link.
        place: name of a joint, closure or frame, or a point (3,).
        link: name of the link, for messages.

    Raises:
        InputError: nothing on the link has this name.
    """
    if not isinstance(place, str):
        point: Array = np.asarray(place, dtype=float)
        return point
    for kind in ("joint", "closure", "frame"):
        key = (kind, place)
        if key in places:
            return places[key]
    names = [name for _, name in places if name]
    raise InputError(f"links.{link}: {no_such_name(f'place on {link}', place, names)}")
