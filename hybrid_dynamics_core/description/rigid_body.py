"""Inertia tensors of rigid bodies: symmetry, possibility, and the nearest possible tensor."""

from __future__ import annotations

import numpy as np

from ..algebra.live import plain
from ..ground.arrays import Array, frozen

TRIANGLE_SLACK = 1e-9  # relative error of printed moments
_ROUNDED_APART = 1e-4  # share of the largest entry up to which asymmetry is rounding
_MARGIN = 1e-12  # share of the largest moment by which a tensor is kept inside the feasible set
_LEAST_MOMENT = 1e-300  # [kg m^2] stands for none


def symmetric_inertia(matrix: Array) -> tuple[Array, float]:
    """The symmetric part of a tensor, and its asymmetry.

    Args:
        matrix: (3, 3) [kg m^2].

    Returns:
        Mean (3, 3) of the matrix and its transpose, and their largest difference [kg m^2].

    Raises:
        ValueError: the difference is more than rounding.
    """
    differences = np.abs(matrix - matrix.T)
    apart = float(differences.max())
    if not apart:
        return matrix, 0.0
    allowed = _ROUNDED_APART * float(np.abs(matrix).max())
    if apart > allowed:
        i, k = np.unravel_index(int(np.argmax(differences)), (3, 3))
        one, other = "xyz"[i], "xyz"[k]
        raise ValueError(
            f"the inertia matrix is not symmetric: entry {one}{other} is {matrix[i, k]:.6g}, entry"
            f" {other}{one} is {matrix[k, i]:.6g} kg m^2; they differ by {apart:.3g}, and"
            f" {allowed:.3g} is taken as rounding"
        )
    return frozen((matrix + matrix.T) / 2.0), apart


def impossibility(inertia: Array, slack: float) -> str:
    """Why no rigid body has this tensor; empty if a body can have it.

    Principal moments of a body are not negative, and obey the triangle inequality.

    Args:
        inertia: (3, 3) symmetric [kg m^2].
        slack: error of the printed numbers, relative to the largest moment.
    """
    least, middle, largest = np.linalg.eigvalsh(plain(inertia)).tolist()
    size = max(abs(least), abs(largest), _LEAST_MOMENT)
    allowed = max(slack * size, _LEAST_MOMENT)
    if least < -allowed:
        share = 100.0 * abs(least) / size
        return (
            f"a principal moment of inertia is negative ({least:.6g} kg m^2, {share:.3g} % of the"
            " largest one)"
        )
    missing = largest - least - middle
    if missing > allowed:
        share = 100.0 * missing / largest
        return (
            f"no rigid body has principal moments {least:.6g}, {middle:.6g}, {largest:.6g}: two of"
            f" them must add up to at least the third, and {missing:.3g} kg m^2 are missing"
            f" ({share:.3g} % of it)"
        )
    return ""


def nearest_possible(inertia: Array) -> Array:
    """The nearest tensor that a rigid body can have, inside the feasible set by more than rounding.

    Args:
        inertia: (3, 3) symmetric [kg m^2].
    """
    moments, axes = np.linalg.eigh(inertia)
    moments = np.maximum(moments, 0.0)
    missing = max(0.0, moments[2] - moments[1] - moments[0])
    moments += missing / 3.0 * np.array([1.0, 1.0, -1.0])
    moments += _MARGIN * moments.max()
    nearest = axes * moments @ axes.T
    return frozen((nearest + nearest.T) / 2.0)
