"""Inertia about the origin of a link."""

from __future__ import annotations

import numpy as np

from ..ground.arrays import Array


def parallel_axis_term(mass: float, com: Array) -> Array:
    """Inertia about the origin minus inertia about the centre of mass (parallel axis theorem).

    Args:
        mass: [kg].
        com: centre of mass (3,) [m].

    Returns:
        (3, 3) [kg m^2].
    """
    squared = com @ com * np.eye(3)
    term: Array = mass * (squared - np.outer(com, com))
    return term
