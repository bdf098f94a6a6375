"""Files that an MJCF file includes: their content stands in place of <include>, as in MuJoCo."""

from __future__ import annotations

from pathlib import Path

from ...ground.regular_files import may_be_file
from ..xml.located_xml import LocatedElement, read_xml
from ..xml.reader import XmlReader

_ROOTS = ("mujoco", "mujocoinclude")


def open_includes(xml: XmlReader) -> None:
    """Put the content of included files in place of every <include>.

    Paths start at the folder of the first file. A file is included once.

    Raises:
        DescriptionError: a file is not there, is included twice, or is no MJCF.
    """
    _open_inside(xml, xml.root, {xml.file.resolve()})


def _open_inside(xml: XmlReader, element: LocatedElement, opened: set[Path]) -> None:
    children: list[LocatedElement] = []
    for child in element.children:
        if child.tag == "include":
            root = _included(xml, child, opened)
            _open_inside(xml, root, opened)
            children.extend(root.children)
        else:
            _open_inside(xml, child, opened)
            children.append(child)
    element.children = children


def _included(xml: XmlReader, include: LocatedElement, opened: set[Path]) -> LocatedElement:
    """The root of an included file."""
    name = include.get("file")
    file = xml.file.parent / name
    if not may_be_file(file):
        problem = f"includes '{name}', which is not there; paths start at {xml.file.parent}"
        raise xml.error(include, ("include",), problem)
    if file.resolve() in opened:
        raise xml.error(include, ("include",), f"includes '{name}', which is included already")
    opened.add(file.resolve())
    root = read_xml(file)
    if root.tag not in _ROOTS:
        problem = f"includes '{name}', whose root is <{root.tag}>; expected <mujoco>"
        raise xml.error(include, ("include",), problem)
    return root
