"""What a drive of a catalogue would give in a duty cycle, and what it lacks."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Margins:
    """How much more than the duty cycle asks for a drive has to give.

    All but `stroke` are factors of what is needed.

    Attributes:
        pressure: of pressures.
        torque: of peak torques.
        rms: of root mean squares of torques.
        speed: of speeds.
        power: of powers.
        buckling: of the force under which a rod buckles.
        stroke: way that is left at either end of a cylinder [m].
    """

    pressure: float = 1.0
    torque: float = 1.0
    rms: float = 1.0
    speed: float = 1.0
    power: float = 1.0
    buckling: float = 3.5
    stroke: float = 0.0


@dataclass(frozen=True)
class Check:
    """One quantity of a drive.

    Attributes:
        quantity: its name.
        needed: what the duty cycle needs, with its margin.
        given: what the drive has.
        unit: unit of both.
    """

    quantity: str
    needed: float
    given: float
    unit: str

    @property
    def fits(self) -> bool:
        """Whether the drive has what is needed."""
        return self.needed <= self.given

    @property
    def share(self) -> float:
        """What is needed as a share of what the drive has; infinite where it has nothing."""
        if self.given <= 0.0:
            return 0.0 if self.fits else math.inf
        return self.needed / self.given

    @property
    def text(self) -> str:
        """The two numbers as a text."""
        return f"{self.quantity}: needs {self.needed:.4g} {self.unit}, has {self.given:.4g}"


@dataclass(frozen=True)
class Candidate:
    """A drive of a catalogue in a duty cycle.

    Attributes:
        name: its name.
        checks: all quantities that it was checked for.
    """

    name: str
    checks: tuple[Check, ...]

    @property
    def fits(self) -> bool:
        """Whether it has all that is needed."""
        return not self.lacking

    @property
    def lacking(self) -> tuple[Check, ...]:
        """The quantities of which it has too little."""
        return tuple(check for check in self.checks if not check.fits)
