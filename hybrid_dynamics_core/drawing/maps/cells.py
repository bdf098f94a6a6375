"""Cells of a map, each with its best sample, from which new samples start.

This is MAP-Elites, Mouret and Clune 2015 (arXiv 1504.04909). A cell is filled only by a sample that
closes within all limits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ...ground.arrays import Array
from ...kinematics.workspace import Margins

Mask = NDArray[np.bool_]
Indices = NDArray[np.int64]
# (N,) values of samples; a cell keeps the smallest; NaN excludes a sample
Score = Callable[[Margins], Array]
Placement = Callable[[Margins], Array]  # (N, 2) positions of samples on the map [m]

_PATIENCE: Final = 20  # rounds without improvement near a cell after which it stops
_GAIN: Final = 5e-3  # least improvement, as a share of the range of values
_FINE, _COARSE = -3.5, -0.7  # decimal exponents of step widths, as shares of the ranges
_NEAR: Final = 2  # [cells] largest distance of neighbours for steps along their line
_EDGE: Final = 0.06  # share of a map's width, as margin about the first samples
_ROOM: Final = 3.0  # [cells] added to this margin


@dataclass(frozen=True, eq=False)
class Grid:
    """Square cells.

    Attributes:
        low: (2,) lower left corner [m].
        size: size of a cell [m].
        shape: number of cells in both directions.
    """

    low: Array
    size: float
    shape: tuple[int, int]

    @classmethod
    def about(cls, points: Array, longer: float) -> Grid:
        """A grid around points (N, 2) [m] with a margin, with `longer` cells on the longer side."""
        span = np.maximum(np.ptp(points, axis=0), 1e-9)
        size = float(span.max() / longer)
        room = _EDGE * span + _ROOM * size
        count = np.ceil((span + 2.0 * room) / size)
        across, up = count.astype(int).tolist()
        return cls(points.min(axis=0) - room, size, (across, up))

    def finer(self, times: int) -> Grid:
        """A grid with every cell divided into `times` by `times` cells."""
        across, up = self.shape
        return Grid(self.low, self.size / times, (across * times, up * times))

    @property
    def middles(self) -> tuple[Array, Array]:
        """Middles of the cells in both directions [m]."""
        x = self.low[0] + self.size * (np.arange(self.shape[0]) + 0.5)
        y = self.low[1] + self.size * (np.arange(self.shape[1]) + 0.5)
        return x, y


class Cells:
    """The cells of a grid with their best samples.

    Args:
        grid: grid of the cells.
        placement: function from samples to their positions on the map.
        score: function from samples to values; the smallest is the best.
        samples: the first samples.
    """

    def __init__(
        self,
        grid: Grid,
        placement: Placement,
        score: Score,
        samples: Margins,
    ) -> None:
        self.grid = grid
        self._placement = placement
        self._score = score
        count = grid.shape[0] * grid.shape[1]
        self._best = np.full(count, np.inf)
        self._rounds = np.zeros(count, dtype=np.int64)  # remaining rounds of each cell
        self._u = np.zeros((count, samples.u.shape[1]))
        values = score(samples)
        self._gain = _GAIN * float(np.ptp(values[np.isfinite(values)]))
        self.add(samples)

    @property
    def values(self) -> Array:
        """(shape) the smallest value in every cell; NaN in empty cells."""
        values = np.where(np.isfinite(self._best), self._best, np.nan)
        return values.reshape(self.grid.shape)

    @property
    def filled(self) -> Mask:
        """(shape) mask of cells with a sample."""
        return np.asarray(np.isfinite(self._best).reshape(self.grid.shape))

    @property
    def u(self) -> Array:
        """(K, n) active coordinates of the best samples."""
        return np.asarray(self._u[np.isfinite(self._best)])

    def add(self, samples: Margins) -> None:
        """Store the best sample of each cell."""
        values = self._score(samples)
        index = np.floor((self._placement(samples) - self.grid.low) / self.grid.size)
        within = ((index >= 0.0) & (index < self.grid.shape)).all(axis=1)
        rows = np.flatnonzero(np.isfinite(values) & within)
        cells = index[rows].astype(np.int64) @ np.array([self.grid.shape[1], 1])
        order = np.lexsort((values[rows], cells))
        cells, first = np.unique(cells[order], return_index=True)
        rows = rows[order][first]
        gains = values[rows] < self._best[cells] - self._gain
        self._rounds[cells[gains]] = _PATIENCE
        better = values[rows] < self._best[cells]
        cells, rows = cells[better], rows[better]
        self._best[cells] = values[rows]
        self._u[cells] = samples.u[rows]

    def stop(self, which: Mask) -> None:
        """Take no more steps from the cells of a mask (shape)."""
        self._rounds[which.ravel()] = 0

    def steps(self, box: Array, most: int, rng: np.random.Generator) -> Array:
        """New samples, one from each cell that is not stopped.

        A third of the steps goes along the line through a neighbour's sample. A third goes in a
        random direction, with some coordinates constant, so that samples can stay on limits. A
        third is the sum of two such steps.

        Args:
            box: (n, 2) ranges of the samples [rad or m].
            most: number of samples, at most.
            rng: random numbers.

        Returns:
            (M, n) active coordinates.
        """
        cells = np.flatnonzero(self._rounds > 0)
        if len(cells) > most:
            cells = rng.choice(cells, most, replace=False)
        self._rounds[cells] -= 1
        u = self._u[cells]
        column = (len(cells), 1)
        neighbours = self._u[self._beside(cells, rng)]
        line = (u - neighbours) * rng.uniform(-2.0, 2.0, column)
        width = 10.0 ** rng.uniform(_FINE, _COARSE, column) * np.ptp(box, axis=1)
        direction = width * rng.standard_normal(u.shape)
        free = direction * (rng.random(u.shape) < 0.5)
        kind = rng.integers(0, 3, column)
        moved = u + (kind != 1) * line + (kind != 0) * free
        return np.asarray(np.clip(moved, *box.T))

    def _beside(self, cells: Indices, rng: np.random.Generator) -> Indices:
        """For each cell, a filled cell near it, or the cell itself."""
        across, up = self.grid.shape
        offsets = rng.integers(-_NEAR, _NEAR + 1, (2, len(cells)))
        near = np.stack(np.divmod(cells, up)) + offsets
        rows = np.clip(near[0], 0, across - 1)
        columns = np.clip(near[1], 0, up - 1)
        others = rows * up + columns
        return np.where(np.isfinite(self._best[others]), others, cells)
