"""Combinations of parameters that no measurement shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..ground.arrays import Array

SHOWN = 0.1  # of the prior's deviation, below which measurements show a parameter
NEGLIGIBLE = 0.02  # coefficient, over the largest, below which a parameter takes no part


@dataclass(frozen=True)
class Unseen:
    """A change of parameters that leaves every measurement as it is.

    Attributes:
        names: the parameters that take part.
        changes: change of each [rad, m], the largest being 1.
        deviation: deviation of the combination [m], angles times the reach.
    """

    names: tuple[str, ...]
    changes: tuple[float, ...]
    deviation: float

    @property
    def pairs(self) -> list[tuple[str, float]]:
        """Each parameter with its change."""
        return list(zip(self.names, self.changes, strict=True))

    def __str__(self) -> str:
        """The change as text, such as `L2 +1, joints.q3.origin.xyz[0] -1`."""
        return ", ".join(f"{name} {change:+.3g}" for name, change in self.pairs)


def identifiable(covariance: Array, prior: float) -> list[bool]:
    """Whether measurements show each parameter.

    Args:
        covariance: of the parameters in natural units (k, k) [m^2].
        prior: deviation of what no measurement shows [m].
    """
    deviations = np.sqrt(np.diag(covariance))
    is_shown = deviations < SHOWN * prior
    shown: list[bool] = is_shown.tolist()
    return shown


def unseen_combinations(
    names: Sequence[str], covariance: Array, scales: Array, prior: float
) -> list[Unseen]:
    """The combinations that no measurement shows, each in as small a group as possible.

    A rank-revealing QR factorisation chooses one parameter for each, on which the others depend.

    Args:
        names: the parameters (k).
        covariance: in natural units (k, k) [m^2].
        scales: natural units (k,).
        prior: deviation of what no measurement shows [m].
    """
    from scipy.linalg import qr  # noqa: PLC0415  slow to import

    values, vectors = np.linalg.eigh(covariance)
    least = SHOWN * prior
    is_unseen = values > least * least
    space = vectors[:, is_unseen]
    count = space.shape[1]
    if not count:
        return []
    _, _, order = qr(space.T, pivoting=True)
    chosen = order[:count]
    basis = space @ np.linalg.inv(space[chosen])
    combinations: list[Unseen] = []
    for column in basis.T:
        direction = column / np.linalg.norm(column)
        variance = direction @ covariance @ direction
        deviation = float(np.sqrt(variance))
        changes = direction / scales
        combinations.append(_combination(names, direction, changes, deviation))
    return combinations


def _combination(
    names: Sequence[str], direction: Array, changes: Array, deviation: float
) -> Unseen:
    """A combination, with the parameters that take part in it."""
    sizes = np.abs(direction)
    least = NEGLIGIBLE * sizes.max()
    parts = np.flatnonzero(sizes > least)
    chosen = changes[parts]
    largest = np.argmax(np.abs(chosen))
    ratios = chosen / chosen[largest]
    members = tuple(names[int(k)] for k in parts)
    return Unseen(members, tuple(ratios.tolist()), deviation)
