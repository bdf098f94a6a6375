"""The tree of a compiled model: bodies as links, with their joints, masses and sites."""

from __future__ import annotations

from dataclasses import dataclass

from ...description.geometry import Transform
from ..xml.located_xml import LocatedElement
from .compiler.compiled import Body
from .compiler.model import MjcfModel
from .joints import TYPES, Freedom, JointReader
from .masses import mass_entry
from .names import Names
from .poses import pose_entry, pose_of
from .settings import Settings
from .several_freedoms import several_freedoms
from .visuals import VisualReader


@dataclass(frozen=True)
class Place:
    """A frame on a link."""

    link: str
    pose: Transform


class BodyReader:
    """Reads the bodies of a model.

    Attributes:
        names: names of bodies and joints.
        freedoms: joints of the description, by their MuJoCo number.
        moving: numbers of bodies that move.
    """

    def __init__(self, model: MjcfModel, settings: Settings) -> None:
        self.model = model
        self.xml = model.xml
        self.content = model.content
        self.settings = settings
        self.joints = JointReader(model, settings)
        self.names = Names(self.content.bodies, self.content.joints)
        self.freedoms: dict[int, Freedom] = {}
        self.moving = _moving(self.content.bodies)

    def read(self) -> None:
        """Add all bodies to the document."""
        for number, body in enumerate(self.content.bodies):
            if number:
                self._add_body(number, body)
        VisualReader(self.model).add(self.names.bodies)
        for tag, names in self.names.given.items():
            self.xml.document.notes.append(
                f"<{tag}> without a name, called here: {', '.join(names)}"
            )

    def _add_body(self, number: int, body: Body) -> None:
        """Add a body as a link on a chain of joints."""
        element = self.model.element(body.line)
        link = self.names.bodies[number]
        entry = {}
        if number in self.moving or not body.is_from_shapes:
            entry = mass_entry(body, link, self.xml, element)
        if entry and self.settings.shares.get(number):
            entry["gravity_compensation"] = self.settings.shares[number]
        self.xml.add(("links", link), entry, element)
        parent = self.names.bodies[body.parent]
        pose = pose_of(body.pos, body.quat)
        if body.joints:
            self._add_chain(body, (parent, link), pose)
        else:
            fixed = {"type": "fixed", "parent": parent, "child": link, "origin": pose_entry(pose)}
            self.xml.add(("joints", f"{link}_fixed"), fixed, element)

    def _add_chain(self, body: Body, links: tuple[str, str], pose: Transform) -> None:
        """Add a chain of joints between two links, with massless links in between."""
        parent, link = links
        chain: list[tuple[Freedom, LocatedElement]] = []
        start = pose
        for number in body.joints:
            joint = self.content.joints[number]
            name = self.names.joints[number]
            if joint.kind in TYPES:
                freedom = self.joints.freedom(number, name)
            else:
                freedom = several_freedoms(self.joints, joint, name, pose)
            if joint.kind == "free":
                start = Transform()
            self.freedoms[number] = freedom
            chain.append((freedom, self.model.joint_element(joint)))
        for freedom, element in chain[:-1]:
            massless = self.names.free("body", f"{freedom.name}_link")
            self.xml.add(("links", massless), {}, element)
            self._add_freedom(freedom, element, (parent, massless), start)
            start = freedom.after
            parent = massless
        last, element = chain[-1]
        self._add_freedom(last, element, (parent, link), start)
        if not last.after.is_identity():
            frames = self.xml.document.section("frames")
            frames[link] = {"link": link, **pose_entry(last.after)}

    def _add_freedom(
        self,
        freedom: Freedom,
        element: LocatedElement,
        links: tuple[str, str],
        start: Transform,
    ) -> None:
        """Add one joint that begins at a frame of its parent link."""
        parent, child = links
        origin = pose_entry(start @ freedom.before)
        entry = {"parent": parent, "child": child, "origin": origin, **freedom.entry}
        self.xml.add(("joints", freedom.name), entry, element)

    # -- places

    def site(self, number: int) -> Place:
        """A site by its number."""
        site = self.content.sites[number]
        return Place(self.names.bodies[site.body], pose_of(site.pos, site.quat))

    def carrier(self, number: int) -> int:
        """The body on joints that carries another one; 0 for the world."""
        while number and not self.content.bodies[number].joints:
            number = self.content.bodies[number].parent
        return number

    def single_joints(self) -> dict[int, str]:
        """Names of hinges and slides by number."""
        single: dict[int, str] = {}
        for number, joint in enumerate(self.content.joints):
            if joint.kind in TYPES:
                single[number] = self.names.joints[number]
        return single


def _moving(bodies: list[Body]) -> set[int]:
    """Numbers of bodies with a joint between them and the world."""
    moving: set[int] = set()
    for number, body in enumerate(bodies):
        if body.joints or body.parent in moving:
            moving.add(number)
    return moving
