"""Reader of visuals in URDF; by their names, substitute shapes are read as the original ones."""

from __future__ import annotations

from dataclasses import replace

from ...description.document import Data, KeyPath
from ...errors import DescriptionError
from ..extras_reader import TAG
from ..visual_elements import ROD, VisualWords, clipped, mesh_entry, shape_entry
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from ..xml.vocabulary import vocabulary

CAPSULE = f"{TAG}_capsule"  # prefix of names of visuals
CAP = f"{TAG}_cap"
ELLIPSOID = f"{TAG}_ellipsoid"

_SHAPES = "box cylinder sphere capsule mesh drake:capsule drake:ellipsoid"
_ROUND = vocabulary("radius length")
WORDS = {
    "visual": vocabulary("name", "origin geometry material"),
    "origin": vocabulary("xyz rpy quat_xyzw"),
    "geometry": vocabulary("", _SHAPES),
    "box": vocabulary("size"),
    "cylinder": _ROUND,
    "sphere": vocabulary("radius"),
    "capsule": _ROUND,
    "mesh": vocabulary("filename scale"),
    "drake:capsule": _ROUND,
    "drake:ellipsoid": vocabulary("a b c"),
    "material": vocabulary("name", "color"),
    "color": vocabulary("rgba"),
}
_SIZES = {  # by shape: its size attributes, with their count of numbers
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
    "capsule": {"radius": 1, "length": 1},
    "drake:capsule": {"radius": 1, "length": 1},
    "drake:ellipsoid": {"a": 1, "b": 1, "c": 1},
}


class VisualReader:
    """Reader of the visuals of links. A wrong one is noted, since it has no mechanics."""

    def __init__(self, xml: XmlReader) -> None:
        self.xml = xml
        self.words = VisualWords(xml, WORDS)
        self.materials: dict[str, LocatedElement] = {}
        for material in xml.root.all("material"):
            self.words.check(material)
            self.materials.setdefault(material.get("name"), material)

    def entries(self, link: LocatedElement, path: KeyPath) -> list[Data]:
        """The visuals of a link as entries of a description."""
        entries: list[Data] = []
        for visual in link.all("visual"):
            if visual.get("name").startswith((ROD, CAP + "_")):
                continue
            key = (*path, "visuals", len(entries))
            try:
                entries.append(self.entry(visual, key))
            except DescriptionError as error:
                self.xml.note(visual, f"<visual> is left out: {error.problem}")
                continue
            self.xml.locate(key, visual)
            self.words.check(visual)
        return entries

    def entry(self, visual: LocatedElement, key: KeyPath) -> Data:
        """A visual as an entry of a description.

        Raises:
            DescriptionError: it has no shape, or a wrong value.
        """
        geometry = visual.first("geometry")
        shapes = []
        if geometry is not None:
            shapes = [child for child in geometry.children if child.tag in WORDS]
        if not shapes:
            raise self.xml.error(visual, key, f"no shape; expected one of {_SHAPES}")
        entry = self.shape(shapes[0], key)
        entry = self.original(visual, entry, key)
        if visual.first("origin") is not None:
            entry["origin"] = self.xml.origin(visual, key)
        colour = self.colour(visual.first("material"), key)
        if colour is not None:
            entry["colour"] = colour
        return entry

    def shape(self, element: LocatedElement, key: KeyPath) -> Data:
        """The shape in a <geometry>."""
        if element.tag == "mesh":
            file = element.get("filename").strip()
            if not file:
                raise self.xml.error(element, key, "<mesh> has no filename")
            scale = self.xml.numbers(element, "scale", 3, key, (1.0, 1.0, 1.0))
            if not all(scale):
                raise self.xml.error(element, key, "<mesh> has a scale of 0")
            return mesh_entry(file, scale)
        sizes: list[float] = []
        for attribute, number in _SIZES[element.tag].items():
            sizes.extend(self.xml.numbers(element, attribute, number, key))
        shape = element.tag.rpartition(":")[2]
        return shape_entry(self.xml, element, shape, sizes, key)

    def original(self, visual: LocatedElement, entry: Data, key: KeyPath) -> Data:
        """The original of a substitute shape, by its name."""
        name = visual.get("name")
        if name.startswith(CAPSULE) and "cylinder" in entry:
            return {"capsule": entry["cylinder"]}
        if name.startswith(f"{ELLIPSOID} "):
            numbers = " ".join(name.split()[1:4])
            named = replace(visual, attributes={"name": numbers})
            radii = self.xml.numbers(named, "name", 3, key)
            return shape_entry(self.xml, visual, "ellipsoid", radii, key)
        return entry

    def colour(self, material: LocatedElement | None, key: KeyPath) -> list[float] | None:
        """The colour of a material, given here or at the root; None if it has none."""
        if material is None:
            return None
        color = material.first("color")
        if color is None:
            material = self.materials.get(material.get("name"), material)
            color = material.first("color")
        if color is None:
            return None
        return clipped(self.xml, color, self.xml.numbers(color, "rgba", 4, key))
