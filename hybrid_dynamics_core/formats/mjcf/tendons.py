"""Fixed tendons of MJCF: a sum of joint coordinates that an equality holds, or a drive pulls."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from ...description.document import Data
from ...description.followers import mimic_entry, multipliers_of
from ...errors import DescriptionError
from ...ground.suggestions import suggestion
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .couplings import CouplingReader


@dataclass(frozen=True)
class _Sum:
    """The sum of coefficients times coordinates has a value."""

    coefficients: Mapping[str, float]
    value: float
    element: LocatedElement


class TendonReader:
    """Reads <tendon>, and the equalities that hold one."""

    def __init__(self, xml: XmlReader, couplings: CouplingReader) -> None:
        self.xml = xml
        self.document = xml.document
        self.couplings = couplings
        self.tendons: dict[str, LocatedElement] = {}
        self.unused: list[LocatedElement] = []
        for section in xml.root.all("tendon"):
            self.unused.extend(section.children)
            for tendon in section.all("fixed"):
                self.tendons[tendon.get("name")] = tendon
        self.sums: list[_Sum] = []

    def read(self, element: LocatedElement) -> None:
        """Read a tendon that an equality holds at a length.

        Raises:
            DescriptionError: it is none of hinges and slides, or goes with a second one.
        """
        if element.get("tendon2"):
            raise self._error(element, "ties two tendons; expected tendon1 alone")
        coefficients = self.coefficients(element, element.get("tendon1"))
        (value,) = self.xml.leading_numbers(element, "polycoef", ("equality",))[:1] or [0.0]
        for name, coefficient in coefficients.items():
            value += coefficient * self.couplings.refs[name]
        sources = list(coefficients)
        if len(sources) > 2:
            self.sums.append(_Sum(coefficients, value, element))
            return
        follower = sources[0]
        scale = coefficients.pop(follower)
        multipliers = {name: -other / scale for name, other in coefficients.items()}
        self.couplings.couple(follower, multipliers, value / scale, element)

    def coefficients(self, element: LocatedElement, name: str) -> dict[str, float]:
        """The coefficient of each joint of a tendon that is not zero.

        Args:
            element: that names the tendon.
            name: of the tendon.
        """
        if name not in self.tendons:
            hint = suggestion(name, self.tendons)
            raise self._error(element, f"there is no fixed tendon '{name}'{hint}")
        tendon = self.tendons[name]
        if tendon in self.unused:
            self.unused.remove(tendon)
        coefficients: dict[str, float] = {}
        for joint in tendon.all("joint"):
            joint_name = joint.get("joint")
            if joint_name not in self.couplings.refs:
                hint = suggestion(joint_name, self.couplings.refs)
                raise self._error(joint, f"'{joint_name}' is no hinge and no slide{hint}")
            coefficient = self.xml.number(joint, "coef", ("tendon", name))
            if coefficient:
                coefficients[joint_name] = coefficient
        if not coefficients:
            raise self._error(tendon, "has no joint with a coef")
        return coefficients

    def add(self, driven: Collection[str]) -> None:
        """Make one joint of each sum a follower of the others, one that is not driven."""
        for tied in self.sums:
            self._add_sum(tied, driven)
        for tendon in self.unused:
            self.xml.note(tendon, f"<{tendon.tag}> is left out")

    def _add_sum(self, tied: _Sum, driven: Collection[str]) -> None:
        joints = self.document.section("joints")
        coefficients = dict(tied.coefficients)
        value = tied.value
        if self._is_circular(coefficients, driven):
            coefficients, added = self.of_leading_joints(coefficients)
            value -= added
        if not coefficients:
            raise self._error(tied.element, "holds joints that others tie already")
        follower = self._follower(coefficients, driven)
        scale = coefficients.pop(follower)
        multipliers = {name: -other / scale for name, other in coefficients.items()}
        if multipliers:
            joints[follower]["mimic"] = mimic_entry(multipliers, value / scale)
        else:
            self.couplings.hold(follower, value / scale, tied.element)

    def _follower(self, coefficients: Mapping[str, float], driven: Collection[str]) -> str:
        """The first joint that is not driven and follows no others yet."""
        joints = self.document.section("joints")
        for name in coefficients:
            if name not in driven and "mimic" not in joints[name]:
                return name
        return next(iter(coefficients))

    def _is_circular(self, coefficients: Mapping[str, float], driven: Collection[str]) -> bool:
        """Whether the follower follows others already, or is followed by them."""
        follower = self._follower(coefficients, driven)
        others = {name: value for name, value in coefficients.items() if name != follower}
        leading, _ = self.of_leading_joints(others)
        return follower in leading or "mimic" in self.document.section("joints")[follower]

    def of_leading_joints(self, terms: Mapping[str, float]) -> tuple[dict[str, float], float]:
        """A sum of coordinates by those of joints that follow none, and what is added to it."""
        joints = self.document.section("joints")
        total: dict[str, float] = {}
        added = 0.0
        for name, coefficient in terms.items():
            mimic: Data = joints[name].get("mimic", {})
            leading: Mapping[str, float] = {name: coefficient}
            if mimic:
                multipliers = multipliers_of(mimic)
                scaled = {key: coefficient * float(value) for key, value in multipliers.items()}
                leading, further = self.of_leading_joints(scaled)
                added += coefficient * float(mimic["offset"]) + further
            for key, value in leading.items():
                total[key] = total.get(key, 0.0) + value
        return {name: value for name, value in total.items() if value}, added

    def _error(self, element: LocatedElement, problem: str) -> DescriptionError:
        return self.xml.error(element, (element.tag, element.get("name") or "tendon"), problem)
