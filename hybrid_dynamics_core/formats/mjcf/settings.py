"""Settings of an MJCF file that change what its numbers mean: <compiler> and <option>."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..xml.reader import XmlReader

_GRAVITY = (0.0, 0.0, -9.81)  # of a file that does not say
_ALL_GROUPS = (0.0, 5.0)
_UNITS = {"degree": math.pi / 180.0, "radian": 1.0}
_LETTERS = "xyzXYZ"
_KEY = ("compiler",)


@dataclass(frozen=True)
class Settings:
    """What <compiler> says; of repeated attributes the last holds, as in MuJoCo.

    Attributes:
        angle_unit: of angles in the file [rad].
        euler_sequence: three axes; small letters turn with the body, capitals do not.
        are_limits_automatic: whether a range limits a joint without a further word.
        masses_from_shapes: "auto" where a body has no <inertial>, "true" always, "false" never.
        groups: first and last group of the shapes that have a mass.
        least_mass: [kg] to which lighter bodies are raised.
        least_moment: [kg m^2] to which smaller principal moments are raised.
        is_balanced: whether moments that no body has are replaced by their mean.
        gravity: in the world [m/s^2].
    """

    angle_unit: float
    euler_sequence: str
    are_limits_automatic: bool
    masses_from_shapes: str
    groups: tuple[float, float]
    least_mass: float
    least_moment: float
    is_balanced: bool
    gravity: list[float]


class SettingsReader:
    """Reads the settings of a file."""

    def __init__(self, xml: XmlReader) -> None:
        self.xml = xml

    def read(self) -> Settings:
        """The settings.

        Raises:
            DescriptionError: one has a value that it cannot have.
        """
        first, last = self._numbers("compiler", "inertiagrouprange", _ALL_GROUPS)
        return Settings(
            angle_unit=_UNITS[self._word("angle", "degree", "radian")],
            euler_sequence=self._euler_sequence(),
            are_limits_automatic=self._word("autolimits", "true", "false") == "true",
            masses_from_shapes=self._word("inertiafromgeom", "auto", "true", "false"),
            groups=(first, last),
            least_mass=self._numbers("compiler", "boundmass", (0.0,))[0],
            least_moment=self._numbers("compiler", "boundinertia", (0.0,))[0],
            is_balanced=self._word("balanceinertia", "false", "true") == "true",
            gravity=self._numbers("option", "gravity", _GRAVITY),
        )

    def _word(self, attribute: str, default: str, *others: str) -> str:
        """The last value of an attribute of <compiler>, one of several words."""
        words = (default, *others)
        value = default
        for compiler in self.xml.root.all("compiler"):
            value = compiler.get(attribute, value)
            if value not in words:
                expected = " or ".join(words)
                problem = f"{attribute} is '{value}'; expected {expected}"
                raise self.xml.error(compiler, _KEY, problem)
        return value

    def _numbers(self, tag: str, attribute: str, default: tuple[float, ...]) -> list[float]:
        values = list(default)
        for element in self.xml.root.all(tag):
            values = self.xml.numbers(element, attribute, len(default), (tag,), values)
        return values

    def _euler_sequence(self) -> str:
        sequence = "xyz"
        for compiler in self.xml.root.all("compiler"):
            sequence = compiler.get("eulerseq", sequence)
            if len(sequence) != len("xyz") or sequence.strip(_LETTERS):
                problem = f"eulerseq is '{sequence}'; expected three of the letters {_LETTERS}"
                raise self.xml.error(compiler, _KEY, problem)
        return sequence
