"""Cells of a map: each keeps the sample that counts there, and steps from those kept find samples for their neighbours.

The idea is that of illumination by elites, Mouret and Clune 2015 (arXiv 1504.04909). A cell is
known only where a sample was closed within all limits: a map shows nothing that was not reached.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ...ground.arrays import Array
from ...kinematics.workspace import Margins

Judge = Callable[
    [Margins], Array
]  # (N,) of which a cell keeps the least; NaN for samples that do not count
Place = Callable[[Margins], Array]  # (N, 2) where samples are on the map [m]

_PATIENCE: Final = 20  # rounds in which nothing better is found about a cell, before it is left
_GAIN: Final = 5e-3  # of the range of what is kept: less is nothing better
_FINE, _COARSE = -3.5, -0.7  # powers of ten of the ranges: widths of the steps
_NEAR: Final = 2  # cells: how far off the neighbours are along whose line a step goes
_EDGE: Final = 0.06  # of a map: room about the first samples


@dataclass(frozen=True, eq=False)
class Grid:
    """Square cells of a size [m] from a corner low (2,) [m]; shape: how many there are in both directions."""

    low: Array
    size: float
    shape: tuple[int, int]

    @classmethod
    def about(cls, points: Array, longer: float) -> Grid:
        """Cells about points (N, 2) [m] with room beside them; `longer`: how many over their longer side."""
        span = np.maximum(np.ptp(points, axis=0), 1e-9)
        size = float(span.max() / longer)
        room = _EDGE * span + 3.0 * size
        across, up = np.ceil((span + 2.0 * room) / size).astype(int).tolist()
        return cls(points.min(axis=0) - room, size, (across, up))

    def finer(self, times: int) -> Grid:
        """Every cell as `times` by `times` cells."""
        return Grid(self.low, self.size / times, (self.shape[0] * times, self.shape[1] * times))

    @property
    def middles(self) -> tuple[Array, Array]:
        """Middles of the cells in both directions [m]."""
        x, y = (self.low[k] + self.size * (np.arange(self.shape[k]) + 0.5) for k in (0, 1))
        return x, y


class Cells:
    """The cells of a grid with what they keep of samples."""

    def __init__(self, grid: Grid, place: Place, judge: Judge, samples: Margins) -> None:
        self.grid, self._place, self._judge = grid, place, judge
        count = grid.shape[0] * grid.shape[1]
        self._best, self._left = np.full(count, np.inf), np.zeros(count, dtype=np.int64)
        self._u = np.zeros((count, samples.u.shape[1]))
        values = judge(samples)
        self._gain = _GAIN * float(np.ptp(values[np.isfinite(values)]))
        self.keep(samples)

    @property
    def kept(self) -> Array:
        """(shape) the least in every cell, NaN where none lies."""
        return np.where(np.isfinite(self._best), self._best, np.nan).reshape(self.grid.shape)

    @property
    def known(self) -> NDArray[np.bool_]:
        """(shape) which cells keep a sample."""
        return np.asarray(np.isfinite(self._best).reshape(self.grid.shape))

    @property
    def u(self) -> Array:
        """(K, n) active coordinates of the samples kept."""
        return np.asarray(self._u[np.isfinite(self._best)])

    def keep(self, samples: Margins) -> None:
        """Keep what is better than what its cell has."""
        values = self._judge(samples)
        index = np.floor((self._place(samples) - self.grid.low) / self.grid.size)
        rows = np.flatnonzero(
            np.isfinite(values) & ((index >= 0.0) & (index < self.grid.shape)).all(axis=1)
        )
        cells = index[rows].astype(np.int64) @ np.array([self.grid.shape[1], 1])
        order = np.lexsort((values[rows], cells))
        cells, first = np.unique(cells[order], return_index=True)
        rows = rows[order][first]
        self._left[cells[values[rows] < self._best[cells] - self._gain]] = _PATIENCE
        better = values[rows] < self._best[cells]
        self._best[cells[better]], self._u[cells[better]] = (
            values[rows[better]],
            samples.u[rows[better]],
        )

    def leave(self, which: NDArray[np.bool_]) -> None:
        """No more steps from these cells (shape)."""
        self._left[which.ravel()] = 0

    def about(self, box: Array, most: int, rng: np.random.Generator) -> Array:
        """(M, n) new samples within a box (n, 2), one from each cell that is not left yet, M at most `most`.

        A third of the steps goes along the line through a neighbour's sample, a third into any
        direction, with some coordinates kept so that what lies on a limit stays there, and a third
        is the sum of two such.
        """
        cells = np.flatnonzero(self._left > 0)
        if len(cells) > most:
            cells = rng.choice(cells, most, replace=False)
        self._left[cells] -= 1
        u = self._u[cells]
        line = (u - self._u[self._beside(cells, rng)]) * rng.uniform(-2.0, 2.0, (len(cells), 1))
        width = 10.0 ** rng.uniform(_FINE, _COARSE, (len(cells), 1)) * np.ptp(box, axis=1)
        free = width * rng.standard_normal(u.shape) * (rng.random(u.shape) < 0.5)
        kind = rng.integers(0, 3, (len(cells), 1))
        return np.asarray(np.clip(u + (kind != 1) * line + (kind != 0) * free, *box.T))

    def _beside(self, cells: NDArray[np.int64], rng: np.random.Generator) -> NDArray[np.int64]:
        """A known cell near each of these, or itself."""
        near = np.stack(np.divmod(cells, self.grid.shape[1])) + rng.integers(
            -_NEAR, _NEAR + 1, (2, len(cells))
        )
        rows, columns = (np.clip(near[k], 0, self.grid.shape[k] - 1) for k in (0, 1))
        others = rows * self.grid.shape[1] + columns
        return np.where(np.isfinite(self._best[others]), others, cells)
