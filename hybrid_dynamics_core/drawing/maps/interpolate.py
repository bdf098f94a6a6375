"""Maps from samples of a workspace, with further samples to close gaps and refine the outline."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.ndimage import binary_closing, binary_erosion

from ...ground.arrays import Array
from ...ground.progress import Progress
from ...kinematics.workspace import Margins, Workspace, margins_at
from ...robot.robot import Robot
from .cells import Cells, Grid, Mask, Placement, Score

_LONGER_SIDE: Final = (40, 240)  # least and largest number of cells on the longer side of a map
_FINER: Final = 3  # outline cells per side of a map cell
_SAMPLES_PER_CELL: Final = 5.0  # average over the bounding square of a map
_ROUND: Final = 20_000  # largest number of samples in one round
_DEPTH: Final = 2  # [outline cells] depth inside the filled region beyond which no steps start
_EDGE_WIDTH: Final = 2  # [map cells] width of the edge region in which the outline is refined
# [outline cells] half the width of gaps that count as sampling gaps
_GAP_HALF_WIDTH: Final = 2


@dataclass(frozen=True)
class _Effort:
    """Budgets of samples, as multiples of the workspace's samples.

    Attributes:
        cells: number of samples that the cell size is chosen for.
        colours: largest number of further samples for colours.
        outline: largest number of further samples for the outline.
    """

    cells: float
    colours: float
    outline: float


_DIRECT: Final = _Effort(8.0, 8.0, 8.0)
# Loops closed by iteration are slow. The workspace's own samples suffice for most colours, but less
# for the outline.
_FOLLOWING: Final = _Effort(1.0, 0.4, 0.6)


@dataclass(frozen=True, eq=False)
class CellMap:
    """A map in two grids: coarse cells with values, and fine ones for the outline.

    Attributes:
        grid: the coarse cells.
        values: (N, M) of the coarse cells; NaN in empty cells.
        outline: the fine cells.
        inside: mask of the fine cells that were reached.
    """

    grid: Grid
    values: Array
    outline: Grid
    inside: Mask

    @property
    def places(self) -> Array:
        """(N, 2) middles [m] of the fine cells that were reached."""
        x, y = self.outline.middles
        rows, columns = np.nonzero(self.inside)
        return np.stack([x[rows], y[columns]], axis=1)


def filled_maps(
    robot: Robot,
    workspace: Workspace,
    placements: Sequence[Placement],
    score: Score,
) -> list[CellMap]:
    """Maps of a workspace, with further samples in addition to its own.

    Sampling ends when no cell improves, or at a budget in proportion to the workspace's samples.
    The same call gives the same maps.

    Args:
        robot: robot of the workspace.
        workspace: a workspace with reachable samples.
        placements: for each map, the function from samples to places.
        score: function from samples to values; a cell shows its smallest.

    Returns:
        A map for each placement.
    """
    effort = _FOLLOWING if robot.follows else _DIRECT
    budgets = int(effort.colours * workspace.count), int(effort.outline * workspace.count)
    cell_count = effort.cells * workspace.count / (_SAMPLES_PER_CELL * len(placements))
    longer = float(np.clip(np.sqrt(cell_count), *_LONGER_SIDE))
    reached = workspace.samples.reachable
    grids = [Grid.about(place(workspace.samples)[reached], longer) for place in placements]
    with Progress(f"map of {robot.name}", sum(budgets)) as progress:
        search = _Search(robot, workspace, placements, progress)
        maps = search.fill_colours(grids, score, budgets[0])
        cores = [_core(cells.filled) for cells in maps]
        rims = search.fill_outlines(maps, cores, *budgets)
    filled = []
    for cells, rim, core in zip(maps, rims, cores, strict=True):
        inside = binary_closing(core | rim.filled, iterations=_GAP_HALF_WIDTH) | core
        filled.append(CellMap(cells.grid, cells.values, rim.grid, inside))
    return filled


class _Search:
    """Rounds of samples of one robot for all maps."""

    def __init__(
        self,
        robot: Robot,
        workspace: Workspace,
        placements: Sequence[Placement],
        progress: Progress,
    ) -> None:
        self._robot = robot
        self._workspace = workspace
        self._placements = placements
        self._progress = progress
        self._rng = np.random.default_rng(0)

    def fill_colours(self, grids: Sequence[Grid], score: Score, budget: int) -> list[Cells]:
        """The cells of maps, filled with the workspace's samples and at most `budget` more."""
        maps = self._cells(grids, score)
        cores = [np.zeros(grid.shape, dtype=np.bool_) for grid in grids]
        self._run(maps, cores, 0, budget)
        return maps

    def fill_outlines(
        self,
        maps: Sequence[Cells],
        cores: Sequence[Mask],
        before: int,
        budget: int,
    ) -> list[Cells]:
        """Finer cells of the same maps, filled with at most `budget` more samples.

        Args:
            maps: the coarse cells, filled.
            cores: masks of fine cells away from the edge, where no steps start.
            before: number of samples that were taken for the coarse cells.
            budget: largest number of samples.
        """
        rims = self._cells([cells.grid.finer(_FINER) for cells in maps], _reachable_score)
        if before:
            samples = self._margins(np.concatenate([cells.u for cells in maps]))
            for cells in rims:
                cells.add(samples)
        self._run(rims, cores, before, budget)
        return rims

    def _cells(self, grids: Sequence[Grid], score: Score) -> list[Cells]:
        samples = self._workspace.samples
        pairs = zip(grids, self._placements, strict=True)
        return [Cells(grid, placement, score, samples) for grid, placement in pairs]

    def _margins(self, u: Array) -> Margins:
        return margins_at(self._robot, u, self._workspace.frame)

    def _run(
        self,
        maps: Sequence[Cells],
        cores: Sequence[Mask],
        before: int,
        budget: int,
    ) -> None:
        """Sample in rounds until all cells have stopped, or `budget` samples are taken."""
        taken = 0
        while taken < budget:
            most = min(_ROUND, budget - taken) // len(maps) + 1
            _stop_inside(maps, cores)
            box = self._workspace.ranges
            u = np.concatenate([cells.steps(box, most, self._rng) for cells in maps])
            if not len(u):
                return
            samples = self._margins(u)
            for cells in maps:
                cells.add(samples)
            taken += len(u)
            self._progress.update(before + taken)


def _stop_inside(maps: Sequence[Cells], cores: Sequence[Mask]) -> None:
    """Stop steps from cores and, if there are cores, from cells deep inside."""
    for cells, core in zip(maps, cores, strict=True):
        deep = binary_erosion(cells.filled, iterations=_DEPTH)
        cells.stop(core | (deep & core.any()))


def _core(filled: Mask) -> Mask:
    """Mask of fine cells away from the edge of the filled region."""
    inner = binary_erosion(binary_closing(filled), iterations=_EDGE_WIDTH)
    return np.asarray(np.kron(inner, np.ones((_FINER, _FINER), dtype=np.bool_)))


def _reachable_score(samples: Margins) -> Array:
    """Zero for samples within all limits, NaN for others, to find only what is reachable."""
    return np.where(samples.reachable, 0.0, np.nan)
