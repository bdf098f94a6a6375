"""A mass matrix that cannot be inverted, said in words."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..errors import MassSingularityError
from ..ground.arrays import Array


def mass_singularity(
    mass: Array, singular: NDArray[np.bool_], active: tuple[str, ...]
) -> MassSingularityError:
    """The error for M-bar (n, n), or for (N, n, n) at the first row that is singular (N,)."""
    row = None if mass.ndim == 2 else int(np.flatnonzero(singular)[0])
    matrix = mass if row is None else mass[row]
    values, vectors = np.linalg.eigh(matrix)
    direction = vectors[:, 0] / np.abs(vectors[:, 0]).max()
    moved = ", ".join(
        f"{name} ({part:+.3g})"
        for name, part in zip(active, direction, strict=True)
        if abs(part) > 1e-6
    )
    message = (
        f"M-bar is singular to working precision: accelerating {moved} takes no force (smallest"
        f" eigenvalue {values[0]:.3g}, largest {values[-1]:.3g}); give the links behind these"
        " joints the mass or inertia, or the joints the rotor, that they have in truth"
    )
    return MassSingularityError(
        message,
        direction=direction,
        eigenvalues=values,
        joint=active[int(np.argmax(np.abs(direction)))],
        index=row,
    )
