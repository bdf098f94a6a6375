"""A mass matrix that cannot be inverted, in words."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..errors import MassSingularityError
from ..ground.arrays import Array

NEGLIGIBLE = 1e-6  # share of the largest part below which a coordinate is not mentioned


def mass_singularity(
    mass: Array, singular: NDArray[np.bool_], active: tuple[str, ...]
) -> MassSingularityError:
    """The error for a singular M-bar.

    Args:
        mass: M-bar (n, n) or (N, n, n).
        singular: where it is singular, () or (N,).
        active: names of the active coordinates.

    Returns:
        The error for the first singular row.
    """
    row = None
    if mass.ndim == 3:
        row = int(np.flatnonzero(singular)[0])
        mass = mass[row]
    values, vectors = np.linalg.eigh(mass)
    direction = vectors[:, 0] / np.abs(vectors[:, 0]).max()
    moved: list[str] = []
    for name, part in zip(active, direction, strict=True):
        if abs(part) > NEGLIGIBLE:
            moved.append(f"{name} ({part:+.3g})")
    problem = "M-bar is singular to working precision"
    if values[0] < -NEGLIGIBLE * values[-1]:
        problem = (
            "M-bar is not positive definite: a link has an inertia that no rigid body has, as"
            " `check` tells"
        )
    message = (
        f"{problem}: accelerating {', '.join(moved)} takes no force"
        f" (smallest eigenvalue {values[0]:.3g}, largest {values[-1]:.3g}); give the links behind"
        " these joints the mass or inertia, or the joints the rotor, that they have in truth"
    )
    return MassSingularityError(
        message,
        direction=direction,
        eigenvalues=values,
        joint=active[int(np.argmax(np.abs(direction)))],
        index=row,
    )
