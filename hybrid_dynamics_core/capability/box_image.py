"""What a box of drive forces can do: the image of a box under linear equations.

Drives have forces x, each within its limits. What they do together, y, obeys A x = r + K y. All
solutions are y = Y z + y0 and x = X z + x0, with z free; each limit of x is a half-space of z.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from ..errors import InputError
from ..ground.arrays import Array

RANK = 1e-11  # share of the largest value, below which one is zero
SLACK = 1e-9  # share of a range by which rounding may exceed a limit
MOST_SETS = 200_000  # sets of limits that may meet at a vertex
TINY = 1e-300


class UnlimitedError(InputError):
    """No limit of a drive bounds what is asked for."""


@dataclass(frozen=True, eq=False)
class BoxImage:
    """Solutions y = y0 + Y z with forces x = x0 + X z within limits.

    Attributes:
        y0: (k,).
        Y: (k, d).
        x0: (m,).
        X: (m, d).
        lower: (m,), minus infinity without a limit.
        upper: (m,), infinity without a limit.
        is_possible: whether the equations have a solution.
    """

    y0: Array
    Y: Array
    x0: Array
    X: Array
    lower: Array
    upper: Array
    is_possible: bool = True

    def vertices(self) -> tuple[Array, Array]:
        """Vertices: y (v, k) and x (v, m); none if the limits allow nothing.

        Raises:
            UnlimitedError: the limits do not bound y.
        """
        limited = np.isfinite(self.lower) & np.isfinite(self.upper)
        size = np.ones(len(self.lower))
        size[limited] = 0.5 * (self.upper - self.lower)[limited]
        size[size == 0.0] = 1.0
        rows = (self.X / size[:, None])[limited]
        # directions that no limit bounds have to leave y as it is
        _, values, axes = np.linalg.svd(rows)
        rank = int((values > RANK * values.max(initial=0.0)).sum())
        moved = self.Y @ axes[rank:].T
        if np.abs(moved).max(initial=0.0) > SLACK * np.abs(self.Y).max(initial=0.0):
            raise UnlimitedError("no limit of a drive bounds it")
        if not self.is_possible:
            return np.zeros((0, len(self.y0))), np.zeros((0, len(self.x0)))
        across = axes[:rank].T
        low = ((self.lower - self.x0) / size)[limited]
        high = ((self.upper - self.x0) / size)[limited]
        z = _corners(rows @ across, low, high) @ across.T
        return self.y0 + z @ self.Y.T, self.x0 + z @ self.X.T


def solutions(A: Array, K: Array, r: Array, lower: Array, upper: Array) -> BoxImage:
    """All solutions of A x = r + K y.

    Args:
        A: (n, m).
        K: (n, k).
        r: (n,).
        lower: (m,) limits of x.
        upper: (m,).
    """
    m, k = A.shape[1], K.shape[1]
    limited = np.isfinite(lower) & np.isfinite(upper)
    widths = np.where(limited, upper - lower, 0.0)
    largest = float(widths.max(initial=0.0)) or 1.0
    sizes = np.where(widths > 0.0, widths, largest)
    matrix = np.hstack([A * sizes, -K])
    rows = np.maximum(np.abs(matrix[:, :m]).max(axis=1, initial=0.0), TINY)
    matrix /= rows[:, None]
    columns = np.abs(matrix[:, m:]).max(axis=0, initial=0.0)
    units = np.concatenate([np.ones(m), 1.0 / np.where(columns > 0.0, columns, 1.0)])
    u, values, vt = np.linalg.svd(matrix * units)
    rank = int((values > RANK * values.max(initial=0.0)).sum())
    right = r / rows
    particular = vt[:rank].T @ ((u.T @ right)[:rank] / values[:rank])
    missing = np.abs(matrix * units @ particular - right).max(initial=0.0)
    back = units * np.concatenate([sizes, np.ones(k)])
    solution = back * particular
    free = back[:, None] * vt[rank:].T
    possible = bool(missing <= SLACK * max(np.abs(right).max(initial=0.0), 1.0))
    return BoxImage(solution[m:], free[m:], solution[:m], free[:m], lower, upper, possible)


def _corners(rows: Array, low: Array, high: Array) -> Array:
    """Vertices (v, d) of low <= rows z <= high, whose rows (m, d) have full rank."""
    count, d = rows.shape
    if not d:
        inside = (low <= SLACK).all() and (high >= -SLACK).all()
        return np.zeros((int(inside), 0))
    sets = np.array(list(combinations(range(count), d)))
    if len(sets) * 2**d > MOST_SETS:
        raise InputError(f"{count} limits in {d} directions have too many vertices")
    matrices = rows[sets]
    sizes = np.linalg.norm(matrices, axis=2, keepdims=True)
    unit = matrices / np.maximum(sizes, TINY)
    regular = np.abs(np.linalg.det(unit)) > RANK
    sets, matrices = sets[regular], matrices[regular]
    points: list[Array] = []
    for ends in product((False, True), repeat=d):
        right = np.where(ends, high[sets], low[sets])
        points.append(np.linalg.solve(matrices, right[..., None])[..., 0])
    z = np.concatenate(points)
    along = z @ rows.T
    within = (along >= low - SLACK) & (along <= high + SLACK)
    return np.asarray(z[within.all(axis=1)])
