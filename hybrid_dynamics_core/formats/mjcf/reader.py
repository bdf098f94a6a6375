"""Reader of MJCF: bodies on hinges and slides, closures, followers, driven joints.

MuJoCo itself parses and compiles the file, so every word has its MuJoCo meaning. Content that
changes the robot but cannot be represented is refused with its line. All other content is left out
with a note.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

from ...description.defaults import driven_joints, farthest_link
from ...description.document import Data, Document
from ...ground.file_options import NO_OPTIONS, FileOptions
from ..extras_reader import TAG, read_extras
from ..packages import Packages
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from ..xml.vocabulary import VocabularyCheck
from .actuators import ActuatorReader
from .bodies import BodyReader
from .closures import ClosureReader
from .compiler.attached import AttachedModels
from .compiler.flexes import FLEX, leave_out_flexes
from .compiler.model import MjcfModel
from .couplings import CouplingReader
from .includes import open_includes
from .joints import TYPES
from .names import WORLD
from .poses import pose_entry, pose_of
from .pulling_tendons import PullingTendons
from .settings import Settings
from .several_freedoms import WIDTHS, pose_in_keyframe
from .tendons import TendonReader
from .vocabulary import ADVICE, FOR_MUJOCO, MJCF


def mjcf_document(root: LocatedElement, file: Path, options: FileOptions = NO_OPTIONS) -> Document:
    """The document of an MJCF file.

    Args:
        root: root element of the file.
        file: its path; meshes and included files are below its folder, or the search path.
        options: options for reading.

    Raises:
        DescriptionError: MuJoCo refuses it, or it has unsupported content.
    """
    data = {
        "format": 1,
        "name": root.get("model") or file.stem,
        "base": WORLD,
        "links": {},
        "joints": {},
        "closures": {},
        "source": file.name,
    }
    document = Document(data, file, {}, options)
    xml = XmlReader(file, root, document)
    packages = Packages(file, options.search_path)
    open_includes(xml, packages)
    flexes = leave_out_flexes(xml)
    attached = AttachedModels(xml, packages)
    check = VocabularyCheck(xml, MJCF, ADVICE, _ours(root))
    for model in (root, *attached.roots.values()):
        check.check(model)
    check.add_notes()
    mjcf = MjcfModel(xml, packages, attached)
    if flexes and not mjcf.content.joints:
        problem = "is all that moves, and a flex is no rigid body; there is no robot in this file"
        raise xml.error(flexes[0], (FLEX,), problem)
    _MjcfReader(mjcf).read()
    if "end_effector" not in document.data:
        document.data["end_effector"] = {"link": farthest_link(document)}
    return document


def _ours(root: LocatedElement) -> frozenset[str]:
    """Words that are not noted: in a file of this library, those that it writes for MuJoCo."""
    texts = [text for custom in root.all("custom") for text in custom.all("text")]
    if any(text.get("name") == TAG for text in texts):
        return FOR_MUJOCO
    return frozenset()


class _MjcfReader:
    def __init__(self, model: MjcfModel) -> None:
        self.model = model
        self.xml = model.xml
        self.document = model.xml.document
        self.settings = Settings(model)
        self.bodies = BodyReader(model, self.settings)

    def read(self) -> None:
        """Fill the document."""
        self.settings.read(self.bodies.moving)
        self.document.data["gravity"] = self.settings.gravity
        self.bodies.read()
        for link in self.document.section("links"):
            self.document.rounded_links.add(link)  # files saved by MuJoCo have six digits
        couplings = CouplingReader(self.model, self.bodies)
        tendons = TendonReader(self.model, couplings)
        pulling = PullingTendons(self.model, self.bodies, tendons)
        actuators = ActuatorReader(self.model, self.bodies, tendons)
        driven = actuators.driven(self.settings)
        self.add_equalities(couplings, tendons)
        couplings.add(driven)
        tendons.add(driven)
        actuators.add_pulled(driven)
        actuators.add_effort_limits()
        pulling.add(self.settings.disabled)
        tendons.note_unused()
        self.add_active(driven, pulling.drawn)
        self.add_reference(pulling.drawn)
        self.add_extras()

    def add_equalities(self, couplings: CouplingReader, tendons: TendonReader) -> None:
        """Add closures and followers; sites without a closure become frames."""
        closures = ClosureReader(self.model, self.bodies)
        for equality in self.model.content.equalities:
            element = self.model.element(equality.line)
            if not equality.is_active:
                self.xml.note(element, f'<{element.tag}> is left out: active="false"')
            elif not self.settings.has("equality"):
                continue
            elif equality.kind == "joint":
                couplings.read(equality)
            elif equality.kind == "tendon":
                tendons.read(equality)
            elif equality.kind == "other":
                raise closures.error(equality, f"<{element.tag}> is not covered{ADVICE}")
            else:
                closures.add(equality)
        self.add_sites(closures.tied_sites)

    def add_sites(self, tied: set[int]) -> None:
        """Add sites without a closure as frames."""
        frames = self.document.section("frames")
        links = self.document.section("links")
        for number, site in enumerate(self.model.content.sites):
            if number in tied:
                continue
            element = self.model.element(site.line)
            frame = site.name
            if not frame:
                self.xml.note(element, "<site> without a name is left out")
                continue
            if frame in links or frame == WORLD:
                frame = f"{site.name}_site"
                text = f"site {site.name} has the name of a body; called here {frame}"
                self.xml.note(element, text)
            place = self.bodies.site(number)
            frames[frame] = {"link": place.link, **pose_entry(place.pose)}

    # -- drives and reference

    def add_active(self, driven: dict[str, LocatedElement], measuring: Collection[str]) -> None:
        """Make the joints with actuators active, except those that follow others or are fixed.

        Args:
            driven: joints with actuators.
            measuring: joints of tendons, which have no drives.
        """
        joints = self.document.section("joints")
        active: list[str] = []
        for name, element in driven.items():
            if joints[name]["type"] == "fixed" or "mimic" in joints[name]:
                self.xml.note(
                    element, f"joint {name} is held or follows others; its actuator is left out"
                )
            else:
                active.append(name)
        if not active:
            self.document.notes.append(
                "no actuators are given; independent joints are taken as driven, in the order of"
                " the file"
            )
            candidates = driven_joints(self.document)
            active = [name for name in candidates if name not in measuring]
        self.document.data["active"] = active
        self.document.data["active_set"] = "motors"

    def add_reference(self, lengths: Mapping[str, float]) -> None:
        """Read the reference from the first keyframe with coordinates; by default, as drawn.

        Args:
            lengths: coordinates of joints of tendons, as drawn.
        """
        for keyframe in self.xml.root.all("keyframe"):
            for key in keyframe.all("key"):
                if key is not self.model.key:
                    self.xml.note(key, "<key> is left out; the first with qpos is the reference")
        if self.model.content.key:
            reference = self.coordinates(self.model.content.key)
        else:
            reference = self.drawn()
        reference.update(lengths)
        for name, joint in self.document.section("joints").items():
            if joint["type"] == "fixed":
                reference.pop(name, None)
        self.document.data["reference"] = reference

    def drawn(self) -> Data:
        """The coordinates of hinges and slides in the drawn configuration, within their limits."""
        joints = self.document.section("joints")
        values: Data = {}
        for freedom in self.bodies.freedoms.values():
            if freedom.entry["type"] in TYPES.values():
                limits = joints[freedom.name].get("limits", (freedom.ref, freedom.ref))
                values[freedom.name] = self.within(freedom.name, limits, freedom.ref)
        return values

    def within(self, name: str, limits: Sequence[float], drawn: float) -> float:
        """The drawn coordinate of a joint, moved to the nearest limit if beyond."""
        lower, upper = limits
        nearest = min(max(drawn, lower), upper)
        if nearest != drawn:
            self.document.notes.append(
                f"{name}: drawn at {drawn:g}, beyond its limits; taken as reference: {nearest:g}"
            )
        return nearest

    def coordinates(self, key: list[float]) -> Data:
        """The coordinates of all joints in a keyframe; poses for ball and free joints."""
        values: Data = {}
        for number, freedom in self.bodies.freedoms.items():
            joint = self.model.content.joints[number]
            numbers = key[joint.address : joint.address + WIDTHS[joint.kind]]
            if joint.kind in TYPES:
                (values[freedom.name],) = numbers
            else:
                body = self.model.content.bodies[joint.body]
                drawn = pose_of(body.pos, body.quat)
                values[freedom.name] = pose_in_keyframe(joint, drawn, numbers)
        return values

    def add_extras(self) -> None:
        """Merge the extras that this library wrote into <custom>."""
        for custom in self.xml.root.all("custom"):
            for text in custom.all("text"):
                if text.get("name") == TAG:
                    file = self.xml.file_of(text)
                    read_extras(self.document, text.get("data"), file, text.line)
                else:
                    self.xml.note(text, "<text> is left out")
