"""Fixed tendons of MJCF: sums of joint coordinates in equalities or actuators."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from ...description.document import Data
from ...description.followers import mimic_entry, multipliers_of
from ...errors import DescriptionError
from ..xml.located_xml import LocatedElement
from .compiler.compiled import Equality, Tendon
from .compiler.model import MjcfModel
from .couplings import CouplingReader


@dataclass(frozen=True)
class _Sum:
    """An equation: the sum of coefficients times coordinates equals a value."""

    coefficients: Mapping[str, float]
    value: float
    element: LocatedElement


class TendonReader:
    """Reads <tendon>, and equalities of tendons."""

    def __init__(self, model: MjcfModel, couplings: CouplingReader) -> None:
        self.model = model
        self.xml = model.xml
        self.document = model.xml.document
        self.couplings = couplings
        self.tendons = model.content.tendons
        self.used: set[int] = set()
        self.sums: list[_Sum] = []

    def read(self, equality: Equality) -> None:
        """Read an equality that fixes a tendon's length, or couples it to another tendon.

        Raises:
            DescriptionError: a tendon is spatial, or the equality is not linear.
        """
        element = self.model.element(equality.line)
        first, second = equality.ends
        value, multiplier, *higher = equality.data[:5]
        coefficients = self.coefficients(first, element)
        value += self.tendons[first].length
        if second >= 0:
            if any(higher):
                problem = f"polycoef is '{element.get('polycoef')}'; expected one of first degree"
                raise self._error(element, problem)
            value -= multiplier * self.tendons[second].length
            for name, coefficient in self.coefficients(second, element).items():
                coefficients[name] = coefficients.get(name, 0.0) - multiplier * coefficient
        coefficients = {name: number for name, number in coefficients.items() if number}
        if not coefficients:
            raise self._error(element, "ties no joint")
        self._couple(coefficients, value, element)

    def _couple(
        self, coefficients: dict[str, float], value: float, element: LocatedElement
    ) -> None:
        sources = list(coefficients)
        if len(sources) > 2:
            self.sums.append(_Sum(coefficients, value, element))
            return
        follower = sources[0]
        scale = coefficients.pop(follower)
        multipliers = {name: -other / scale for name, other in coefficients.items()}
        self.couplings.couple(follower, multipliers, value / scale, element)

    def coefficients(self, number: int, element: LocatedElement) -> dict[str, float]:
        """The coefficients of a tendon that are not zero, by joint.

        Args:
            number: number of the tendon.
            element: element that names the tendon, for errors.
        """
        tendon: Tendon = self.tendons[number]
        self.used.add(number)
        if not tendon.terms:
            problem = (
                f"uses the spatial tendon '{tendon.name}', whose length is no sum of coordinates;"
                " expected a fixed one"
            )
            raise self._error(element, problem)
        coefficients: dict[str, float] = {}
        for joint, coefficient in tendon.terms:
            name = self.couplings.names[joint]
            coefficients[name] = coefficients.get(name, 0.0) + coefficient
        return coefficients

    def add(self, driven: Collection[str]) -> None:
        """Make one joint of each sum a follower of the others; it must not be driven."""
        for tied in self.sums:
            self._add_sum(tied, driven)

    def note_unused(self) -> None:
        """Say which tendons only measure."""
        for number, tendon in enumerate(self.tendons):
            if number not in self.used:
                element = self.model.element(tendon.line)
                self.xml.note(element, f"<{element.tag}> is left out")

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
        """The first joint that is neither driven nor a follower."""
        joints = self.document.section("joints")
        for name in coefficients:
            if name not in driven and "mimic" not in joints[name]:
                return name
        return next(iter(coefficients))

    def _is_circular(self, coefficients: Mapping[str, float], driven: Collection[str]) -> bool:
        """Whether the follower would follow itself through others."""
        follower = self._follower(coefficients, driven)
        others = {name: value for name, value in coefficients.items() if name != follower}
        leading, _ = self.of_leading_joints(others)
        return follower in leading or "mimic" in self.document.section("joints")[follower]

    def of_leading_joints(self, terms: Mapping[str, float]) -> tuple[dict[str, float], float]:
        """Coefficients and constant of a sum, with followers replaced by their leaders."""
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
