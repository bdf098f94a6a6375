"""Search for mesh files, without opening them.

A mesh that cannot be shown is noted. It is no error, since meshes do not affect the mechanics.
"""

from __future__ import annotations

import stat
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Final

from ..description.document import Document, KeyPath
from ..description.model import RobotDescription, Visual
from ..ground.regular_files import answered_in_time
from .packages import PackageError, Packages

MAX_BYTES: Final = 50_000_000  # of one mesh
SUFFIXES: Final = (".stl", ".obj", ".dae", ".glb", ".gltf")
_SCHEMES = ("package://", "model://", "file://")
_MAX_LISTED = 5  # meshes in a note


def with_mesh_files(document: Document, robot: RobotDescription) -> RobotDescription:
    """The robot with paths of its mesh files, and notes on meshes that are not shown.

    Args:
        document: the document, with locations of its entries.
        robot: the robot of the document.
    """
    has_meshes = any(visual.uri for visuals in robot.visuals.values() for visual in visuals)
    if not has_meshes:
        return robot
    finder = _Finder(document)
    visuals: dict[str, tuple[Visual, ...]] = {}
    for link, of_link in robot.visuals.items():
        placed: list[Visual] = []
        for k, visual in enumerate(of_link):
            path = ("links", link, "visuals", k)
            file = finder.file(visual.uri, path) if visual.uri else None
            placed.append(replace(visual, file=file))
        visuals[link] = tuple(placed)
    notes = (*robot.notes, *finder.notes())
    return replace(robot, visuals=MappingProxyType(visuals), notes=notes)


class _Finder:
    """Finds mesh files, and collects reasons for meshes that are not shown."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.main = Path(document.file or "robot.yaml")
        self.packages = Packages(self.main, document.options.search_path)
        self.folders: dict[str, Path | PackageError] = {}  # folders of packages and models
        self.reasons: dict[str, list[str]] = {}  # by reason: meshes that are not shown

    def file(self, uri: str, path: KeyPath) -> Path | None:
        """The file of a mesh; None if it is not shown."""
        source, line = self.document.location(path)
        source_file = Path(source or self.main)
        try:
            file = self.resolved(uri, source_file)
            reason = reason_against(file)
        except (PackageError, OSError, RuntimeError, ValueError) as error:
            file = None
            reason = getattr(error, "strerror", None) or str(error)
        if not reason:
            return file
        place = f"line {line}"
        if source_file != self.main:
            place += f" of {source_file.name}"
        self.reasons.setdefault(reason, []).append(f"{uri} ({place})")
        return None

    def resolved(self, uri: str, source: Path) -> Path:
        """The path of a file, relative to the file that names it, or else to the main file.

        Raises:
            PackageError: the file must not be read.
        """
        scheme, separator, inside = uri.partition("://")
        if not separator:
            file = self.packages.resolve(uri, source.absolute().parent)
            if file.exists():
                return file
            return self.packages.resolve(uri)
        if not uri.startswith(_SCHEMES):
            raise PackageError(f"nothing is fetched by {scheme}://")
        if scheme == "file":
            return self.packages.resolve(uri)
        name, _, path = inside.partition("/")
        file = self.folder(f"{scheme}://{name}") / path
        self.packages.require(file)
        return file

    def folder(self, uri: str) -> Path:
        """The folder of a package or model, cached.

        Raises:
            PackageError: the package or model was not found.
        """
        if uri not in self.folders:
            try:
                self.folders[uri] = self.packages.resolve(uri)
            except PackageError as error:
                self.folders[uri] = error
        folder = self.folders[uri]
        if isinstance(folder, PackageError):
            raise folder
        return folder

    def notes(self) -> list[str]:
        """A note for each reason, with its meshes."""
        notes: list[str] = []
        for reason, meshes in self.reasons.items():
            listed = ", ".join(meshes[:_MAX_LISTED])
            if len(meshes) > _MAX_LISTED:
                listed += f" and {len(meshes) - _MAX_LISTED} more"
            notes.append(f"{self.main.name}: meshes are not shown: {listed}: {reason}")
        return notes


def reason_against(file: Path) -> str:
    """The reason against a file as a mesh, by its name, kind and size; empty if it is accepted.

    Raises:
        OSError: the file system does not respond.
    """
    try:
        status = answered_in_time(file.stat)
    except (FileNotFoundError, NotADirectoryError):
        return "there is no such file"
    if not stat.S_ISREG(status.st_mode):
        return "a folder, pipe or device; expected a regular file"
    if status.st_size > MAX_BYTES:
        return f"{status.st_size} bytes; a mesh has at most {MAX_BYTES}"
    if file.suffix.lower() not in SUFFIXES:
        return f"not one of {', '.join(SUFFIXES)}, and archives are not opened"
    return ""
