"""Settings of a model: gravity, disabled flags, surrounding fluid."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from ..xml.located_xml import LocatedElement
from .compiler.model import MjcfModel

_MEANINGS = {  # texts for disabled flags
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
    """Gravity and disabled flags of a model.

    Attributes:
        disabled: flags that are off.
        gravity: (3,) in the world [m/s^2].
        shares: by index of the body: share of its weight that MuJoCo compensates, if shares differ.
    """

    def __init__(self, model: MjcfModel) -> None:
        self.model = model
        self.xml = model.xml
        self.disabled = set(model.content.disabled)
        if "constraint" in self.disabled:
            self.disabled.update(_CONSTRAINTS)
        self.gravity: list[float] = list(model.content.gravity)
        self.shares: dict[int, float] = {}

    def has(self, word: str) -> bool:
        """Whether a flag is on."""
        return word not in self.disabled

    def read(self, moving: Collection[int]) -> None:
        """Read all settings, and add notes on those that change the model.

        Args:
            moving: numbers of bodies that move.

        Raises:
            DescriptionError: drives at some joints alone compensate a weight.
        """
        for word in self.model.content.disabled:
            if word in _MEANINGS:
                element = self._element("flag", word) or self._element("flag", "passive")
                text = f"{word} is disabled: {_MEANINGS[word]}"
                self.xml.note(element or self.xml.root, text)
        self._note_fluid()
        if not self.has("gravity"):
            self.gravity = [0.0, 0.0, 0.0]
        elif any(self.gravity):
            self._compensate(moving)

    def _note_fluid(self) -> None:
        for word, value in zip(("density", "viscosity"), self.model.content.fluid, strict=True):
            if value:
                element = self._element("option", word) or self.xml.root
                text = f"{word} of <option> is {value:g}: drag of the fluid around is left out"
                self.xml.note(element, text)

    def _compensate(self, moving: Collection[int]) -> None:
        """Take off the shares of weights that MuJoCo compensates."""
        bodies = self.model.content.bodies
        shares: dict[int, float] = {}
        for number in sorted(moving):
            if bodies[number].mass:
                shares[number] = bodies[number].gravity_compensation
        if not any(shares.values()):
            return
        first = next(number for number, share in shares.items() if share)
        element = self.model.element(bodies[first].line)
        if self._is_held_by_drives(shares):
            text = "gravcomp is left out: drives hold the weight, which is control"
            self.xml.note(element, text)
        elif len(set(shares.values())) > 1:
            self.shares = shares
            for number, share in shares.items():
                if share:
                    text = f"gravcomp: {share:g} of the weight of this body is not felt"
                    self.xml.note(self.model.element(bodies[number].line), text)
        else:
            share = shares[first]
            self.gravity = [(1.0 - share) * value for value in self.gravity]
            text = f"gravcomp of all bodies is {share:g}: gravity is lowered by it"
            self.xml.note(element, text)

    def _is_held_by_drives(self, shares: Mapping[int, float]) -> bool:
        """Whether drives take the weights that are compensated.

        Raises:
            DescriptionError: some of the joints before them have such drives, others do not.
        """
        content = self.model.content
        carrying: set[int] = set()
        for number, share in shares.items():
            while share and number:
                carrying.update(content.bodies[number].joints)
                number = content.bodies[number].parent  # noqa: PLW2901 - the way to the world
        held = [number for number in carrying if content.joints[number].is_held_by_drives]
        if held and len(held) < len(carrying):
            joint = content.joints[held[0]]
            problem = (
                "actuatorgravcomp lets this drive hold a weight, which other joints do not feel;"
                " expected it at all joints that carry the weight, or at none"
            )
            raise self.xml.error(self.model.joint_element(joint), ("joints", joint.name), problem)
        return bool(held)

    def _element(self, tag: str, attribute: str) -> LocatedElement | None:
        """The last element with a tag and attribute."""
        elements = [*self.xml.root.all("option")]
        for option in self.xml.root.all("option"):
            elements.extend(option.all("flag"))
        saying: LocatedElement | None = None
        for element in elements:
            if element.tag == tag and attribute in element.attributes:
                saying = element
        return saying
