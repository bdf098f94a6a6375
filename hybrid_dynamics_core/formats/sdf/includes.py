"""Included files of SDFormat: their model replaces <include>.

A URI names a folder with a model.config, or a file: model://NAME, model://NAME/PATH, or a relative
path. Nothing is downloaded.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from ...errors import DescriptionError
from ...ground.file_options import FileOptions
from ...ground.regular_files import may_be_file
from ..packages import PackageError, Packages
from ..xml.located_xml import MAX_ELEMENTS, LocatedElement, read_xml
from ..xml.reader import XmlReader
from .nesting import MERGE
from .versions import CONVERT, ROOTS, read_version, upgrade
from .vocabulary import INCLUDE, check_model, check_words

_MAX_FILES = 500
_SCHEMES = ("model://", "package://", "file://")
_CONFIG = "model.config"
_YES = ("true", "1")
_REPLACED = ("name", "pose", "static")
_LOCAL = (
    "expected model://NAME of a folder beside the file or on the search path (search_path,"
    " --search-path), or a path from the file"
)


class Includes:
    """Opens the includes of a file, recursively."""

    def __init__(self, xml: XmlReader, options: FileOptions) -> None:
        self.xml = xml
        self.packages = Packages(xml.file, options.search_path)
        self.missing: list[str] = []  # includes of the world that are out of reach
        self.opened: list[LocatedElement] = []  # models from other files
        self._size = 0

    def open_world(self, world: LocatedElement) -> None:
        """Replace the includes of a world by their models; missing ones are noted."""
        children: list[LocatedElement] = []
        for child in world.children:
            if child.tag != "include":
                children.append(child)
                continue
            try:
                children.append(self._included(child, (self.xml.file,)))
            except (_OutOfReachError, DescriptionError) as error:
                self.missing.append(str(error))
                self.xml.note(child, f"<include> is left out: {error}")
        world.children = children
        for model in world.all("model"):
            self.open_model(model, (self.xml.file,))

    def open_model(self, model: LocatedElement, files: tuple[Path, ...] = ()) -> None:
        """Replace the includes of a model, and of models in it, by their models.

        Raises:
            DescriptionError: a file is missing, or is no model.
        """
        children: list[LocatedElement] = []
        for child in model.children:
            if child.tag == "model":
                self.open_model(child, files)
            if child.tag != "include":
                children.append(child)
                continue
            try:
                included = self._included(child, files or (self.xml.file,))
            except _OutOfReachError as error:
                raise self.xml.error(child, ("include",), str(error)) from error
            self._refuse_static(included, child)
            children.append(included)
        model.children = children

    def without_opened(self, model: LocatedElement) -> LocatedElement:
        """A model without the models from other files."""
        children: list[LocatedElement] = []
        for child in model.children:
            if child.tag != "model":
                children.append(child)
            elif not self.is_opened(child):
                children.append(self.without_opened(child))
        return replace(model, children=children)

    def is_opened(self, model: LocatedElement) -> bool:
        """Whether a model comes from another file."""
        return any(model is opened for opened in self.opened)

    def _included(self, include: LocatedElement, files: tuple[Path, ...]) -> LocatedElement:
        """The model of an <include>."""
        check_words(self.xml, INCLUDE, include)
        file = self._file(include, files[-1])
        if file in files:
            raise self.xml.error(include, ("include",), f"includes {file.name} in itself")
        if len(self.opened) >= _MAX_FILES:
            raise self.xml.error(include, ("include",), f"more than {_MAX_FILES} files")
        model = self._model_of(file, include)
        self.open_model(model, (*files, file))
        self._replace(model, include)
        self.opened.append(model)
        return model

    def _refuse_static(self, model: LocatedElement, include: LocatedElement) -> None:
        """Refuse a static model inside a moving one."""
        static = model.first("static")
        if static is not None and static.text.strip() in _YES:
            problem = f"makes {model.get('name')} static in a model; make the whole model static"
            raise self.xml.error(include, ("include",), problem)

    def _file(self, include: LocatedElement, around: Path) -> Path:
        """The file that a URI names."""
        uri = include.first("uri")
        text = "" if uri is None else uri.text.strip()
        if not text:
            raise self.xml.error(include, ("include",), f"has no <uri>; {_LOCAL}")
        if "://" in text and not text.startswith(_SCHEMES):
            raise _OutOfReachError(f"'{text}' is not fetched; {_LOCAL}")
        try:
            path = self.packages.resolve(text, around.parent)
            if "://" not in text and not path.exists():
                path = self.packages.resolve(f"model://{text}", around.parent)
            if path.is_dir():
                path = self._file_of_folder(path)
        except PackageError as error:
            raise _OutOfReachError(f"'{text}': {error}") from error
        if not may_be_file(path):
            raise _OutOfReachError(f"'{text}': there is no file {path}; {_LOCAL}")
        return path

    def _file_of_folder(self, folder: Path) -> Path:
        """The file of the newest version in model.config; otherwise model.sdf."""
        config = folder / _CONFIG
        newest = folder / "model.sdf"
        if not may_be_file(config):
            return newest
        versions: list[tuple[int, ...]] = [()]
        for element in read_xml(config).all("sdf"):
            parts = element.get("version", "0").split(".")
            version = tuple(int(part) for part in parts if part.isdecimal())
            if version >= max(versions) and element.text.strip():
                versions.append(version)
                newest = folder / element.text.strip()
        self.packages.require(newest)
        return newest

    def _model_of(self, file: Path, include: LocatedElement) -> LocatedElement:
        """The model of a file, converted to version 1.7."""
        root = read_xml(file)
        models = root.all("model")
        if root.tag not in ROOTS or len(models) != 1:
            problem = f"<{root.tag}> with {len(models)} models; expected <sdf> with one <model>"
            raise _OutOfReachError(f"{file} is {problem} ({CONVERT})")
        version = read_version(self.xml, root)
        self._size += _size(root)
        if self._size > MAX_ELEMENTS:
            problem = f"more than {MAX_ELEMENTS} elements in all files; not a robot"
            raise self.xml.error(include, ("include",), problem)
        self.xml.document.add_files([file])
        upgrade(models[0], version)
        check_model(self.xml, models[0], version)
        return models[0]

    def _replace(self, model: LocatedElement, include: LocatedElement) -> None:
        """Apply the name and pose of an <include> to its model."""
        for tag in _REPLACED:
            element = include.first(tag)
            if element is None:
                continue
            if tag == "name":
                model.attributes["name"] = element.text.strip()
                continue
            model.children = [child for child in model.children if child.tag != tag]
            model.children.append(element)
        if include.first("pose") is not None or include.first("placement_frame") is not None:
            model.attributes.pop("placement_frame", None)
        placement = include.first("placement_frame")
        if placement is not None:
            model.attributes["placement_frame"] = placement.text.strip()
        if include.get("merge") in _YES:
            model.attributes[MERGE] = "true"


class _OutOfReachError(Exception):
    """A file is missing, not readable, or no model; the message is a clause."""


def _size(element: LocatedElement) -> int:
    return 1 + sum(map(_size, element.children))
