"""Axes of forces and motions of a frame, as they are named and given."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arrays import real_array
from ..ground.suggestions import no_such_name

AXES = ("x", "y", "z", "rx", "ry", "rz")  # forces or translations, moments or rotations


def rows_of(axes: Sequence[str]) -> list[int]:
    """Rows of the Jacobian for k axes; raises InputError for wrong names."""
    rows: list[int] = []
    for name in axes:
        if name not in AXES:
            raise InputError(f"axes: {no_such_name('axis', name, AXES)}")
        rows.append(AXES.index(name))
    if not rows or len(set(rows)) < len(rows):
        raise InputError("axes: expected one or more, each once")
    return rows


def unit_wrench(direction: ArrayLike) -> Array:
    """The unit wrench (6,) along a direction (3,) or (6,)."""
    values = real_array("direction", direction)
    size = float(np.linalg.norm(values))
    if values.shape not in ((3,), (6,)) or not 0.0 < size < np.inf:
        raise InputError(
            f"direction has shape {values.shape}; expected 3 or 6 finite numbers, not all zero"
        )
    unit = np.zeros(6)
    unit[: len(values)] = values / size
    return unit
