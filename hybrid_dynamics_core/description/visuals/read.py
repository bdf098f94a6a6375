"""Reader of visuals of links: each has a shape, sizes, a pose on the link and a colour."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import cast, get_args

import numpy as np

from ..attached_frames import AttachedFrames
from ..entries import Entry
from ..model import Colour, Visual, VisualShape
from .colours import colour_from_numbers, colour_from_text

SIZES: Mapping[str, tuple[str, ...]] = {  # by shape: keys of its sizes
    "box": ("size",),
    "cylinder": ("radius", "length"),
    "sphere": ("radius",),
    "capsule": ("radius", "length"),
    "ellipsoid": ("radii",),
}
_SHAPES = get_args(VisualShape)


def read_visuals(
    links: Mapping[str, Entry], attached: AttachedFrames
) -> Mapping[str, tuple[Visual, ...]]:
    """The visuals by moving link; those on fixed links are moved to the links that carry them.

    Raises:
        DescriptionError: an entry has no shape or several, or a size that is not positive.
    """
    visuals: dict[str, tuple[Visual, ...]] = {}
    for name, link in links.items():
        entries = _entries_of(link)
        of_link = tuple(_visual(name, entry, attached) for entry in entries)
        if of_link:
            visuals[name] = of_link
    return MappingProxyType(visuals)


def _entries_of(link: Entry) -> Iterator[Entry]:
    for k, data in enumerate(link.get("visuals") or []):
        yield Entry(link.values, data, (*link.path, "visuals", k))


def _visual(link: str, entry: Entry, attached: AttachedFrames) -> Visual:
    shapes = [shape for shape in _SHAPES if shape in entry]
    if len(shapes) != 1:
        listed = ", ".join(shapes) or "no shape"
        problem = f"has {listed}; expected one of {', '.join(_SHAPES)}"
        raise entry.values.document.error(entry.path, problem)
    shape = cast(VisualShape, shapes[0])
    details = entry.sub(shape)
    frame = attached.frame(link, entry.pose("origin"))
    colour = _colour(entry)
    if shape == "mesh":
        return Visual(shape, _scale(details), frame, colour, details["file"])
    return Visual(shape, _sizes(details, SIZES[shape]), frame, colour)


def _sizes(details: Entry, keys: tuple[str, ...]) -> tuple[float, ...]:
    sizes: list[float] = []
    for key in keys:
        value = details[key]
        values = value if isinstance(value, list) else [value]
        for k, number in enumerate(values):
            path = details.key_path(key)
            if isinstance(value, list):
                path = (*path, k)
            sizes.append(details.values.length(number, path))
    return tuple(sizes)


def _scale(details: Entry) -> tuple[float, ...]:
    """The scale (3,) of a mesh along x, y, z; one number holds for all."""
    value = details.get("scale", 1.0)
    path = details.key_path("scale")
    if isinstance(value, list):
        scale = details.values.vector(value, path)
    else:
        scale = np.full(3, details.values.number(value, path))
    if not scale.all():
        raise details.error("scale", "is 0 along an axis; a scale is another number than zero")
    return tuple(scale.tolist())


def _colour(entry: Entry) -> Colour | None:
    value = entry.get("colour")
    if value is None:
        return None
    try:
        if isinstance(value, str):
            return colour_from_text(value)
        return colour_from_numbers(entry.vector("colour").tolist())
    except ValueError as error:
        raise entry.error("colour", str(error)) from error
