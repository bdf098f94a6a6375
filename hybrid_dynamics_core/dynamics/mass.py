"""The error for a mass matrix that cannot be inverted."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from ..errors import MassSingularityError
from ..ground.arrays import Array

NEGLIGIBLE = 1e-6  # share of the largest component below which a coordinate is not named
NO_MASS = 1e-10  # share of the largest eigenvalue below which a motion moves no mass
MENDING = (
    "give the links behind these joints the mass or inertia, or the joints the rotor, that they"
    " have in truth"
)


def mass_singularity(
    mass: Array,
    singular: NDArray[np.bool_],
    active: tuple[str, ...],
    idle: Collection[str] = (),
    forces: Array | None = None,
) -> MassSingularityError:
    """The error for a singular M-bar.

    Args:
        mass: M-bar (n, n) or (N, n, n).
        singular: mask () or (N,) of singular rows.
        active: names of the active coordinates.
        idle: names of active coordinates without a drive.
        forces: efforts minus bias forces (n,) or (N, n); zero if None.

    Returns:
        The error for the first singular row.
    """
    row = None
    if forces is None:
        forces = np.zeros(mass.shape[:-1])
    if mass.ndim == 3:
        row = int(np.flatnonzero(singular)[0])
        mass = mass[row]
        forces = forces[row]
    values, vectors = np.linalg.eigh(mass)
    driven = [k for k, name in enumerate(active) if name not in idle]
    direction = _free_motion(values, vectors, driven, forces)
    moved = _parts(direction, active)
    problem = f"M-bar is singular to working precision: accelerating {moved} takes no force"
    if values[0] < -NEGLIGIBLE * values[-1]:
        problem = (
            "M-bar is not positive definite: a link has an inertia that no rigid body has, as"
            f" `check` tells: accelerating {moved} takes no force"
        )
    elif not np.abs(direction[driven]).max(initial=0.0) > NEGLIGIBLE:
        force = float(forces @ direction)
        problem = f"{moved} moves no mass, and a force of {force:.3g} (N m or N) is along it"
    eigenvalues = f"smallest eigenvalue {values[0]:.3g}, largest {values[-1]:.3g}"
    return MassSingularityError(
        f"{problem} ({eigenvalues}); {MENDING}",
        direction=direction,
        eigenvalues=values,
        joint=active[int(np.argmax(np.abs(direction)))],
        index=row,
    )


def _free_motion(values: Array, vectors: Array, driven: list[int], forces: Array) -> Array:
    """The massless motion (n,) to be named, with a largest component of 1.

    It is the one with the largest components along driven coordinates. If none has any, it is the
    one along which the forces act.
    """
    free = vectors[:, np.abs(values) < NO_MASS * values[-1]]
    direction: Array = vectors[:, 0]
    if free.shape[1] and values[0] > -NEGLIGIBLE * values[-1]:
        _, shares, motions = np.linalg.svd(free[driven])
        direction = free @ motions[0]
        along_forces = free @ (free.T @ forces)
        if not shares.max(initial=0.0) > NEGLIGIBLE and along_forces.any():
            direction = along_forces
    largest = np.abs(direction).max()
    scaled: Array = direction / largest
    return scaled


def _parts(direction: Array, names: tuple[str, ...]) -> str:
    """The coordinates of a motion with their components, as text."""
    moved: list[str] = []
    for name, part in zip(names, direction, strict=True):
        if abs(part) > NEGLIGIBLE:
            moved.append(f"{name} ({part:+.3g})")
    return ", ".join(moved)
