"""Mesh files that MuJoCo needs for masses of bodies; no other mesh is opened."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from ....ground.regular_files import read_regular
from ...packages import PackageError, Packages
from ...xml.located_xml import LocatedElement
from ...xml.reader import XmlReader

_LARGEST = 50_000_000  # [bytes] of one mesh
_LARGEST_SUM = 200_000_000  # [bytes] of all meshes
_WAY_OUT = 'give the body an <inertial>, or the <geom> mass="0"'


class MeshFiles:
    """The mesh files that a model names.

    Attributes:
        names: name that replaces the path of each <mesh>, by the element's id().
    """

    def __init__(
        self, xml: XmlReader, packages: Packages, attached: Iterable[LocatedElement] = ()
    ) -> None:
        self.xml = xml
        self.packages = packages
        self.names: dict[int, str] = {}
        self.paths: dict[str, tuple[Path, str]] = {}  # folder of the file, and path from there
        for root in (xml.root, *attached):
            self._add(root)

    def _add(self, root: LocatedElement) -> None:
        """Name the meshes of one model."""
        folder, is_stripped = _settings(root)
        start = self.xml.file_of(root).parent
        for mesh in _meshes(root):
            path = mesh.get("file")
            if not path:
                continue
            if is_stripped:
                path = path.replace("\\", "/").rpartition("/")[2]
            name = f"mesh{len(self.names)}{Path(path).suffix.lower()}"
            self.names[id(mesh)] = name
            if not Path(path).is_absolute():
                path = f"{folder}{path}"
            self.paths[name] = (start, path)

    def read(self, asked: Mapping[str, tuple[LocatedElement, str]]) -> dict[str, bytes]:
        """The content of the needed files, by name.

        Args:
            asked: for the name of each needed mesh, the <geom> and the body that need it.

        Raises:
            DescriptionError: a file is missing, out of reach or too large.
        """
        contents: dict[str, bytes] = {}
        total = 0
        for name, (element, body) in asked.items():
            start, path = self.paths[name]
            contents[name] = self._content(start, path, element, body)
            total += len(contents[name])
            if total > _LARGEST_SUM:
                problem = f"the meshes of masses have more than {_LARGEST_SUM} bytes; {_WAY_OUT}"
                raise self.xml.error(element, ("links", body), problem)
        return contents

    def _content(self, start: Path, path: str, element: LocatedElement, body: str) -> bytes:
        key = ("links", body)
        try:
            file = self.packages.resolve(path, start)
            content = read_regular(file, _LARGEST + 1)
        except (PackageError, OSError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            problem = f"its mass is that of the mesh '{path}', which is not read: {reason}"
            raise self.xml.error(element, key, f"{problem}; {_WAY_OUT}") from error
        if len(content) > _LARGEST:
            problem = f"its mass is that of the mesh '{path}', of more than {_LARGEST} bytes"
            raise self.xml.error(element, key, f"{problem}; {_WAY_OUT}")
        return content


def _meshes(root: LocatedElement) -> Iterator[LocatedElement]:
    for asset in root.all("asset"):
        yield from asset.all("mesh")


def _settings(root: LocatedElement) -> tuple[str, bool]:
    """`meshdir`, and whether `strippath` is set; the last <compiler> wins."""
    folder = ""
    strips = "false"
    for compiler in root.all("compiler"):
        folder = compiler.get("assetdir", folder)
        strips = compiler.get("strippath", strips)
    for compiler in root.all("compiler"):
        folder = compiler.get("meshdir", folder)
    if folder and not folder.endswith("/"):
        folder += "/"
    return folder, strips == "true"
