"""Reader of visuals in SDFormat."""

from __future__ import annotations

from ...description.document import Data, KeyPath
from ...description.geometry import Transform
from ...errors import DescriptionError
from ..visual_elements import ROD, VisualWords, clipped, mesh_entry, shape_entry
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from ..xml.vocabulary import vocabulary
from .poses import ModelPoses, pose_entry

_ROUND = vocabulary("", "radius length")
_SHAPES = "box cylinder sphere capsule ellipsoid mesh"
_WORDS = {
    "visual": vocabulary("name", "pose geometry material transparency"),
    "pose": vocabulary("relative_to rotation_format degrees frame"),
    "geometry": vocabulary("", f"{_SHAPES} empty"),
    "box": vocabulary("", "size"),
    "cylinder": _ROUND,
    "sphere": vocabulary("", "radius"),
    "capsule": _ROUND,
    "ellipsoid": vocabulary("", "radii"),
    "mesh": vocabulary("", "uri scale submesh"),
    "material": vocabulary("", "diffuse ambient"),
}
_SIZES = {  # by shape: its size elements, with their count of numbers
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
    "capsule": {"radius": 1, "length": 1},
    "ellipsoid": {"radii": 3},
}


class VisualReader:
    """Reader of the visuals of links. A wrong one is noted, since it has no mechanics."""

    def __init__(self, xml: XmlReader, poses: ModelPoses) -> None:
        self.xml = xml
        self.poses = poses
        self.words = VisualWords(xml, _WORDS)

    def entries(self, link: LocatedElement, path: KeyPath) -> list[Data]:
        """The visuals of a link as entries of a description."""
        entries: list[Data] = []
        for visual in link.all("visual"):
            if visual.get("name").startswith(ROD):
                continue
            key = (*path, "visuals", len(entries))
            try:
                entries.append(self.entry(visual, link.get("name"), key))
            except DescriptionError as error:
                self.xml.note(visual, f"<visual> is left out: {error.problem}")
                continue
            self.xml.locate(key, visual)
            self.words.check(visual)
        return entries

    def entry(self, visual: LocatedElement, link: str, key: KeyPath) -> Data:
        """A visual of a link as an entry of a description.

        Raises:
            DescriptionError: it has no shape, or a wrong value.
        """
        geometry = visual.first("geometry")
        shapes = []
        if geometry is not None:
            shapes = [child for child in geometry.children if child.tag in _WORDS]
        if not shapes:
            raise self.xml.error(visual, key, f"no shape; expected one of {_SHAPES}")
        entry = self.shape(shapes[0], key)
        pose = self.pose(visual.first("pose"), link, key)
        if not pose.is_identity():
            entry["origin"] = pose_entry(pose)
        colour = self.colour(visual, key)
        if colour is not None:
            entry["colour"] = colour
        return entry

    def pose(self, element: LocatedElement | None, link: str, key: KeyPath) -> Transform:
        """The pose of a visual on its link."""
        pose = self.poses.read(element, key)
        if element is None or not element.get("relative_to"):
            return pose
        frame = self.poses.resolve(element.get("relative_to"), element)
        return self.poses.in_link(link, frame @ pose)

    def shape(self, element: LocatedElement, key: KeyPath) -> Data:
        """The shape in a <geometry>."""
        if element.tag == "mesh":
            return self.mesh(element, key)
        sizes: list[float] = []
        for tag, number in _SIZES[element.tag].items():
            sizes.extend(self.xml.text_numbers(element.first(tag), number, key, ()))
        if not sizes:
            raise self.xml.error(element, key, f"<{element.tag}> has no size")
        return shape_entry(self.xml, element, element.tag, sizes, key)

    def mesh(self, element: LocatedElement, key: KeyPath) -> Data:
        """A <mesh> as an entry, with its file and scale."""
        uri = element.first("uri")
        if uri is None or not uri.text.strip():
            raise self.xml.error(element, key, "<mesh> has no <uri>")
        if element.first("submesh") is not None:
            raise self.xml.error(element, key, "<submesh>: a part of a mesh is not shown")
        ones = (1.0, 1.0, 1.0)
        scale = self.xml.text_numbers(element.first("scale"), 3, key, ones)
        if not all(scale):
            raise self.xml.error(element, key, "<mesh> has a scale of 0")
        return mesh_entry(uri.text.strip(), scale)

    def colour(self, visual: LocatedElement, key: KeyPath) -> list[float] | None:
        """The diffuse colour of a material, or else the ambient one; None if it has neither."""
        material = visual.first("material")
        if material is None:
            return None
        element = material.first("diffuse") or material.first("ambient")
        if element is None:
            return None
        text = element.text
        if len(text.split()) == 3:  # the opacity is optional
            element.text = f"{text} 1"
        colour = clipped(self.xml, element, self.xml.text_numbers(element, 4, key, ()))
        transparency = self.xml.text_number(visual.first("transparency"), key, 0.0)
        if colour[3] == 1.0:
            (colour[3],) = clipped(self.xml, visual, [1.0 - transparency])
        return colour
