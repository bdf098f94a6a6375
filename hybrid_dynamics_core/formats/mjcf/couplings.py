"""Joint equalities of MJCF: joints that follow others, or are fixed at a coordinate."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from ...description.document import Data
from ...description.geometry import Transform, rotation_about, rotation_from_rpy, unit_axis
from ...errors import DescriptionError
from ...ground.arrays import frozen
from ..xml.located_xml import LocatedElement
from .bodies import BodyReader
from .compiler.compiled import Equality
from .compiler.model import MjcfModel
from .poses import pose_entry


@dataclass(frozen=True)
class _Coupling:
    """q_joint = multiplier * q_source + offset."""

    joint: str
    source: str
    multiplier: float
    offset: float
    element: LocatedElement

    def reversed(self) -> _Coupling:
        multiplier = 1.0 / self.multiplier
        offset = -self.offset / self.multiplier
        return _Coupling(self.source, self.joint, multiplier, offset, self.element)


class CouplingReader:
    """Reads <joint> of <equality>."""

    def __init__(self, model: MjcfModel, bodies: BodyReader) -> None:
        self.model = model
        self.xml = model.xml
        self.document = model.xml.document
        self.names = bodies.single_joints()
        self.refs: dict[str, float] = {}  # `ref` of hinges and slides
        for number, name in self.names.items():
            self.refs[name] = model.content.joints[number].drawn
        self.couplings: list[_Coupling] = []
        self.held: dict[str, float] = {}  # coordinates of joints that are held

    def read(self, equality: Equality) -> None:
        """Read one coupling: a polynomial between displacements from the drawn configuration.

        Raises:
            DescriptionError: the polynomial is not linear.
        """
        element = self.model.element(equality.line)
        first, second = equality.ends
        offset, multiplier, *higher = equality.data[:5]
        if second >= 0 and any(higher):
            problem = f"polycoef is '{element.get('polycoef')}'; expected one of first degree"
            raise self._error(element, problem)
        follower = self.names[first]
        offset += self.refs[follower]
        multipliers: dict[str, float] = {}
        if second >= 0 and multiplier:
            source = self.names[second]
            offset -= multiplier * self.refs[source]
            multipliers[source] = multiplier
        self.couple(follower, multipliers, offset, element)

    def couple(
        self,
        follower: str,
        multipliers: Mapping[str, float],
        offset: float,
        element: LocatedElement,
    ) -> None:
        """Couple a joint to others, or fix it if there are none."""
        if not multipliers:
            self.hold(follower, offset, element)
        for source, multiplier in multipliers.items():
            self.couplings.append(_Coupling(follower, source, multiplier, offset, element))

    def add(self, driven: Collection[str]) -> None:
        """Make coupled joints followers of one of them; a driven one is preferred.

        Raises:
            DescriptionError: couplings form a cycle.
        """
        sources = {coupling.source for coupling in self.couplings}
        followers = {coupling.joint for coupling in self.couplings}
        leading = [name for name in self.refs if name in sources - followers]
        roots = [*(name for name in self.refs if name in driven), *leading, *self.refs]
        waiting = list(self.couplings)
        placed: set[str] = set()
        for root in roots:
            if root not in placed:
                placed.add(root)
                self._follow(root, waiting, placed)

    def _follow(self, leader: str, waiting: list[_Coupling], placed: set[str]) -> None:
        """Make all joints that are coupled to a joint, directly or through others, follow it."""
        for coupling in list(waiting):
            if leader not in (coupling.joint, coupling.source) or coupling not in waiting:
                continue
            waiting.remove(coupling)
            step = coupling
            if coupling.joint == leader:
                step = coupling.reversed()
            if step.joint in placed:
                raise self._error(
                    step.element,
                    f"ties '{step.joint}' and '{leader}', which others tie already",
                )
            placed.add(step.joint)
            self._add_mimic(step)
            self._follow(step.joint, waiting, placed)

    def _add_mimic(self, coupling: _Coupling) -> None:
        entry: Data = self.document.section("joints")[coupling.joint]
        entry["mimic"] = {
            "joint": coupling.source,
            "multiplier": coupling.multiplier,
            "offset": coupling.offset,
        }
        self.xml.locate(("joints", coupling.joint, "mimic"), coupling.element)

    def hold(self, name: str, coordinate: float, element: LocatedElement) -> None:
        """Fix a joint at a coordinate."""
        entry: Data = self.document.section("joints")[name]
        if entry["type"] == "fixed":
            raise self._error(element, f"holds '{name}', which another one holds already")
        drawn = entry["origin"]
        rotation = rotation_from_rpy(*drawn["rpy"])
        origin = Transform(rotation, frozen(drawn["xyz"]))
        held = origin @ _moved(entry, coordinate - self.refs[name])
        self.held[name] = coordinate
        joints = self.document.section("joints")
        joints[name] = {
            "type": "fixed",
            "parent": entry["parent"],
            "child": entry["child"],
            "origin": pose_entry(held),
        }
        self.xml.note(element, f"joint {name} is held at {coordinate:g}")

    def _error(self, element: LocatedElement, problem: str) -> DescriptionError:
        return self.xml.error(element, ("equality", element.get("name") or "joint"), problem)


def _moved(joint: Data, displacement: float) -> Transform:
    """Motion of a joint's child at a displacement from the drawn configuration [rad or m]."""
    axis = unit_axis(joint["axis"])
    if joint["type"] == "revolute":
        return Transform(rotation_about(axis, displacement))
    return Transform(translation=frozen(displacement * axis))
