"""Tracking the solutions of quadrics while the geometry of the legs changes.

All paths are followed at once, each with its own step. A step is a predictor of fourth order, and
Newton's method on the hyperplane through the previous point.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...ground.arrays import Array
from .study import Complex, Legs, quadrics

FIRST_STEP = 0.05  # share of the way
SHORTEST = 1e-10  # a path whose steps become shorter is given up
MOST_STEPS = 1500
CORRECTIONS = 3
CLOSE = 1e-6  # last correction, relative to the point, that ends a step
FAR = 1e-2  # first correction that makes the step fail: another path may be near
PATIENCE = 3  # steps without failure before the step is doubled


class Ends(NamedTuple):
    """Where paths ended.

    Attributes:
        points: unit vectors (n, 8).
        arrived: whether each path came to the end of the way (n,).
    """

    points: Complex
    arrived: NDArray[np.bool_]


class _Values(NamedTuple):
    """Values, Jacobians and derivatives along the way, of points (n, 8)."""

    residuals: Complex
    jacobians: Complex
    rates: Complex


class PathTracker:
    """Follows solutions of k quadrics in k + 1 coordinates that change along a way.

    The quadrics are of degree two in the share of the way, so that three of them determine the
    others.
    """

    def __init__(
        self,
        first: NDArray[np.inexact],
        middle: NDArray[np.inexact],
        last: NDArray[np.inexact],
        closeness: float = CLOSE,
    ) -> None:
        """Take the matrices (k, k + 1, k + 1) at the start, in the middle and at the end.

        Args:
            first: those whose solutions are given.
            middle: those half the way.
            last: those whose solutions are wanted.
            closeness: tolerance of Newton's method in a step.
        """
        self._closeness = closeness
        self._count, self._size, _ = first.shape
        second = 2.0 * (first + last) - 4.0 * middle
        linear = last - first - second
        powers = np.stack([first, linear, second])
        rows = powers.reshape(-1, self._size)
        self._matrix = rows.T.astype(complex)

    @classmethod
    def between(cls, start: Legs, target: Legs, closeness: float = CLOSE) -> PathTracker:
        """From legs whose solutions are given to others, on the straight line between them."""
        middle = start.towards(target, 0.5)
        return cls(quadrics(start), quadrics(middle), quadrics(target), closeness)

    def ends(self, starts: Complex) -> Ends:
        """Follow the paths from points (n, 8) to the end of the way."""
        paths = _Paths(starts)
        for _ in range(MOST_STEPS):
            active = paths.active()
            if not len(active):
                break
            self._advance(paths, active)
        return Ends(paths.points, paths.places >= 1.0)

    def _advance(
        self,
        paths: _Paths,
        active: NDArray[np.intp],
    ) -> None:
        points, places = paths.points[active], paths.places[active]
        steps = np.minimum(paths.steps[active], 1.0 - places)
        across = points.conj()
        ahead = places + steps
        predicted = self._predicted(points, places, steps)
        succeeded, corrected = self._corrected(predicted, ahead, across)
        paths.accept(
            active[succeeded],
            corrected[succeeded],
            ahead[succeeded],
        )
        paths.shorten(active[~succeeded], steps[~succeeded])

    def _predicted(
        self,
        points: Complex,
        places: Array,
        steps: Array,
    ) -> Complex:
        """Runge and Kutta's rule of fourth order."""
        across = points.conj()
        step = steps[:, None]
        half = places + 0.5 * steps
        first = self._slopes(points, places, across)
        second = self._slopes(points + 0.5 * step * first, half, across)
        third = self._slopes(points + 0.5 * step * second, half, across)
        fourth = self._slopes(points + step * third, places + steps, across)
        total = first + 2.0 * (second + third) + fourth
        predicted: Complex = points + step / 6.0 * total
        return predicted

    def _corrected(
        self, points: Complex, places: Array, across: Complex
    ) -> tuple[NDArray[np.bool_], Complex]:
        """Whether Newton's method came to an end near each point, and where."""
        allowed = FAR
        succeeded = np.ones(len(points), dtype=bool)
        sizes = np.full(len(points), np.inf)
        for _ in range(CORRECTIONS):
            values = self._values(points, places)
            beside = 1.0 - (across * points).sum(axis=1)
            steps = _solved(values.jacobians, across, -values.residuals, beside)
            points = points + steps
            sizes = np.linalg.norm(steps, axis=1)
            succeeded &= sizes < allowed
            allowed = np.inf
        succeeded &= sizes < self._closeness
        return succeeded, points

    def _slopes(
        self,
        points: Complex,
        places: Array,
        across: Complex,
    ) -> Complex:
        values = self._values(points, places)
        return _solved(
            values.jacobians,
            across,
            -values.rates,
            np.zeros(len(points)),
        )

    def _values(self, points: Complex, places: Array) -> _Values:
        count = len(points)
        shape = (count, 3, self._count, self._size)
        powers = np.reshape(points @ self._matrix, shape)
        constant, linear, second = np.moveaxis(powers, 1, 0)
        place = places[:, None, None]
        products = constant + place * (linear + place * second)
        changes = linear + 2.0 * place * second
        columns = points[:, :, None]
        residuals = (products @ columns)[..., 0]
        rates = (changes @ columns)[..., 0]
        return _Values(residuals, 2.0 * products, rates)


