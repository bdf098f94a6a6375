"""Search for ROS packages without ROS, and the files that a robot file may refer to.

Packages are searched in folders around the file, then in AMENT_PREFIX_PATH, then in the search path
of the user.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from ..ground.regular_files import may_be_file, read_regular

SCHEME = "package://"
_MODEL_SCHEME = "model://"
_MODEL_FILES = ("model.config", "model.sdf")  # one of them makes a folder a model of SDFormat
_MODEL_FOLDERS = ("GZ_SIM_RESOURCE_PATH", "SDF_PATH", "GAZEBO_MODEL_PATH")
_MANIFEST = "package.xml"
_LARGEST_MANIFEST = 100_000  # [bytes] largest part that is read
_MAX_BESIDE = 2_000  # largest number of sibling folders that are searched
_TITLE = re.compile(rb"<name>\s*([\w.-]+)\s*</name>")
_VALID = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*")


class PackageError(Exception):
    """A package does not exist, or a file is out of reach; the message is a sentence."""


class Packages:
    """Finds packages for one file, and decides which files it may refer to.

    These are files below its folder, its package, the packages that it names, and the search path.
    """

    def __init__(self, file: Path, search_path: Iterable[str | Path] = ()) -> None:
        self.folder = Path(os.path.abspath(file)).parent  # noqa: PTH100 - links stay as they are
        self.search_path = [Path(folder).absolute() for folder in search_path]
        prefixes = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
        self.prefixes = [Path(prefix) for prefix in prefixes if prefix]
        self.package = self._enclosing_package()
        inside = {self.folder, self.package, file.resolve().parent, *self.search_path}
        self._roots = {folder.resolve() for folder in inside}
        self._sources: set[Path] = set()  # folders of packages that are not installed
        self._installed: set[Path] = set()  # folders with symlinks to their files

    def find(self, name: str) -> Path:
        """The folder of a package.

        Raises:
            PackageError: there is none; the message lists the searched folders.
        """
        if not _VALID.fullmatch(name):
            raise PackageError(f"'{name}' is no name of a package")
        for folder in self._candidates():
            if _is_package(folder, name):
                self._roots.add(folder.resolve())
                self._sources.add(folder)
                return folder
        for prefix in self.prefixes:
            installed = prefix / "share" / name
            if installed.is_dir():
                self._installed.add(installed)
                return installed
        for folder in self._in_search_path(name):
            if _is_package(folder, name):
                return folder
        raise PackageError(f"there is no package '{name}'; {self._searched()}")

    def find_model(self, name: str) -> Path:
        """The folder of an SDFormat model, beside or around the file; otherwise a package.

        Raises:
            PackageError: there is none; the message lists the searched folders.
        """
        if not _VALID.fullmatch(name):
            raise PackageError(f"'{name}' is no name of a model")
        around = [self.folder, *self.folder.parents][:-1]  # without the root folder
        listed: list[Path] = []
        for variable in _MODEL_FOLDERS:
            folders = os.environ.get(variable, "").split(os.pathsep)
            listed.extend(Path(folder) for folder in folders if folder)
        for folder in (*around, *listed, *self.search_path):
            for place in (folder / name, folder / "models" / name):
                if any(map(may_be_file, (place / file for file in _MODEL_FILES))):
                    self._roots.add(place.resolve())
                    return place
        return self.find(name)

    def resolve(self, uri: str, folder: Path | None = None) -> Path:
        """The file of `package://PACKAGE/PATH`, `file://PATH`, or a path from a folder.

        `model://NAME/PATH` is a file of a model of SDFormat.

        Args:
            uri: the URI or path in the file.
            folder: base of relative paths; None for the folder of the file.

        Raises:
            PackageError: there is no such package, or the file is out of reach.
        """
        path = Path(uri.removeprefix("file://"))
        if uri.startswith(SCHEME):
            name, _, inside = uri.removeprefix(SCHEME).partition("/")
            path = self.find(name) / inside
        if uri.startswith(_MODEL_SCHEME):
            name, _, inside = uri.removeprefix(_MODEL_SCHEME).partition("/")
            path = self.find_model(name) / inside
        path = (folder or self.folder) / path
        self.require(path)
        return path

    def require(self, path: Path) -> None:
        """Raise if the robot file may not refer to a file.

        Raises:
            PackageError: the file is not below an allowed folder.
        """
        plain = Path(os.path.abspath(path))  # noqa: PTH100 - links stay as they are
        if any(plain.is_relative_to(root) for root in self._installed):
            return
        real = path.resolve()
        if any(real.is_relative_to(root) for root in self._roots):
            return
        roots = ", ".join(sorted(map(str, self._roots)))
        raise PackageError(
            f"{path} is not below {roots}; what a robot file reads has to be in its folder, its"
            " package or the search path (search_path, --search-path)"
        )

    def before_installation(self, path: Path) -> Path | None:
        """The only file of a package that is installed to a path: the same below one more folder.

        `install(DIRECTORY description/urdf DESTINATION share/PACKAGE)` of CMake leaves out such a
        folder.

        Args:
            path: path in a package, without a file.
        """
        for package in (path.parent, *path.parent.parents):
            if package in self._sources or package == self.package:
                inside = path.relative_to(package)
                places = [folder / inside for folder in _folders_in(package)]
                there = [place for place in places if may_be_file(place)]
                return there[0] if len(there) == 1 else None
        return None

    def _enclosing_package(self) -> Path:
        """The nearest package folder around the file; otherwise the file's folder."""
        for folder in (self.folder, *self.folder.parents):
            if may_be_file(folder / _MANIFEST):
                return folder
        return self.folder

    def _candidates(self) -> Iterator[Path]:
        """Folders around the file, then those beside its package."""
        yield from (self.folder, *self.folder.parents)
        yield from _folders_in(self.package.parent)

    def _in_search_path(self, name: str) -> Iterator[Path]:
        for folder in self.search_path:
            yield folder
            yield folder / name
            yield from _folders_in(folder)

    def _searched(self) -> str:
        """Text on the searched folders, with advice."""
        prefixes = ", ".join(map(str, self.prefixes)) or "not set"
        folders = ", ".join(map(str, self.search_path)) or "none given"
        return (
            f"searched: folders around {self.folder}, folders beside {self.package},"
            f" AMENT_PREFIX_PATH ({prefixes}), search path ({folders}); give the folder in which it"
            " is as search_path or --search-path"
        )


def _folders_in(folder: Path) -> Iterator[Path]:
    try:
        entries = sorted(os.scandir(folder), key=lambda entry: entry.name)
    except OSError:
        return
    for entry in entries[:_MAX_BESIDE]:
        if entry.is_dir():
            yield Path(entry.path)


def _is_package(folder: Path, name: str) -> bool:
    """Whether a folder is a package by its package.xml or, without one, by its folder name."""
    manifest = folder / _MANIFEST
    if not manifest.exists():
        return folder.name == name and folder.is_dir()
    try:
        title = _TITLE.search(read_regular(manifest, _LARGEST_MANIFEST))
    except OSError:
        return False
    return title is not None and title[1].decode() == name
