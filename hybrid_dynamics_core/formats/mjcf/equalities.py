"""Equality constraints of MJCF: closures between bodies or sites."""

from __future__ import annotations

import math

import numpy as np

from ...description.document import Data
from ...description.geometry import Transform, rotation_from_quaternion
from ...errors import DescriptionError
from ...ground.arrays import frozen
from ...ground.suggestions import suggestion
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .bodies import WORLD, BodyReader, pose_entry

_CLOSURE_KINDS = {"connect": "point", "weld": "frame"}
_ZERO_VECTOR = (0.0, 0.0, 0.0)
_NO_POSE = (0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0)  # its quaternion without length: as drawn
_ANSWERS = {"true": True, "false": False}

End = tuple[str, Transform]  # a link and a pose on it


class ClosureReader:
    """Reads <connect> and <weld>.

    Attributes:
        tied_sites: sites that closures tie.
    """

    def __init__(self, xml: XmlReader, bodies: BodyReader) -> None:
        self.xml = xml
        self.bodies = bodies
        self.tied_sites: set[str] = set()

    def add(self, element: LocatedElement) -> None:
        """Add a closure.

        Raises:
            DescriptionError: what it ties is not there, or is one body.
        """
        between: Data = {}
        for link, pose in self._ends(element):
            between[link] = pose_entry(pose)
        if len(between) < 2:
            raise self._error(element, "ties two places of one body")
        closures = self.xml.document.section("closures")
        name = element.get("name")
        number = len(closures) + 1
        while not name or (name in closures and not element.get("name")):
            name = f"loop{number}"
            number += 1
        entry = {"kind": _CLOSURE_KINDS[element.tag], "between": between}
        self.xml.add(("closures", name), entry, element)

    def _ends(self, element: LocatedElement) -> list[End]:
        """The two places that are tied."""
        given = self._given(element)
        if given == {"site1", "site2"}:
            return [self._site(element, "site1"), self._site(element, "site2")]
        if "body1" in given and given <= {"body1", "body2"}:
            return self._bodies(element)
        listed = ", ".join(sorted(given)) or "nothing"
        raise self._error(element, f"gives {listed}; expected site1 and site2, or body1 and body2")

    def _given(self, element: LocatedElement) -> set[str]:
        words = ("site1", "site2", "body1", "body2")
        return {word for word in words if element.get(word)}

    def _site(self, element: LocatedElement, word: str) -> End:
        name = element.get(word)
        sites = self.bodies.sites
        if name not in sites:
            hint = suggestion(name, sites)
            raise self._error(element, f"ties the site '{name}', which is not there{hint}")
        self.tied_sites.add(name)
        return sites[name].link, sites[name].pose

    def _bodies(self, element: LocatedElement) -> list[End]:
        one = self._body(element, "body1")
        other = self._body(element, "body2")
        if element.tag == "connect":
            return self._connected(element, one, other)
        return self._welded(element, one, other)

    def _body(self, element: LocatedElement, word: str) -> str:
        name = element.get(word, WORLD)
        if name not in self.bodies.drawn:
            hint = suggestion(name, self.bodies.drawn)
            raise self._error(element, f"ties the body '{name}', which is not there{hint}")
        return name

    def _connected(self, element: LocatedElement, one: str, other: str) -> list[End]:
        """The anchor in the first body, and in the second where the file draws it."""
        anchor = self.xml.numbers(element, "anchor", 3, ("equality",))
        place = Transform(translation=frozen(anchor))
        return [(one, place), (other, self._from_to(other, one) @ place)]

    def _welded(self, element: LocatedElement, one: str, other: str) -> list[End]:
        """The anchor in the second body, and its pose in the first: as given, or as drawn."""
        anchor = self.xml.numbers(element, "anchor", 3, ("equality",), _ZERO_VECTOR)
        place = Transform(translation=frozen(anchor))
        *position, w, x, y, z = self.xml.numbers(element, "relpose", 7, ("equality",), _NO_POSE)
        if math.hypot(w, x, y, z) == 0.0:
            return [(one, self._from_to(one, other) @ place), (other, place)]
        rotation = rotation_from_quaternion(np.array([w, x, y, z]))
        return [(one, Transform(rotation, frozen(position))), (other, place)]

    def _from_to(self, link: str, other: str) -> Transform:
        """The pose of another link in a link, as the file draws them."""
        drawn = self.bodies.drawn
        return drawn[link].inverse() @ drawn[other]

    def _error(self, element: LocatedElement, problem: str) -> DescriptionError:
        return self.xml.error(element, (element.tag, element.get("name") or "?"), problem)


def is_active(xml: XmlReader, element: LocatedElement) -> bool:
    """Whether a constraint holds.

    Raises:
        DescriptionError: `active` is neither true nor false.
    """
    active = element.get("active", "true")
    if active not in _ANSWERS:
        problem = f"active is '{active}'; expected {' or '.join(_ANSWERS)}"
        raise xml.error(element, (element.tag,), problem)
    return _ANSWERS[active]
