"""Included files of MJCF: their content replaces <include>, as in MuJoCo."""

from __future__ import annotations

from pathlib import Path

from ...ground.regular_files import may_be_file
from ..packages import PackageError, Packages
from ..xml.located_xml import MAX_DEPTH, MAX_ELEMENTS, LocatedElement, read_xml
from ..xml.reader import XmlReader

_ROOTS = ("mujoco", "mujocoinclude")
_MAX_FILES = 500


def open_includes(xml: XmlReader, packages: Packages) -> None:
    """Replace every <include> by the content of its file.

    Paths are relative to the including file or to the first file. A file may be included only once.

    Args:
        xml: the first file.
        packages: decides which files may be read.

    Raises:
        DescriptionError: a file is missing, out of reach, included twice, or no MJCF.
    """
    _Includes(xml, packages).open_inside(xml.root, xml.file.parent)


class _Includes:
    def __init__(self, xml: XmlReader, packages: Packages) -> None:
        self.xml = xml
        self.packages = packages
        self.opened = {xml.file.resolve()}
        self.count = 0

    def open_inside(self, element: LocatedElement, folder: Path, depth: int = 1) -> None:
        children: list[LocatedElement] = []
        for child in element.children:
            self.require_size(child, depth)
            if child.tag == "include":
                root, inner = self.included(child, folder)
                self.open_inside(root, inner, depth)
                children.extend(root.children)
            else:
                self.open_inside(child, folder, depth + 1)
                children.append(child)
        element.children = children

    def require_size(self, element: LocatedElement, depth: int) -> None:
        self.count += 1
        if self.count > MAX_ELEMENTS or depth >= MAX_DEPTH or len(self.opened) > _MAX_FILES:
            raise self.xml.error(element, ("include",), "too many elements or files for a robot")

    def included(self, include: LocatedElement, folder: Path) -> tuple[LocatedElement, Path]:
        """The root of an included file, and its folder."""
        name = include.get("file")
        file = self.file(include, name, folder)
        if file.resolve() in self.opened:
            problem = f"includes '{name}', which is included already"
            raise self.xml.error(include, ("include",), problem)
        self.opened.add(file.resolve())
        root = read_xml(file)
        if root.tag not in _ROOTS:
            problem = f"includes '{name}', whose root is <{root.tag}>; expected <mujoco>"
            raise self.xml.error(include, ("include",), problem)
        return root, file.parent

    def file(self, include: LocatedElement, name: str, folder: Path) -> Path:
        for start in dict.fromkeys((folder, self.xml.file.parent)):
            file = start / name
            try:
                self.packages.require(file)
            except PackageError as error:
                raise self.xml.error(include, ("include",), f"includes {error}") from error
            if may_be_file(file):
                return file
        problem = f"includes '{name}', which is not there; paths start at {self.xml.file.parent}"
        raise self.xml.error(include, ("include",), problem)
