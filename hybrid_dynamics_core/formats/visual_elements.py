"""Functions for visuals shared by the formats: vocabulary, names, and URIs of meshes."""

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

ROD = f"{TAG}_rod"  # prefix of names of rods, which represent links without visuals

_Omitted = tuple[LocatedElement, int]  # the first element, and the number of elements


class VisualWords:
    """Checks the words in elements of visuals. Unknown ones are noted, none is refused.

    Args:
        xml: the file.
        table: by tag: vocabulary of the element.
    """

    def __init__(self, xml: XmlReader, table: Mapping[str, Vocabulary]) -> None:
        self.xml = xml
        self.table = table
        self.omitted: dict[str, _Omitted] = {}

    def check(self, element: LocatedElement) -> None:
        """Collect the words of an element that are not read."""
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
        """Collect words that are left out."""
        first, count = self.omitted.get(words, (element, 0))
        self.omitted[words] = first, count + 1

    def add_notes(self) -> None:
        """Add notes on the collected words to the document."""
        for words, (element, count) in self.omitted.items():
            times = f", here and {count - 1} times more" if count > 1 else ""
            self.xml.note(element, f"{words} is left out{times}")
        self.omitted.clear()


def shape_entry(
    xml: XmlReader, element: LocatedElement, shape: str, sizes: Sequence[float], key: KeyPath
) -> Data:
    """A shape as an entry of a description.

    Args:
        xml: the file.
        element: element of the shape.
        shape: kind of the shape.
        sizes: its sizes in order [m].
        key: key of the visual, for messages.

    Raises:
        DescriptionError: a size is not positive.
    """
    if not all(size > 0.0 for size in sizes):
        listed = ", ".join(f"{size:g}" for size in sizes)
        raise xml.error(element, key, f"{shape} of the sizes {listed}; a size is above zero")
    return {shape: sized(shape, sizes)}


def sized(shape: str, sizes: Sequence[float]) -> Data:
    """The sizes of a shape by key."""
    keys = SIZES[shape]
    if len(keys) == len(sizes):
        return dict(zip(keys, sizes, strict=True))
    return {keys[0]: list(sizes)}


def mesh_entry(file: str, scale: Iterable[float]) -> Data:
    """A mesh as an entry of a description; a scale of 1 is omitted."""
    details: Data = {"file": file}
    factors = list(scale)
    if len(set(factors)) > 1:
        details["scale"] = factors
    elif factors[0] != 1.0:
        details["scale"] = factors[0]
    return {"mesh": details}


def clipped(xml: XmlReader, element: LocatedElement, colour: Sequence[float]) -> list[float]:
    """A colour clipped to numbers from 0 to 1, with a note if it was changed."""
    inside = [min(max(number, 0.0), 1.0) for number in colour]
    if inside != list(colour):
        listed = " ".join(f"{number:g}" for number in colour)
        xml.note(element, f"colour {listed}; numbers beyond 0 to 1 are taken as 0 or 1")
    return inside


# -- for writers


def mesh_uri(
    visual: Visual, folder: Path | None, schemes: tuple[str, ...] = (), prefix: str = ""
) -> str:
    """The URI of a mesh in a file.

    Args:
        visual: the mesh.
        folder: folder of the file; meshes in or below it get relative paths.
        schemes: prefixes of URIs that are written unchanged, such as package://.
        prefix: prefix of absolute paths, such as file://.
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
    """Shape and colour of a visual as an entry of a description."""
    if visual.uri:
        schemes = ("package://", "model://")
        entry = mesh_entry(mesh_uri(visual, folder, schemes), visual.size)
    else:
        entry = {visual.shape: sized(visual.shape, visual.size)}
    if visual.colour is not None:
        entry["colour"] = colour_text(visual.colour)
    return entry


def visual_entries(robot: RobotDescription, link: str, folder: Path | None) -> list[Data]:
    """All visuals that move with a link as entries of a description, with full precision."""
    entries: list[Data] = []
    for visual in robot.visuals_on(link):
        entry = visual_entry(visual, folder)
        if not is_at_origin(visual.frame):
            rows = visual.frame.rotation.tolist()
            entry["origin"] = {"xyz": visual.frame.translation.tolist(), "matrix": rows}
        entries.append(entry)
    return entries


def is_at_origin(frame: Frame) -> bool:
    """Whether a frame coincides with that of its link."""
    return Transform(frame.rotation, frame.translation).is_identity()
