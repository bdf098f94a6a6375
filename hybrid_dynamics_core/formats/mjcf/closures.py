"""Equality constraints of MJCF: closures between bodies or sites."""

from __future__ import annotations

from ...description.document import Data
from ...description.geometry import Transform
from ...errors import DescriptionError
from ...ground.arrays import frozen
from .bodies import BodyReader, Place
from .compiler.compiled import Equality
from .compiler.model import MjcfModel
from .poses import pose_entry, pose_of

_KINDS = {"connect": "point", "weld": "frame"}


class ClosureReader:
    """Reads <connect> and <weld>.

    Attributes:
        tied_sites: numbers of sites that closures tie.
    """

    def __init__(self, model: MjcfModel, bodies: BodyReader) -> None:
        self.model = model
        self.xml = model.xml
        self.bodies = bodies
        self.tied_sites: set[int] = set()

    def add(self, equality: Equality) -> None:
        """Add a closure."""
        if self._is_led_by_hand(equality) or self._is_on_one_body(equality):
            return
        ends = self._ends(equality)
        between: Data = {end.link: pose_entry(end.pose) for end in ends}
        closures = self.xml.document.section("closures")
        name = equality.name
        number = len(closures) + 1
        while not name or (name in closures and not equality.name):
            name = f"loop{number}"
            number += 1
        entry = {"kind": _KINDS[equality.kind], "between": between}
        self.xml.add(("closures", name), entry, self.model.element(equality.line))

    def _is_led_by_hand(self, equality: Equality) -> bool:
        """Whether a constraint ends on a mocap body, which is no part of the robot."""
        bodies = self.model.content.bodies
        for number in self._body_numbers(equality):
            if bodies[number].is_mocap:
                element = self.model.element(equality.line)
                text = f"<{equality.kind}> is left out: a program moves its end (mocap)"
                self.xml.note(element, text)
                return True
        return False

    def _is_on_one_body(self, equality: Equality) -> bool:
        """Whether nothing moves between the ends of a constraint."""
        one, other = map(self.bodies.carrier, self._body_numbers(equality))
        if one != other:
            return False
        text = f"<{equality.kind}> is left out: nothing moves between its ends"
        self.xml.note(self.model.element(equality.line), text)
        return True

    def _body_numbers(self, equality: Equality) -> list[int]:
        if not equality.is_between_sites:
            return equality.ends
        return [self.model.content.sites[number].body for number in equality.ends]

    def _ends(self, equality: Equality) -> list[Place]:
        """The two ends of a constraint."""
        if equality.is_between_sites:
            self.tied_sites.update(equality.ends)
            return [self.bodies.site(number) for number in equality.ends]
        one, other = (self.bodies.names.bodies[number] for number in equality.ends)
        data = equality.data
        if equality.kind == "connect":
            at_one = Transform(translation=frozen(data[0:3]))
            at_other = Transform(translation=frozen(data[3:6]))
        else:  # an anchor in the second body, and its pose in the first
            at_one = pose_of(data[3:6], data[6:10])
            at_other = Transform(translation=frozen(data[0:3]))
        return [Place(one, at_one), Place(other, at_other)]

    def error(self, equality: Equality, problem: str) -> DescriptionError:
        """An error at a constraint."""
        element = self.model.element(equality.line)
        return self.xml.error(element, (element.tag, equality.name or "?"), problem)
