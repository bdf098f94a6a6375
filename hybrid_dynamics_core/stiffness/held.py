"""Directions in which a closure or joint holds its links, with their compliances."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from ..description.elasticity import Bearing
from ..errors import InputError
from ..ground.arrays import Array

FREE: Final = 1e-9  # eigenvalue of a scaled matrix below which a direction is free
HELD: Final = {  # directions x, y, z, then turns about them
    "planar": (0, 1),
    "point": (0, 1, 2),
    "axis": (0, 1, 2, 3, 4),
    "frame": (0, 1, 2, 3, 4, 5),
}


class Held(NamedTuple):
    """Directions that are held.

    Attributes:
        rows: (k, 6) each maps a relative displacement, in the axes of the pin, to one gap.
        deformations: (k,) gap per coordinate of unit stiffness; 0 for a rigid direction.
    """

    rows: Array
    deformations: Array


def held_by(directions: tuple[int, ...], bearing: Bearing | None, length: float) -> Held:
    """Directions that a closure holds.

    Args:
        directions: those that it holds without elasticity.
        bearing: its elasticity; None if it is rigid.
        length: by which moments are compared with forces [m].
    """
    if bearing is None:
        return Held(np.eye(6)[list(directions)], np.zeros(len(directions)))
    if bearing.matrix is not None:
        return _of_matrix(bearing.matrix, length)
    rows: list[int] = []
    deformations: list[float] = []
    for k, given in enumerate(bearing.diagonal):
        stiffness = given
        if stiffness is None:
            stiffness = math.inf if k in directions else 0.0
        if stiffness > 0.0:
            rows.append(k)
            deformations.append(math.sqrt(1.0 / stiffness))
    return Held(np.eye(6)[rows], np.array(deformations))


def joint_bearing(name: str, kinds: str, bearing: Bearing, length: float) -> Array:
    """Deformations of a joint's bearing (6, k), per coordinate of unit stiffness.

    Args:
        name: name of the joint, for messages.
        kinds: directions in which the joint moves, of `xyzXYZ`; capitals are turns.
        bearing: its stiffness.
        length: by which moments are compared with forces [m].

    Returns:
        In the axes of the joint, whose z is its axis, linear before angular.

    Raises:
        InputError: a direction is free that only the bearing holds, or is held that the joint
            moves in.
    """
    moving = tuple("xyzXYZ".index(letter) for letter in kinds)
    if bearing.matrix is not None:
        return _of_joint_matrix(name, moving, bearing.matrix, length)
    columns: list[Array] = []
    for k, stiffness in enumerate(bearing.diagonal):
        if stiffness is None or stiffness == math.inf:
            continue
        if k in moving:
            if stiffness:
                raise InputError(
                    f"pins.{name}: the joint moves {_words(k)}; expected no stiffness there: that"
                    " of its drive is in `drives`, that of a spring in the joint's `spring`"
                )
            continue
        if not stiffness:
            raise InputError(
                f"pins.{name}: {_words(k)} it is free, but the joint does not move so; expected a"
                " stiffness above zero"
            )
        columns.append(np.eye(6)[k] * math.sqrt(1.0 / stiffness))
    return np.reshape(columns, (-1, 6)).T


def _of_matrix(matrix: Array, length: float) -> Held:
    """Directions with a stiffness, those of the eigenvectors of a matrix."""
    scale = np.array([1.0] * 3 + [1.0 / length] * 3)
    values, vectors = np.linalg.eigh(matrix * np.outer(scale, scale))
    held = values > FREE * values.max(initial=0.0)
    rows = vectors[:, held].T / scale
    return Held(rows, np.sqrt(1.0 / values[held]))


def _of_joint_matrix(name: str, moving: tuple[int, ...], matrix: Array, length: float) -> Array:
    """Deformations (6, k) of a bearing in all directions in which the joint does not move."""
    largest = float(np.abs(matrix).max())
    if (np.abs(matrix[list(moving)]) > FREE * largest).any():
        raise InputError(
            f"pins.{name}: its matrix holds {_words(moving[0])}, where the joint moves; expected"
            " zeros in that row and column"
        )
    others = [k for k in range(6) if k not in moving]
    part = matrix[np.ix_(others, others)]
    held = _of_matrix(matrix, length)
    if len(held.deformations) < len(others):
        raise InputError(
            f"pins.{name}: its matrix is singular where the joint does not move; expected a"
            " stiffness in each of these directions"
        )
    lower = np.linalg.cholesky(part)
    columns = np.zeros((6, len(others)))
    columns[others] = np.linalg.inv(lower).T
    return columns


def _words(direction: int) -> str:
    kind = "along" if direction < 3 else "about"
    return f"{kind} {'xyz'[direction % 3]}"
