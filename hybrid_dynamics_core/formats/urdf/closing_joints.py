"""Joints of a URDF that close loops: <constraint>, and Drake's ball constraint."""

from __future__ import annotations

from ...description.document import Data, KeyPath
from ...description.geometry import rpy_to_axis, unit_axis
from ...ground.arrays import Array
from ...ground.suggestions import suggestion
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader

_KINDS = {
    "revolute": "axis",
    "continuous": "axis",
    "ball": "point",
    "spherical": "point",
    "fixed": "frame",
}
_X_AXIS = (1.0, 0.0, 0.0)


class ClosingJoints:
    """Adds closures for joints between links of the tree.

    Args:
        xml: the URDF, whose links and joints the document has.
    """

    def __init__(self, xml: XmlReader) -> None:
        self.xml = xml
        self.document = xml.document

    def add_constraints(self) -> None:
        """Add every <constraint> and <drake:ball_constraint>."""
        for element in self.xml.root.all("constraint"):
            self._add_constraint(element)
        for element in self.xml.root.all("drake:ball_constraint"):
            self._add_ball(element)

    # -- <constraint>

    def _add_constraint(self, element: LocatedElement) -> None:
        """Add a <constraint>: a frame with an axis on each link."""
        name = self.xml.name(element, "constraints")
        kind = self.kind(element)
        between: Data = {}
        for tag in ("parent", "child"):
            end = element.first(tag)
            if end is None or not end.get("link"):
                problem = f"has no <{tag} link=...>; a loop of URDF+ is written <loop>"
                raise self.xml.error_at(element, problem)
            link = self.link(end, end.get("link"))
            pose = self.xml.pose(element.first(f"{tag}_origin"), ("constraints", name, tag))
            place = [pose]
            if kind == "axis":
                axis = self._direction(element.first(f"{tag}_axis"), ("constraints", name, tag))
                place.append({"rpy": rpy_to_axis(axis)})
            between[link] = place
        self.add(element, name, kind, between)

    def _add_ball(self, element: LocatedElement) -> None:
        """Add a <drake:ball_constraint>: a point on each link."""
        between: Data = {}
        for body, point in (("A", "p_AP"), ("B", "p_BQ")):
            key = ("closures", point)
            end = element.first(f"drake:ball_constraint_body_{body}")
            place = element.first(f"drake:ball_constraint_{point}")
            if end is None or place is None:
                problem = f"has no <drake:ball_constraint_body_{body}> or no {point}"
                raise self.xml.error(element, (element.tag,), problem)
            link = self.link(end, end.get("name"))
            between[link] = self.xml.numbers(place, "value", 3, key)
        count = len(self.document.section("closures"))
        self.add(element, f"ball_{count + 1}", "point", between)

    # -- common to both

    def kind(self, element: LocatedElement) -> str:
        """The kind of closure for a joint's type."""
        joint_type = element.get("type")
        if joint_type not in _KINDS:
            expected = ", ".join(_KINDS)
            raise self.xml.error_at(
                element,
                f"closes a loop with a joint of type '{joint_type}'; expected {expected}: cut the"
                " loop at such a joint",
            )
        return _KINDS[joint_type]

    def link(self, element: LocatedElement, name: str) -> str:
        """The name of a link, which must exist."""
        links = self.document.section("links")
        if name not in links:
            hint = suggestion(name, links)
            problem = f"there is no link '{name}'{hint}"
            raise self.xml.error(element, (f"{element.tag}s", name), problem)
        return name

    def _direction(self, axis: LocatedElement | None, key: KeyPath) -> Array:
        """The unit vector (3,) of an <axis>."""
        if axis is None:
            return unit_axis(list(_X_AXIS))
        try:
            return unit_axis(self.xml.numbers(axis, "xyz", 3, key))
        except ValueError as error:
            raise self.xml.error(axis, key, str(error)) from error

    def add(self, element: LocatedElement, name: str, kind: str, between: Data) -> None:
        """Add a closure between two links."""
        if len(between) < 2:
            raise self.xml.error_at(element, "has both ends on one link")
        if name in self.document.section("joints"):
            raise self.xml.error_at(element, "has the name of another joint; rename one of the two")
        self.xml.add(("closures", name), {"kind": kind, "between": between}, element)
