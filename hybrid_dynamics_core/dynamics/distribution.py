"""Distribution of a load over redundant drives: weighted least norm with bounds and preload."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..ground.arrays import Array

IMPOSSIBLE = 1e-9  # share of a load below which a missing part is rounding
RANK = 1e-10  # singular values below this share of the largest count as zero
WITHIN = 1e-12  # share of a bound by which rounding may exceed it
SOLVED = 1  # exit flag of the solver


@dataclass(frozen=True, eq=False)
class Distribution:
    """Forces of all drives for a load; a batch has a leading N.

    Attributes:
        forces: force [N] or torque [N m] by drive, each a number or (N,).
        missing: (n,) part of tau that the drives cannot give [N m, N]; 0 along idle coordinates.
        is_possible: whether nothing is missing, a bool or (N,).
        at_limit: whether each drive is at a limit, by drive, a bool or (N,).
    """

    forces: Mapping[str, Array]
    missing: Array
    is_possible: NDArray[np.bool_]
    at_limit: Mapping[str, NDArray[np.bool_]]


class Drives(NamedTuple):
    """Bounds, weights and preloads of m drives.

    Attributes:
        lower, upper: bounds (m,) of their forces, infinite if none.
        weight: (m,) force of each drive that counts as one in the norm.
        preload: (m,) forces from which deviations are measured.
    """

    lower: Array
    upper: Array
    weight: Array
    preload: Array


def distribute(rates: Array, tau: Array, drives: Drives) -> Array:
    """Forces f (m,) with rates^T f = tau, nearest to the preload in the weighted norm.

    If no forces within the bounds give tau, the missing part is as small as possible. Each of its
    components is measured in units of what all drives together can give along that coordinate.

    Args:
        rates: (m, n) rate of each drive per unit rate of each coordinate.
        tau: (n,) generalised forces.
        drives: bounds, weights and preload.

    Raises:
        InputError: bounds are active, and no solver for them is installed.
    """
    if not np.isfinite(rates).all():  # of a state that does not close
        return np.full(len(rates), np.nan)
    matrix = rates.T * drives.weight
    load = tau - rates.T @ drives.preload
    lower = (drives.lower - drives.preload) / drives.weight
    upper = (drives.upper - drives.preload) / drives.weight
    free = np.linalg.pinv(matrix, rcond=RANK) @ load
    shares = free
    if not _is_within(free, lower, upper):
        shares = _bounded(matrix, load, free, (lower, upper))
    forces: Array = drives.preload + drives.weight * shares
    return np.clip(forces, drives.lower, drives.upper)


def _is_within(shares: Array, lower: Array, upper: Array) -> bool:
    slack = WITHIN * np.maximum(1.0, np.abs(shares))
    return bool((shares >= lower - slack).all() and (shares <= upper + slack).all())


def _bounded(matrix: Array, load: Array, free: Array, bounds: tuple[Array, Array]) -> Array:
    """The smallest shares within bounds that give the load, or as much of it as possible."""
    if np.linalg.norm(matrix @ free - load) <= IMPOSSIBLE * np.linalg.norm(load):
        least = _least_within(matrix, free, bounds)
        if least is not None:
            return least
    nearest = _nearest_load(matrix, load, bounds)
    given = np.linalg.pinv(matrix, rcond=RANK) @ (matrix @ nearest)
    least = _least_within(matrix, given, bounds)
    return nearest if least is None else least


def _least_within(matrix: Array, shares: Array, bounds: tuple[Array, Array]) -> Array | None:
    """The smallest shares within bounds that give the same load; None if there are none.

    The unknowns are coordinates of the null space of the matrix.
    """
    _, values, vectors = np.linalg.svd(matrix)
    rank = int((values > RANK * values.max(initial=0.0)).sum())
    null = np.ascontiguousarray(vectors[rank:].T)
    if not null.shape[1]:
        return None
    lower, upper = (bound - shares for bound in bounds)
    size = null.shape[1]
    solution, _, flag, _ = _solver().solve(np.eye(size), np.zeros(size), null, upper, lower)
    if flag != SOLVED:
        return None
    result: Array = shares + null @ solution
    return result if _is_within(result, *bounds) else None


def _nearest_load(matrix: Array, load: Array, bounds: tuple[Array, Array]) -> Array:
    """Shares within bounds whose load is nearest to the given one."""
    from scipy.optimize import lsq_linear  # noqa: PLC0415  slow to import

    scale = 1.0 / np.maximum(np.linalg.norm(matrix, axis=1), np.finfo(float).tiny)
    result = lsq_linear(matrix * scale[:, None], load * scale, bounds, method="bvls", tol=1e-14)
    return np.asarray(result.x, dtype=float)


def _solver() -> Any:
    try:
        import daqp  # noqa: PLC0415  only limits of redundant drives need it
    except ImportError:
        raise InputError(
            "drives that share a load within their limits need the quadratic program solver daqp:"
            " pip install 'hybrid_dynamics_ros[drives]', or daqp"
        ) from None
    return daqp
