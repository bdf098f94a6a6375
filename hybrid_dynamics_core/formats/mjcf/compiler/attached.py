"""Models attached by an MJCF file, each from another file, passed to MuJoCo as text."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ....ground.regular_files import may_be_file
from ...packages import PackageError, Packages
from ...xml.located_xml import MAX_ELEMENTS, LocatedElement, read_xml
from ...xml.reader import XmlReader
from ..includes import open_includes

_MAX_FILES = 100


class AttachedModels:
    """Attached models of a file, including nested ones.

    Attributes:
        roots: by plain name: root of the model. MuJoCo gets these names in place of paths.
        names: by identity of a <model> element: its plain name.

    Args:
        xml: the main file, with includes inserted.
        packages: access to files that may be read.

    Raises:
        DescriptionError: a file is missing or must not be read, is no MJCF, or attaches itself.
    """

    def __init__(self, xml: XmlReader, packages: Packages) -> None:
        self.xml = xml
        self.packages = packages
        self.roots: dict[str, LocatedElement] = {}
        self.names: dict[int, str] = {}
        self._size = 0
        self._open(xml.root, (xml.file,))

    def _open(self, root: LocatedElement, files: tuple[Path, ...]) -> None:
        """Open the models attached by the last file of a chain of attached files."""
        for element in _models(root):
            file = self._file(element, files[-1].parent)
            if file.resolve() in {around.resolve() for around in files}:
                raise self._error(element, f"attaches '{file.name}' in itself")
            if len(self.roots) >= _MAX_FILES:
                raise self._error(element, f"more than {_MAX_FILES} models; not a robot")
            model = read_xml(file)
            if model.tag != "mujoco":
                raise self._error(element, f"'{file.name}' is <{model.tag}>; expected <mujoco>")
            open_includes(XmlReader(file, model, self.xml.document), self.packages)
            self._size += _count(model)
            if self._size > MAX_ELEMENTS:
                raise self._error(element, "too many elements for a robot")
            name = f"model{len(self.roots)}.xml"
            self.names[id(element)] = name
            self.roots[name] = model
            element.attributes.setdefault("name", model.get("model") or file.stem)
            self._open(model, (*files, file))

    def _file(self, element: LocatedElement, folder: Path) -> Path:
        name = element.get("file")
        file = folder / name
        try:
            self.packages.require(file)
        except PackageError as error:
            raise self._error(element, f"attaches {error}") from error
        if not may_be_file(file):
            raise self._error(element, f"attaches '{name}', which is not there: {file}")
        return file

    def _error(self, element: LocatedElement, problem: str) -> Exception:
        return self.xml.error(element, ("asset", "model"), problem)


def _models(root: LocatedElement) -> Iterator[LocatedElement]:
    for asset in root.all("asset"):
        yield from asset.all("model")


def _count(element: LocatedElement) -> int:
    return 1 + sum(map(_count, element.children))
