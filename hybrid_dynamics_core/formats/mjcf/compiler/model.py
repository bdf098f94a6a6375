"""An MJCF file, compiled by MuJoCo in a separate process; errors name file and line."""

from __future__ import annotations

import re

from ....errors import DescriptionError
from ....ground.wording import one_line
from ...packages import Packages
from ...xml.located_xml import LocatedElement
from ...xml.reader import XmlReader
from .assets import MeshFiles
from .attached import AttachedModels
from .compiled import CompiledModel, Joint, compiled_model
from .prepared import PreparedText
from .process import WORKERS, Answer, is_installed

_SECONDS = 4  # [s] limit of processor time
_SECONDS_WITH_MESHES = 30
_MAX_COPIES = 20_000
_MAX_DIGITS = 9
_PLACE = re.compile(r"line (\d+)")
_ELEMENT = re.compile(r"Element (name )?'[^']*'(, id \d+)?, line \d+")
_PREFIXES = re.compile(r"^((XML )?Error: |Schema violation: )+")
_SECTIONS = {"body": "links"}  # names in messages; for other elements the tag and an s
_MASSES = frozenset({"mass", "density", "diaginertia", "fullinertia"})
_NOT_FINITE = ("nan", "inf", "infinity")
_INSTALL = "MJCF files need MuJoCo: pip install mujoco-core"


class MjcfModel:
    """An MJCF file and its compiled model.

    Attributes:
        xml: the elements, with those of included files.
        content: the compiled model.
    """

    def __init__(self, xml: XmlReader, packages: Packages, attached: AttachedModels) -> None:
        self.xml = xml
        if not is_installed():
            raise DescriptionError(_INSTALL, file=xml.file)
        models = attached.roots
        for root in (xml.root, *models.values()):
            self._require_size(root, 1)
            self._require_finite(root)
        self._meshes = MeshFiles(xml, packages, models.values())
        names = {**self._meshes.names, **attached.names}
        self._text = PreparedText(xml.root, models, names)
        self.content: CompiledModel = self._compiled()

    def element(self, line: str) -> LocatedElement:
        """The element of a line in MuJoCo's messages; the root if there is none."""
        place = _PLACE.search(line)
        element = None
        if place is not None:
            element = self._text.element(int(place[1]))
        return element or self.xml.root

    def mesh_path(self, name: str) -> str:
        """The path of a mesh from the file, by the plain name that MuJoCo got."""
        folder = self.xml.file.parent
        start, path = self._meshes.paths.get(name, (folder, name))
        if start == folder:
            return path
        return str(start.absolute() / path)

    def _require_size(self, element: LocatedElement, copies: int) -> None:
        """Refuse copies of copies before MuJoCo makes them."""
        count = element.get("count")
        if element.tag == "replicate" and count.isdecimal():
            copies *= max(1, int(count[:_MAX_DIGITS]))
        if copies > _MAX_COPIES:
            problem = f"makes {copies} copies; expected at most {_MAX_COPIES}"
            raise self.xml.error(element, ("replicate",), problem)
        for child in element.children:
            self._require_size(child, copies)

    def _require_finite(self, element: LocatedElement) -> None:
        """Refuse masses and moments that are no numbers, since MuJoCo's message misleads."""
        for attribute in _MASSES & element.attributes.keys():
            text = element.get(attribute)
            if any(word.lower().lstrip("+-") in _NOT_FINITE for word in text.split()):
                problem = f'has {attribute}="{text}", which is not finite; expected numbers'
                raise self.xml.error(element, (attribute,), problem)
        for child in element.children:
            self._require_finite(child)

    def joint_element(self, joint: Joint) -> LocatedElement:
        """The element of a joint, also of a <freejoint>, whose line MuJoCo does not report."""
        if joint.line:
            return self.element(joint.line)
        body = self.element(self.content.bodies[joint.body].line)
        return body.first("freejoint") or body

    @property
    def key(self) -> LocatedElement | None:
        """The first keyframe with coordinates."""
        return self._text.key

    def _compiled(self) -> CompiledModel:
        models = self._text.models
        answer = self._ask(WORKERS.ask(self._text.text, models, _SECONDS))
        if "missing" in answer:
            asked: dict[str, tuple[LocatedElement, str]] = {}
            for name, line, body in answer["missing"]:
                asked[name] = (self.element(line), body)
            files = {**models, **self._meshes.read(asked)}
            answer = self._ask(WORKERS.ask(self._text.text, files, _SECONDS_WITH_MESHES))
        return compiled_model(answer["model"])

    def _ask(self, answer: Answer) -> Answer:
        """Ask MuJoCo; raise if its answer is an error."""
        if "error" not in answer:
            return answer
        text = str(answer["error"])
        element = self.element(text)
        words = one_line(_PREFIXES.sub("", _ELEMENT.sub("", text)).strip())
        problem = f"{words} ({answer.get('version', 'MuJoCo')})"
        if element is self.xml.root:
            raise DescriptionError(problem, file=self.xml.file)
        section = _SECTIONS.get(element.tag, f"{element.tag}s")
        name = element.get("name")
        raise self.xml.error(element, (section, name) if name else (element.tag,), problem)
