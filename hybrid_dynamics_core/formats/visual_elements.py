"""What the formats share of visuals: their words, their names, and what files say of meshes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from ..description.document import Data, KeyPath
from ..description.geometry import Transform
from ..description.model import Frame, RobotDescription, Visual
from ..description.visuals.colours import colour_text
from ..description.visuals.read import SIZES
from .extras_reader import TAG
from .xml.located_xml import LocatedElement
from .xml.reader import XmlReader
from .xml.vocabulary import Vocabulary

ROD = f"{TAG}_rod"  # begins the names of rods that stand for links without visuals

_Omitted = tuple[LocatedElement, int]  # the first element of its words, and how many there are


class VisualWords:
    """Goes through the elements of visuals: what is not read is noted, and nothing refused.

    Args:
        xml: the file.
        table: what each element may hold, by its tag.
    """

    def __init__(self, xml: XmlReader, table: Mapping[str, Vocabulary]) -> None:
        self.xml = xml
        self.table = table
        self.omitted: dict[str, _Omitted] = {}

    def check(self, element: LocatedElement) -> None:
        """Keep the words of an element that are not read."""
        covered = self.table.get(element.tag)
        if covered is None:
            return
        for name in element.attributes:
            if name not in covered.attributes and not name.startswith("xmlns"):
                self.omit(element, f"{name} of <{element.tag}>")
        for child in element.children:
            if child.tag in (covered.elements or ()):
                self.check(child)
            else:
                self.omit(child, f"<{child.tag}> of <{element.tag}>")

    def omit(self, element: LocatedElement, words: str) -> None:
        """Keep words that are left out."""
        first, count = self.omitted.get(words, (element, 0))
        self.omitted[words] = first, count + 1

    def add_notes(self) -> None:
        """Say in the notes of the document what is left out."""
        for words, (element, count) in self.omitted.items():
            times = f", here and {count - 1} times more" if count > 1 else ""
            self.xml.note(element, f"{words} is left out{times}")
        self.omitted.clear()


def shape_entry(
    xml: XmlReader, element: LocatedElement, shape: str, sizes: Sequence[float], key: KeyPath
) -> Data:
    """A shape as a description has it.

    Args:
        xml: the file.
        element: that says it.
        shape: which one it is.
        sizes: of it, in order [m].
        key: of the visual, for messages.

    Raises:
        DescriptionError: a size is not above zero.
    """
    if not all(size > 0.0 for size in sizes):
        listed = ", ".join(f"{size:g}" for size in sizes)
        raise xml.error(element, key, f"{shape} of the sizes {listed}; a size is above zero")
    return {shape: sized(shape, sizes)}


def sized(shape: str, sizes: Sequence[float]) -> Data:
    """The sizes of a shape by their keys."""
    keys = SIZES[shape]
    if len(keys) == len(sizes):
        return dict(zip(keys, sizes, strict=True))
    return {keys[0]: list(sizes)}


def mesh_entry(file: str, scale: Iterable[float]) -> Data:
    """A mesh as a description has it; a scale of 1 is not said."""
    details: Data = {"file": file}
    factors = list(scale)
    if len(set(factors)) > 1:
        details["scale"] = factors
    elif factors[0] != 1.0:
        details["scale"] = factors[0]
    return {"mesh": details}


def clipped(xml: XmlReader, element: LocatedElement, colour: Sequence[float]) -> list[float]:
    """A colour with numbers from 0 to 1; a note says where others are given."""
    inside = [min(max(number, 0.0), 1.0) for number in colour]
    if inside != list(colour):
        listed = " ".join(f"{number:g}" for number in colour)
        xml.note(element, f"colour {listed}; numbers beyond 0 to 1 are taken as 0 or 1")
    return inside


# -- for writers


def mesh_uri(
    visual: Visual, folder: Path | None, schemes: tuple[str, ...] = (), prefix: str = ""
) -> str:
    """What a file says of a mesh.

    Args:
        visual: the mesh.
        folder: of the file, in which and below which meshes are named by their path from there.
        schemes: beginnings that are written as they are, such as package://.
        prefix: before a whole path, such as file://.
    """
    file = visual.file
    if file is None or (schemes and visual.uri.startswith(schemes)):
        return visual.uri
    if folder is not None:
        root = folder.absolute().resolve()
        if file.resolve().is_relative_to(root):
            return file.resolve().relative_to(root).as_posix()
    return f"{prefix}{file}"


def visual_entry(visual: Visual, folder: Path | None) -> Data:
    """Shape and colour of a visual as a description has them."""
    if visual.uri:
        schemes = ("package://", "model://")
        entry = mesh_entry(mesh_uri(visual, folder, schemes), visual.size)
    else:
        entry = {visual.shape: sized(visual.shape, visual.size)}
    if visual.colour is not None:
        entry["colour"] = colour_text(visual.colour)
    return entry


def visual_entries(robot: RobotDescription, link: str, folder: Path | None) -> list[Data]:
    """All that moves with a link as a description has it, with poses of every digit."""
    entries: list[Data] = []
    for visual in robot.visuals_on(link):
        entry = visual_entry(visual, folder)
        if not is_at_origin(visual.frame):
            rows = visual.frame.rotation.tolist()
            entry["origin"] = {"xyz": visual.frame.translation.tolist(), "matrix": rows}
        entries.append(entry)
    return entries


def is_at_origin(frame: Frame) -> bool:
    """Whether a frame is that of its link."""
    return Transform(frame.rotation, frame.translation).is_identity()
