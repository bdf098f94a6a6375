"""Settings of a model: gravity, what is disabled, and what surrounds it."""

from __future__ import annotations

from collections.abc import Collection

from ..xml.located_xml import LocatedElement
from .compiler.model import MjcfModel

_MEANINGS = {  # of what is disabled, in words
    "constraint": "loops, couplings, limits and dry friction are left out",
    "equality": "loops and couplings are left out",
    "frictionloss": "dry friction is left out",
    "limit": "limits of joints are left out",
    "spring": "springs are left out",
    "damper": "viscous friction is left out",
    "gravity": "there is no gravity",
    "actuation": "actuators are left out",
}
_CONSTRAINTS = ("equality", "frictionloss", "limit")


class Settings:
    """What holds for the whole model.

    Attributes:
        disabled: flags that are off.
        gravity: (3,) in the world [m/s^2].
    """

    def __init__(self, model: MjcfModel) -> None:
        self.model = model
        self.xml = model.xml
        self.disabled = set(model.content.disabled)
        if "constraint" in self.disabled:
            self.disabled.update(_CONSTRAINTS)
        self.gravity: list[float] = list(model.content.gravity)

    def has(self, word: str) -> bool:
        """Whether a flag is not off."""
        return word not in self.disabled

    def read(self, moving: Collection[int]) -> None:
        """Check and note what changes the whole model.

        Args:
            moving: numbers of bodies that move.

        Raises:
            DescriptionError: it moves in a fluid, or only some of its weight is compensated.
        """
        for word in self.model.content.disabled:
            if word in _MEANINGS:
                element = self._element("flag", word) or self._element("flag", "passive")
                text = f"{word} is disabled: {_MEANINGS[word]}"
                self.xml.note(element or self.xml.root, text)
        self._refuse_fluid()
        if not self.has("gravity"):
            self.gravity = [0.0, 0.0, 0.0]
        elif any(self.gravity):
            self._compensate(moving)

    def _refuse_fluid(self) -> None:
        for word, value in zip(("density", "viscosity"), self.model.content.fluid, strict=True):
            if value:
                element = self._element("option", word) or self.xml.root
                problem = f"{word} of <option> is {value:g}: forces of a fluid are not covered"
                raise self.xml.error(element, ("option",), f"{problem}; take it out")

    def _compensate(self, moving: Collection[int]) -> None:
        """Lower gravity by the share of the weight that MuJoCo takes off all bodies."""
        content = self.model.content
        bodies = [content.bodies[number] for number in sorted(moving)]
        shares = {body.gravity_compensation for body in bodies if body.mass}
        if shares <= {0.0}:
            return
        body = next(body for body in bodies if body.gravity_compensation)
        element = self.model.element(body.line)
        if all(joint.is_held_by_drives for joint in content.joints):
            text = "gravcomp is left out: drives hold the weight, which is control"
            self.xml.note(element, text)
            return
        if len(shares) > 1:
            listed = ", ".join(f"{share:g}" for share in sorted(shares))
            problem = (
                f"gravcomp differs between moving bodies ({listed}); expected one share of the"
                " weight for all of them, or none"
            )
            raise self.xml.error(element, ("links", body.name), problem)
        (share,) = shares
        self.gravity = [(1.0 - share) * value for value in self.gravity]
        self.xml.note(element, f"gravcomp of all bodies is {share:g}: gravity is lowered by it")

    def _element(self, tag: str, attribute: str) -> LocatedElement | None:
        """The last element that says something."""
        elements = [*self.xml.root.all("option")]
        for option in self.xml.root.all("option"):
            elements.extend(option.all("flag"))
        saying: LocatedElement | None = None
        for element in elements:
            if element.tag == tag and attribute in element.attributes:
                saying = element
        return saying