class _Paths:
    """The state of all paths."""

    def __init__(self, starts: Complex) -> None:
        count = len(starts)
        self.points = _unit(starts)
        self.places = np.zeros(count)
        self.steps = np.full(count, FIRST_STEP)
        self._successes = np.zeros(count, dtype=int)

    def active(self) -> NDArray[np.intp]:
        """Paths that go on."""
        return np.flatnonzero((self.places < 1.0) & (self.steps > SHORTEST))

    def accept(
        self,
        paths: NDArray[np.intp],
        points: Complex,
        places: Array,
    ) -> None:
        """Move paths forward."""
        self.points[paths] = _unit(points)
        self.places[paths] = np.where(
            places > 1.0 - 1e-14,
            1.0,
            places,
        )
        self._successes[paths] += 1
        longer = paths[self._successes[paths] >= PATIENCE]
        self.steps[longer] *= 2.0
        self._successes[longer] = 0

    def shorten(
        self,
        paths: NDArray[np.intp],
        steps: Array,
    ) -> None:
        """Halve the steps of paths."""
        self.steps[paths] = 0.5 * steps
        self._successes[paths] = 0


def polished(
    matrices: NDArray[np.inexact],
    points: Complex,
) -> Complex:
    """Newton's method at fixed quadrics (7, 8, 8), from points (n, 8) to unit vectors."""
    for _ in range(4):
        across = points.conj()
        products = np.einsum("ijk,nk->nij", matrices, points)
        residuals = (products @ points[:, :, None])[..., 0]
        steps = _solved(
            2.0 * products,
            across,
            -residuals,
            np.zeros(len(points)),
        )
        points = _unit(points + steps)
    return points


def _unit(points: Complex) -> Complex:
    sizes = np.linalg.norm(points, axis=1)
    unit: Complex = points / sizes[:, None]
    return unit


def _solved(
    jacobians: Complex, across: Complex, values: Complex, beside: NDArray[np.inexact]
) -> Complex:
    """Steps (n, 8) that change the quadrics by `values` and the component along a point."""
    matrices = np.concatenate(
        [jacobians, across[:, None, :]],
        axis=1,
    )
    vectors = np.concatenate(
        [values, beside[:, None]],
        axis=1,
    )[..., None]
    try:
        solved: Complex = np.linalg.solve(
            matrices,
            vectors,
        )[..., 0]
    except np.linalg.LinAlgError:  # exactly singular, as at a target with a special geometry
        solved = (np.linalg.pinv(matrices) @ vectors)[..., 0]
    return solved
