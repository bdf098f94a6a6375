"""From the samples of a workspace to maps without gaps and with a fine outline."""

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

_LONGER_SIDE: Final = (40, 240)  # cells over the longer side of a map: at least and at most
_FINER: Final = 3  # cells of the outline's grid along the side of one cell of the map
_SAMPLES_PER_CELL: Final = 5.0  # on average, over the square about a map
_ROUND: Final = 20_000  # samples at most in one round
_DEPTH: Final = 2  # cells of the outline's grid: no steps start deeper than that inside the filled
_EDGE_WIDTH: Final = 2  # cells at the edge of a map in which the outline is searched
# half the width, in cells of the outline's grid, of gaps that are taken as missed by chance
_GAP_HALF_WIDTH: Final = 2


@dataclass(frozen=True)
class _Effort:
    """Numbers of further samples, each as a multiple of the samples of the workspace.

    Attributes:
        cells: that the size of cells is made for.
        colours: at most, for the colours.
        outline: at most, for the outline.
    """

    cells: float
    colours: float
    outline: float


_DIRECT: Final = _Effort(8.0, 8.0, 8.0)
# Loops that are followed are slow to close. The workspace's own samples show much of the colours,
# less of the outline.
_FOLLOWING: Final = _Effort(1.0, 0.4, 0.6)


@dataclass(frozen=True, eq=False)
class CellMap:
    """A map in two grids: coarse cells with values, and fine ones for the outline.

    Attributes:
        grid: the coarse cells.
        values: of the coarse cells, NaN where nothing was reached.
        outline: the fine cells.
        inside: which of the fine cells were reached.
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
    """Maps of a workspace, with further samples beside those of the workspace.

    Rounds end when no cell gets better, or with a number of samples in proportion to those of the
    workspace. The same call gives the same maps.

    Args:
        robot: of the workspace.
        workspace: in which something is reachable.
        placements: where samples are on each map.
        score: of samples; a cell shows the least of its samples.

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
            cores: which fine cells are away from the edge: no steps start there.
            before: samples that were taken for the coarse cells.
            budget: samples at most.
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
        """Take samples in rounds, until no cell takes steps or `budget` samples are taken."""
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
    """Take no more steps from the cores, nor from cells deep inside where there are cores."""
    for cells, core in zip(maps, cores, strict=True):
        deep = binary_erosion(cells.filled, iterations=_DEPTH)
        cells.stop(core | (deep & core.any()))


def _core(filled: Mask) -> Mask:
    """Which cells of the finer grid are away from the edge of the filled ones."""
    inner = binary_erosion(binary_closing(filled), iterations=_EDGE_WIDTH)
    return np.asarray(np.kron(inner, np.ones((_FINER, _FINER), dtype=np.bool_)))


def _reachable_score(samples: Margins) -> Array:
    """Zero for samples within all limits, NaN for others: only whether cells are reached counts."""
    return np.where(samples.reachable, 0.0, np.nan)
