"""Stiffness of links: beams with their sections, and matrices."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ...errors import InputError
from ...ground.arrays import Array, frozen
from ...ground.check_arrays import real_array
from .numbers import positive, positive_or_rigid, stiffness_matrix

Place = str | Array  # a name on the link, or a point (3,) [m] in its frame


@dataclass(frozen=True)
class Section:
    """A cross-section of a beam along x.

    Attributes:
        A: area [m^2].
        Iy: second moment of area about y [m^4].
        Iz: second moment of area about z [m^4].
        J: torsion constant [m^4].
        Ay: shear area along y [m^2]; infinite without shear deformation.
        Az: the same along z.

    Raises:
        InputError: a number is not above zero, or one besides shear areas is not finite.
    """

    A: float
    Iy: float
    Iz: float
    J: float
    Ay: float = math.inf
    Az: float = math.inf

    def __post_init__(self) -> None:
        for name, unit in (("A", "m^2"), ("Iy", "m^4"), ("Iz", "m^4"), ("J", "m^4")):
            positive(name, getattr(self, name), unit)
        for name in ("Ay", "Az"):
            positive_or_rigid(name, getattr(self, name), "m^2")


def tube_section(diameter: float, wall: float) -> Section:
    """The section of a round tube, with its shear area A / 2 of thin walls.

    Args:
        diameter: outer [m].
        wall: thickness [m]; half the diameter for a solid bar, with its shear area 0.9 A.

    Raises:
        InputError: a number is not above zero, or the wall is thicker than the radius.
    """
    outer = 0.5 * positive("diameter", diameter, "m")
    thickness = positive("wall", wall, "m")
    inner = outer - thickness
    if inner < 0.0:
        raise InputError(f"wall is {wall:g} m; expected at most the radius, {outer:g} m")
    area = math.pi * (outer**2 - inner**2)
    second = math.pi / 4.0 * (outer**4 - inner**4)
    torsion = 2.0 * second
    shear = 0.9 * area
    if inner > 0.0:
        shear = 0.5 * area
    return Section(area, second, second, torsion, shear, shear)


def box_section(width: float, height: float, wall: float) -> Section:
    """The section of a rectangular tube; its torsion constant is that of thin walls (Bredt).

    Args:
        width: outer, along y [m].
        height: outer, along z [m].
        wall: thickness [m].

    Returns:
        The section; its shear areas are those of the webs along each axis.

    Raises:
        InputError: a number is not above zero, or the walls leave no room.
    """
    b = positive("width", width, "m")
    h = positive("height", height, "m")
    t = positive("wall", wall, "m")
    if not 2.0 * t < min(b, h):
        raise InputError(f"wall is {t:g} m; expected less than half of {min(b, h):g} m")
    inner_b = b - 2.0 * t
    inner_h = h - 2.0 * t
    about_y = (b * h**3 - inner_b * inner_h**3) / 12.0
    about_z = (h * b**3 - inner_h * inner_b**3) / 12.0
    middle_b = b - t
    middle_h = h - t
    enclosed = middle_b * middle_h
    torsion = 2.0 * t * enclosed**2 / (middle_b + middle_h)
    area = b * h - inner_b * inner_h
    flanges = 2.0 * t * b
    webs = 2.0 * t * h
    return Section(area, about_y, about_z, torsion, flanges, webs)


@dataclass(frozen=True, eq=False)
class Beam:
    """A straight beam of a link.

    Attributes:
        E: Young's modulus [Pa].
        G: shear modulus [Pa].
        section: its section.
        to: where it ends: a joint, closure or frame on the link, or a point (3,) [m].
        start: where it begins; the origin of the link if None.
        z: (3,) direction to which the section's z axis is as near as the beam allows, in link
            axes.

    Raises:
        InputError: a modulus is not above zero and finite, or a vector is not (3,).
    """

    E: float
    G: float
    section: Section
    to: Place
    start: Place | None = None
    z: Array = field(default_factory=lambda: frozen([0.0, 0.0, 1.0]))

    def __post_init__(self) -> None:
        positive("E", self.E, "Pa")
        positive("G", self.G, "Pa")
        object.__setattr__(self, "to", place("to", self.to))
        if self.start is not None:
            object.__setattr__(self, "start", place("start", self.start))
        direction = _vector("z", self.z)
        if not direction.any():
            raise InputError("z has no length; expected a direction, as [0, 0, 1]")
        object.__setattr__(self, "z", direction)


@dataclass(frozen=True, eq=False)
class LinkMatrix:
    """The stiffness of a link between its own joint and all else that is on it.

    Attributes:
        matrix: (6, 6) in link axes, linear before angular [N/m, N/rad, N m/rad].
        at: the point to which it refers: a joint, closure or frame on the link, or (3,) [m].

    Raises:
        InputError: the matrix is not symmetric and positive definite.
    """

    matrix: Array
    at: Place = field(default_factory=lambda: frozen(np.zeros(3)))

    def __post_init__(self) -> None:
        matrix = stiffness_matrix("matrix", self.matrix, definite=True)
        object.__setattr__(self, "matrix", matrix)
        object.__setattr__(self, "at", place("at", self.at))


def place(name: str, value: Place | ArrayLike) -> Place:
    """A name, or a point (3,) [m]."""
    if isinstance(value, str):
        return value
    return _vector(name, value)


def _vector(name: str, values: ArrayLike) -> Array:
    vector = frozen(real_array(name, values))
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise InputError(f"{name} has shape {vector.shape}; expected 3 finite numbers")
    return vector
