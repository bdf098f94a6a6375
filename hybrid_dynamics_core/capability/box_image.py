"""What a box of drive forces can do: the image of a box under linear equations.

Drives have forces x, each within its limits. Their common result y, as a force of the tool, obeys
A x = r + K y. All solutions are y = y0 + Y z and x = x0 + X z, with z free. Each limit of x is a
half-space of z.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from ..errors import InputError
from ..ground.arrays import Array

RANK = 1e-11  # singular values below this share of the largest count as zero
SLACK = 1e-9  # share of a range by which rounding may exceed a limit
MOST_SETS = 200_000  # sets of limits that may meet at a vertex
TINY = 1e-300  # keeps divisions by zero finite


class UnlimitedError(InputError):
    """No limit of a drive bounds what is asked for."""


@dataclass(frozen=True, eq=False)
class BoxImage:
    """Solutions y = y0 + Y z with forces x = x0 + X z within limits.

    x and its limits have one unit, y another one: those of the equations.

    Attributes:
        y0: (k,) result at z = 0.
        Y: (k, d) change of y with z.
        x0: (m,) forces at z = 0.
        X: (m, d) change of x with z.
        lower: (m,) least x, minus infinity without a limit.
        upper: (m,) greatest x, infinity without a limit.
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
        half_widths = np.ones(len(self.lower))
        half_widths[limited] = 0.5 * (self.upper - self.lower)[limited]
        half_widths[half_widths == 0.0] = 1.0
        rows = (self.X / half_widths[:, None])[limited]
        _, values, directions = np.linalg.svd(rows)
        rank = _rank(values)
        # directions that no limit bounds have to leave y as it is
        change = self.Y @ directions[rank:].T
        largest = np.abs(self.Y).max(initial=0.0)
        if np.abs(change).max(initial=0.0) > SLACK * largest:
            raise UnlimitedError("no limit of a drive bounds it")
        if not self.is_possible:
            return np.zeros((0, len(self.y0))), np.zeros((0, len(self.x0)))
        bounded = directions[:rank].T
        low = ((self.lower - self.x0) / half_widths)[limited]
        high = ((self.upper - self.x0) / half_widths)[limited]
        z = _corners(rows @ bounded, low, high) @ bounded.T
        return self.y0 + z @ self.Y.T, self.x0 + z @ self.X.T


def solutions(A: Array, K: Array, r: Array, lower: Array, upper: Array) -> BoxImage:
    """All solutions of A x = r + K y.

    Args:
        A: (n, m) what the equations take of each x.
        K: (n, k) what each y adds to them.
        r: (n,) right side without y.
        lower: (m,) least x, minus infinity without a limit.
        upper: (m,) greatest x, infinity without a limit.

    Returns:
        The image of the limits, with d free directions.
    """
    m, k = A.shape[1], K.shape[1]
    limited = np.isfinite(lower) & np.isfinite(upper)
    widths = np.where(limited, upper - lower, 0.0)
    largest = float(widths.max(initial=0.0)) or 1.0
    # without these scales the rank would depend on the units of equations, x and y
    sizes = np.where(widths > 0.0, widths, largest)
    matrix = np.hstack([A * sizes, -K])
    rows = np.maximum(np.abs(matrix[:, :m]).max(axis=1, initial=0.0), TINY)
    matrix /= rows[:, None]
    columns = np.abs(matrix[:, m:]).max(axis=0, initial=0.0)
    scales = 1.0 / np.where(columns > 0.0, columns, 1.0)
    units = np.concatenate([np.ones(m), scales])
    scaled = matrix * units
    U, values, Vt = np.linalg.svd(scaled)
    rank = _rank(values)
    right = r / rows
    particular = Vt[:rank].T @ ((U.T @ right)[:rank] / values[:rank])
    missing = np.abs(scaled @ particular - right).max(initial=0.0)
    size = max(np.abs(right).max(initial=0.0), 1.0)
    back = units * np.concatenate([sizes, np.ones(k)])
    solution = back * particular
    free = back[:, None] * Vt[rank:].T
    return BoxImage(
        y0=solution[m:],
        Y=free[m:],
        x0=solution[:m],
        X=free[:m],
        lower=lower,
        upper=upper,
        is_possible=bool(missing <= SLACK * size),
    )


def _rank(values: Array) -> int:
    """Number of singular values (n,) that do not count as zero."""
    return int((values > RANK * values.max(initial=0.0)).sum())


def _corners(rows: Array, low: Array, high: Array) -> Array:
    """Vertices (v, d) of low <= rows z <= high, whose rows (m, d) have full rank."""
    count, d = rows.shape
    if not d:
        inside = (low <= SLACK).all() and (high >= -SLACK).all()
        return np.zeros((int(inside), 0))
    sets = np.array(list(combinations(range(count), d)))
    if len(sets) * 2**d > MOST_SETS:
        raise InputError(f"{count} limits in {d} directions have too many vertices")
    matrices = rows[sets]  # (sets, d, d)
    sizes = np.linalg.norm(matrices, axis=2, keepdims=True)
    unit = matrices / np.maximum(sizes, TINY)
    regular = np.abs(np.linalg.det(unit)) > RANK
    sets, matrices = sets[regular], matrices[regular]
    points: list[Array] = []
    for ends in product((False, True), repeat=d):
        right = np.where(ends, high[sets], low[sets])
        solved = np.linalg.solve(matrices, right[..., None])
        points.append(solved[..., 0])
    z = np.concatenate(points)
    along = z @ rows.T
    within = (along >= low - SLACK) & (along <= high + SLACK)
    return np.asarray(z[within.all(axis=1)])
