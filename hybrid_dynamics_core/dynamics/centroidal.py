"""Momentum of a robot and its centre of mass."""

from __future__ import annotations

from dataclasses import dataclass

from ..ground.arrays import Array


@dataclass(frozen=True, eq=False)
class Centroidal:
    """Centre of mass and momentum in base axes; a batch has a leading N.

    Rotors behind gears are left out: their axes are not known.

    Attributes:
        mass: mass of all moving links and payloads [kg].
        com: (3,) centre of mass [m].
        momentum_matrix: (6, n) A in momentum = A u': linear [kg m/s], then angular about the centre
            of mass [kg m^2/s], per unit rate. Orin and Goswami (2008).
        momentum: (6,) A u'.
    """

    mass: float
    com: Array
    momentum_matrix: Array
    momentum: Array

    @property
    def com_jacobian(self) -> Array:
        """(3, n) velocity of the centre of mass per unit rate."""
        jacobian: Array = self.momentum_matrix[..., :3, :] / self.mass
        return jacobian

    @property
    def com_velocity(self) -> Array:
        """(3,) velocity of the centre of mass [m/s]."""
        velocity: Array = self.momentum[..., :3] / self.mass
        return velocity
