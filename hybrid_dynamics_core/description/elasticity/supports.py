"""Stiffness of drives and bearings."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from ...errors import InputError
from ...ground.arrays import Array
from ...ground.check_arguments import real_number
from .numbers import positive, positive_or_rigid, stiffness_matrix

Chambers = Literal["both", "cap", "rod"]
CHAMBERS = ("both", "cap", "rod")
DIRECTIONS = ("radial", "axial", "tilt", "turn")
_UNITS = ("N/m", "N/m", "N m/rad", "N m/rad")


@dataclass(frozen=True)
class OilColumn:
    """The oil that a shut valve locks into the chambers of a cylinder.

    Attributes:
        bulk_modulus: of the oil with its air and its hoses [Pa].
        dead_volume: volume of hoses and ports at the cap side and at the rod side, of each
            cylinder [m^3].
        chambers: which are locked in; the other one is open to the tank.

    Raises:
        InputError: a number is not finite or not above zero, or a volume is negative.
    """

    bulk_modulus: float
    dead_volume: tuple[float, float] = (0.0, 0.0)
    chambers: Chambers = "both"

    def __post_init__(self) -> None:
        positive("bulk_modulus", self.bulk_modulus, "Pa")
        volumes = tuple(self.dead_volume)
        if len(volumes) != 2:
            raise InputError("dead_volume: expected two volumes, of cap side and rod side")
        for volume in volumes:
            size = real_number("dead_volume", volume)
            if not (size >= 0.0 and math.isfinite(size)):
                raise InputError(f"dead_volume is {size:g} m^3; expected zero or more")
        if self.chambers not in CHAMBERS:
            raise InputError(f"chambers is '{self.chambers}'; expected {', '.join(CHAMBERS)}")
        object.__setattr__(self, "dead_volume", volumes)


@dataclass(frozen=True)
class Belt:
    """A tensioned belt, or a rope or chain, that runs to the drive in both directions.

    Attributes:
        tensile_stiffness: force per strain of one strand, E A [N].
        spans: lengths of the free strands that pull at the joint [m].
        radius: of the pulley on a revolute joint [m]; None for a prismatic joint.

    Raises:
        InputError: a number is not finite or not above zero.
    """

    tensile_stiffness: float
    spans: tuple[float, ...]
    radius: float | None = None

    def __post_init__(self) -> None:
        positive("tensile_stiffness", self.tensile_stiffness, "N")
        spans = tuple(positive("spans", span, "m") for span in self.spans)
        if not spans:
            raise InputError("spans: expected the length of at least one free strand")
        if self.radius is not None:
            positive("radius", self.radius, "m")
        object.__setattr__(self, "spans", spans)

    @property
    def along(self) -> float:
        """Force at the joint per displacement of the belt [N/m]."""
        return sum(self.tensile_stiffness / span for span in self.spans)


@dataclass(frozen=True)
class DriveStiffness:
    """Springs in series between a locked drive and its joint.

    Attributes:
        stiffness: of gear, shaft, rod or servo [N m/rad, N/m]; infinite for rigid.
        oil: of a hydraulic cylinder.
        belt: between the drive and the joint.

    Raises:
        InputError: the stiffness is not above zero.
    """

    stiffness: float = math.inf
    oil: OilColumn | None = None
    belt: Belt | None = None

    def __post_init__(self) -> None:
        positive_or_rigid("stiffness", self.stiffness, "N m/rad or N/m")


@dataclass(frozen=True, eq=False)
class Bearing:
    """Stiffness of a pin or joint about its axis; None leaves a direction as the joint has it.

    Zero is free, infinity rigid. A direction in which a joint moves stays free.

    Attributes:
        radial: across the axis [N/m].
        axial: along the axis [N/m].
        tilt: about both axes across it [N m/rad].
        turn: about the axis [N m/rad].
        matrix: (6, 6) in place of the others, in the axes of the joint or closure.

    Raises:
        InputError: a stiffness is negative or not a number; a matrix is not symmetric, or
            indefinite; both are given, or nothing.
    """

    radial: float | None = None
    axial: float | None = None
    tilt: float | None = None
    turn: float | None = None
    matrix: Array | None = None

    def __post_init__(self) -> None:
        given = [name for name in DIRECTIONS if getattr(self, name) is not None]
        for name, unit in zip(DIRECTIONS, _UNITS, strict=True):
            if name in given:
                value = real_number(name, getattr(self, name))
                if not value >= 0.0:
                    raise InputError(
                        f"{name} is {value:g} {unit}; expected a stiffness above zero, zero for"
                        " free or infinity for rigid"
                    )
        if self.matrix is None and not given:
            raise InputError(f"has no stiffness; give {', '.join(DIRECTIONS)} or a matrix")
        if self.matrix is not None:
            if given:
                raise InputError(f"gives a matrix and {given[0]}; expected one of them")
            matrix = stiffness_matrix("matrix", self.matrix, definite=False)
            object.__setattr__(self, "matrix", matrix)

    @property
    def diagonal(self) -> tuple[float | None, ...]:
        """Stiffness along x, y, z and about them, z being the axis."""
        return (self.radial, self.radial, self.axial, self.tilt, self.tilt, self.turn)
