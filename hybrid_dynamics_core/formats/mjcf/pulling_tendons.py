"""Tendons of MJCF with springs, dampers, friction or rotors along their length.

The length of a fixed tendon is a sum of coordinates. That of a spatial one is the sum of the
distances between its sites: each is the slide of a massless telescope between two sites. A slide
that follows these sums has the length of the tendon as its coordinate. So forces along the tendon
are exact.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from ...description.document import Data
from ...description.followers import mimic_entry
from ...description.geometry import Transform, rotation_with_z_axis
from ...errors import DescriptionError
from ..xml.located_xml import LocatedElement
from .bodies import BodyReader, Place
from .compiler.compiled import WRAP_PULLEY, WRAP_SITE, Tendon
from .compiler.model import MjcfModel
from .names import WORLD
from .poses import pose_entry, pose_of
from .tendons import TendonReader

_FLAGS = {  # flags that disable forces along tendons
    "stiffness": "spring",
    "stiffness of higher degree": "spring",
    "springyield": "spring",
    "damping": "damper",
    "damping of higher degree": "damper",
    "frictionloss": "frictionloss",
}
_LINEAR = ("stiffness", "damping", "frictionloss", "armature")
_SHORTEST = 1e-9  # [m] least distance with a defined direction
_AXES = {"x": [1.0, 0.0, 0.0], "y": [0.0, 1.0, 0.0]}


@dataclass
class _Length:
    """Length as a weighted sum of coordinates and a constant [m or rad]."""

    terms: dict[str, float]
    constant: float = 0.0

    def add(self, name: str, factor: float) -> None:
        self.terms[name] = self.terms.get(name, 0.0) + factor


class PullingTendons:
    """Adds the joints of tendons with forces.

    Attributes:
        drawn: coordinates of the added joints in the drawn pose of the file.
    """

    def __init__(self, model: MjcfModel, bodies: BodyReader, tendons: TendonReader) -> None:
        self.model = model
        self.xml = model.xml
        self.bodies = bodies
        self.tendons = tendons
        self.drawn: dict[str, float] = {}

    def add(self, disabled: Collection[str]) -> None:
        """Add forces along tendons, after all joints and constraints are read.

        Args:
            disabled: disabled flags.

        Raises:
            DescriptionError: the force of a tendon is not that of a linear spring or damper, or it
                wraps around a shape.
        """
        for number, tendon in enumerate(self.model.content.tendons):
            forces = dict(tendon.forces)
            for word, flag in _FLAGS.items():
                if flag in disabled:
                    forces.pop(word, None)
            if forces and set(forces) != {"springyield"}:
                self._add_tendon(number, tendon, forces)

    def _add_tendon(self, number: int, tendon: Tendon, forces: dict[str, float]) -> None:
        element = self.model.element(tendon.line)
        self._require_linear(element, tendon, forces)
        name = self.bodies.names.free("joint", tendon.name or f"tendon{number}")
        if tendon.terms:
            length = self._fixed(number, element)
        else:
            length = self._spatial(name, tendon, element)
        if not length.terms:
            self.xml.note(element, f"<{element.tag}> is left out: its length does not change")
            return
        self.tendons.used.add(number)
        entry = _effects(tendon, forces)
        slides = [joint for joint in length.terms if joint in self.drawn]
        if slides == [*length.terms] and len(slides) == 1 and length.terms[slides[0]] == 1.0:
            self._pull_slide(slides[0], entry, length.constant)
            return
        entry["mimic"] = mimic_entry(length.terms, length.constant)
        follower = {"type": "prismatic", "parent": WORLD, "axis": [0.0, 0.0, 1.0], **entry}
        self._add_joint(name, follower, element)
        text = f"<{element.tag}> {tendon.name} is the slide {name}, which follows its length"
        self.xml.note(element, text)

    def _require_linear(
        self, element: LocatedElement, tendon: Tendon, forces: dict[str, float]
    ) -> None:
        problem = ""
        for word, value in forces.items():
            if word not in _LINEAR:
                problem = f"{word} is {value:g}; expected a linear spring or damper"
        lower, upper = tendon.rest
        if "stiffness" in forces and lower != upper:
            problem = (
                f"springlength is {lower:g} to {upper:g}, between which the spring is slack;"
                " expected one length"
            )
        if problem:
            raise self._error(element, problem)

    # -- lengths

    def _fixed(self, number: int, element: LocatedElement) -> _Length:
        terms = self.tendons.coefficients(number, element)
        held = self.tendons.couplings.held
        constant = sum(held[name] * terms.pop(name) for name in list(terms) if name in held)
        leading, added = self.tendons.of_leading_joints(terms)
        return _Length(dict(leading), constant + added)

    def _spatial(self, name: str, tendon: Tendon, element: LocatedElement) -> _Length:
        """The length between sites, with a telescope for each part between two bodies."""
        length = _Length({})
        before: int | None = None
        factor = 1.0
        for kind, number, divisor in tendon.wraps:
            if kind == WRAP_PULLEY:
                before = None
                factor = 1.0 / divisor
                continue
            if kind != WRAP_SITE:
                raise self._error(element, "pulls around a shape; expected sites alone")
            if before is not None:
                self._add_part(name, length, (before, number), factor, element)
            before = number
        return length

    def _add_part(
        self,
        name: str,
        length: _Length,
        sites: tuple[int, int],
        factor: float,
        element: LocatedElement,
    ) -> None:
        """Add the distance between two sites to a length."""
        carriers = [self.bodies.carrier(self.model.content.sites[site].body) for site in sites]
        start, end = (self._drawn_site(site) for site in sites)
        along = end.translation - start.translation
        distance = float(np.linalg.norm(along))
        if carriers[0] == carriers[1]:
            length.constant += factor * distance
            return
        if distance < _SHORTEST:
            raise self._error(element, "has two sites in one place, so it pulls in no direction")
        direction = start.rotation.T @ (along / distance)
        one, other = (self.bodies.site(site) for site in sites)
        turned = Transform(rotation_with_z_axis(direction))
        foot = Place(one.link, one.pose @ turned)
        slide = self._add_telescope(name, foot, other, element)
        self.drawn[slide] = distance
        length.add(slide, factor)

    def _add_telescope(self, name: str, foot: Place, head: Place, element: LocatedElement) -> str:
        """Add a massless telescope between two frames, and return the name of its slide."""
        joints = self.bodies.names
        link = foot.link
        origin = pose_entry(foot.pose)
        for letter, axis in _AXES.items():
            joint = joints.free("joint", f"{name}_{letter}")
            entry = {"type": "revolute", "parent": link, "origin": origin, "axis": axis}
            link = self._add_joint(joint, entry, element)
            self.drawn[joint] = 0.0
            origin = pose_entry(Transform())
        slide = joints.free("joint", f"{name}_length")
        entry = {"type": "prismatic", "parent": link, "axis": [0.0, 0.0, 1.0]}
        link = self._add_joint(slide, entry, element)
        between = {link: pose_entry(Transform()), head.link: pose_entry(head.pose)}
        closure = {"kind": "point", "between": between}
        self.xml.add(("closures", f"{slide}_end"), closure, element)
        text = f"<{element.tag}> pulls a telescope without mass, {slide}, between two sites"
        self.xml.note(element, text)
        return slide

    def _add_joint(self, name: str, entry: Data, element: LocatedElement) -> str:
        """Add a joint that moves a massless link, and return the name of the link."""
        link = self.bodies.names.free("body", f"{name}_link")
        self.xml.add(("links", link), {}, element)
        self.xml.add(("joints", name), {**entry, "child": link}, element)
        return link

    def _pull_slide(self, slide: str, entry: Data, constant: float) -> None:
        """Apply forces along a length to a slide that is shorter by a constant."""
        if "spring" in entry:
            entry["spring"]["rest"] -= constant
        self.xml.document.section("joints")[slide].update(entry)

    # -- places

    def _drawn_site(self, number: int) -> Transform:
        """Pose of a site in the world, in the drawn pose of the file."""
        bodies = self.model.content.bodies
        site = self.model.content.sites[number]
        pose = pose_of(site.pos, site.quat)
        body = site.body
        while body:
            pose = pose_of(bodies[body].pos, bodies[body].quat) @ pose
            body = bodies[body].parent
        return pose

    def _error(self, element: LocatedElement, problem: str) -> DescriptionError:
        name = element.get("name") or "tendon"
        return self.xml.error(element, (element.tag, name), problem)


def _effects(tendon: Tendon, forces: dict[str, float]) -> Data:
    """Friction, drive and spring along a length, as entries of a joint."""
    entries: Data = {}
    viscous = forces.get("damping", 0.0)
    coulomb = forces.get("frictionloss", 0.0)
    if viscous or coulomb:
        entries["friction"] = {"viscous": viscous, "coulomb": coulomb}
    if "armature" in forces:
        entries["drive"] = {"rotor_inertia": forces["armature"]}
    if "stiffness" in forces:
        entries["spring"] = {"stiffness": forces["stiffness"], "rest": tendon.rest[0]}
    return entries
