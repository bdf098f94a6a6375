"""The energy of a robot."""

from __future__ import annotations

from typing import NamedTuple

from ..ground.arrays import Array


class Energy(NamedTuple):
    """Energies [J], each a number or (N,).

    Attributes:
        kinetic: kinetic energy of the motion, rotors included.
        potential: potential energy of gravity, zero at the base origin.
        springs: stored in springs.
    """

    kinetic: Array
    potential: Array
    springs: Array

    @property
    def total(self) -> Array:
        """The sum of all energies [J]."""
        return self.kinetic + self.potential + self.springs
