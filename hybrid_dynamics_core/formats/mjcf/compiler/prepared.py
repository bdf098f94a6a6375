"""The text of a model for MuJoCo: one element a line, without files and irrelevant elements.

So MuJoCo opens no file, and each line in its messages maps to an element and its file.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from ...xml.located_xml import LocatedElement
from ..vocabulary import OMITTED, OMITTED_ATTRIBUTES

# of attributes; the standard library's function comes with its client of the web
_ENTITIES = str.maketrans(
    {
        "&": "&amp;",
        "<": "&lt;",
        ">": "&gt;",
        '"': "&quot;",
        "\n": "&#10;",
        "\r": "&#13;",
        "\t": "&#9;",
    }
)
_PLUGIN = "plugin"
_NONE: frozenset[str] = frozenset()


class PreparedText:
    """The input of MuJoCo for a file.

    Attributes:
        text: with one element a line.
        models: texts of attached models by their names. Each begins on the line behind the one
            before, so every line is that of one element.
        key: the first keyframe with coordinates.

    Args:
        root: root of the file.
        attached: roots of attached models by name.
        files: names in place of paths, by the identity of elements.
    """

    def __init__(
        self,
        root: LocatedElement,
        attached: Mapping[str, LocatedElement],
        files: Mapping[int, str],
    ) -> None:
        self.key: LocatedElement | None = None
        self._lines: list[LocatedElement] = []
        self._files = files
        self.text = self._text(root)
        keys = self.key
        self.models: dict[str, bytes] = {}
        for name, model in attached.items():
            self.key = model  # keyframes of attached models are of other coordinates
            self.models[name] = self._text(model).encode()
        self.key = keys

    def _text(self, root: LocatedElement) -> str:
        before = "\n" * len(self._lines)
        return before + "\n".join(self._rows(root, "")) + "\n"

    def element(self, line: int) -> LocatedElement | None:
        """The element that starts on a line (1-based); None if there is none."""
        if 1 <= line <= len(self._lines):
            return self._lines[line - 1]
        return None

    def _rows(self, element: LocatedElement, parent: str) -> Iterator[str]:
        """The line of an element's start tag, and those of its children."""
        self._lines.append(element)
        tag = element.tag
        if parent == "actuator" and tag == _PLUGIN:
            tag = "general"  # the control law is irrelevant
        written = f"<{tag}{self._attributes(element)}"
        rows: list[str] = []
        for child in element.children:
            if self._counts(child, element.tag):
                rows.extend(self._rows(child, element.tag))
        if not rows:
            yield f"{written}/>"
            return
        yield f"{written}>"
        yield from rows[:-1]
        yield f"{rows[-1]}</{tag}>"

    def _counts(self, child: LocatedElement, parent: str) -> bool:
        """Whether an element is part of MuJoCo's input."""
        if parent == "keyframe":
            if self.key is None and "qpos" in child.attributes:
                self.key = child
            return child is self.key
        if parent == "actuator" and child.tag == _PLUGIN:
            return True
        if child.tag in OMITTED.get(parent, _NONE):
            return False
        return child.tag not in OMITTED[""] and ":" not in child.tag

    def _attributes(self, element: LocatedElement) -> str:
        """The relevant attributes of an element, as text."""
        omitted = OMITTED_ATTRIBUTES.get(element.tag, OMITTED_ATTRIBUTES[""])
        attributes = dict(element.attributes)
        if id(element) in self._files:
            attributes.setdefault("name", _stem(attributes["file"]))
            attributes["file"] = self._files[id(element)]
        written = ""
        for name, value in attributes.items():
            if name not in omitted and name != "xmlns" and ":" not in name:
                written += f' {name}="{value.translate(_ENTITIES)}"'
        return written


def _stem(file: str) -> str:
    """The default name of a mesh: the stem of its file."""
    name = file.replace("\\", "/").rpartition("/")[2]
    return name.rpartition(".")[0] or name
