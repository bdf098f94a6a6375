"""From the samples of a workspace to maps without gaps and with a fine outline."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_closing, binary_erosion

from ...ground.arrays import Array
from ...ground.progress import Progress
from ...kinematics.workspace import Margins, Workspace, margins_at
from ...robot.robot import Robot
from .cells import Cells, Grid, Judge, Place

_LONGER: Final = (40, 240)  # cells over the longer side of a map
_FINER: Final = 3  # cells of the outline over one of the map
# Samples at most for colours and for the outline, of those spread evenly. Following loops is slow:
# what is spread evenly shows much of the colours, and the outline far worse. First what cells are
# sized for.
_EFFORT: Final = {False: (8.0, 8.0, 8.0), True: (1.0, 0.4, 0.6)}
_EACH: Final = 5.0  # samples for a cell of the square about a map, on average
_AT_ONCE: Final = 20_000  # samples in a round
_DEEP: Final = 2  # cells of the outline: known ones farther inside are no place to look from
_RIM: Final = 2  # cells at the edge in which the outline is looked for
_GAPS: Final = (
    2  # cells: half the width of the gaps between known ones that are taken as missed by chance
)


@dataclass(frozen=True, eq=False)
class Map:
    """A map: values in the cells of a grid, NaN where nothing was reached, and which cells of a finer one were."""

    grid: Grid
    values: Array
    outline: Grid
    inside: NDArray[np.bool_]

    @property
    def places(self) -> Array:
        """(N, 2) middles of the cells inside [m]."""
        x, y = self.outline.middles
        rows, columns = np.nonzero(self.inside)
        return np.stack([x[rows], y[columns]], axis=1)


def filled(robot: Robot, workspace: Workspace, places: Sequence[Place], judge: Judge) -> list[Map]:
    """Maps of a workspace that has something reachable, with samples of their own beside those of the workspace.

    Rounds end when no cell gets better, or with a number of samples in proportion to those of the
    workspace. The same call gives the same maps.
    """
    most, *shares = _EFFORT[robot.follows]
    colours, outline = (int(share * workspace.count) for share in shares)
    longer = float(np.clip(np.sqrt(most * workspace.count / (_EACH * len(places))), *_LONGER))
    samples, rng = workspace.samples, np.random.default_rng(0)
    reached = samples.reachable
    with Progress(f"map of {robot.name}", colours + outline) as progress:

        def search(
            maps: Sequence[Cells], cores: Sequence[NDArray[np.bool_]], before: int, budget: int
        ) -> None:
            taken = 0
            while taken < budget:
                most = min(_AT_ONCE, budget - taken) // len(maps) + 1
                for cells, core in zip(maps, cores, strict=True):
                    cells.leave(core | (binary_erosion(cells.known, iterations=_DEEP) & core.any()))
                u = np.concatenate([cells.about(workspace.ranges, most, rng) for cells in maps])
                if not len(u):
                    return
                samples = margins_at(robot, u, workspace.frame)
                for cells in maps:
                    cells.keep(samples)
                taken += len(u)
                progress.update(before + taken)

        grids = [Grid.about(place(samples)[reached], longer) for place in places]
        maps = [
            Cells(grid, place, judge, samples) for grid, place in zip(grids, places, strict=True)
        ]
        search(maps, [np.zeros(grid.shape, dtype=np.bool_) for grid in grids], 0, colours)
        fine = [
            Cells(grid.finer(_FINER), place, _reached, samples)
            for grid, place in zip(grids, places, strict=True)
        ]
        if colours:
            found = margins_at(robot, np.concatenate([cells.u for cells in maps]), workspace.frame)
            for cells in fine:
                cells.keep(found)
        cores = [_core(cells.known) for cells in maps]
        search(fine, cores, colours, outline)
    return [
        Map(
            cells.grid,
            cells.kept,
            rim.grid,
            binary_closing(core | rim.known, iterations=_GAPS) | core,
        )
        for cells, rim, core in zip(maps, fine, cores, strict=True)
    ]


def _core(known: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which cells of the finer grid are away from the edge of the known ones."""
    inner = binary_erosion(binary_closing(known), iterations=_RIM)
    return np.asarray(np.kron(inner, np.ones((_FINER, _FINER), dtype=np.bool_)))


def _reached(samples: Margins) -> Array:
    """Nothing but whether a sample counts."""
    return np.where(samples.reachable, 0.0, np.nan)
