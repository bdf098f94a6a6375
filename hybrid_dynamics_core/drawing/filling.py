"""From the samples of a workspace to maps without gaps and with a fine outline."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_closing, binary_erosion

from ..description.model import Array
from ..kinematics.workspace import Margins, Workspace, margins_at
from ..progress import Progress
from ..robot import Robot
from .cells import Cells, Grid, Judge, Place

_LONGER: Final = (40, 240)  # cells over the longer side of a map
_FINER: Final = 3  # cells of the outline over one of the map
_EFFORT: Final = {False: 8, True: 1}  # samples at most, of those spread evenly; fewer where loops are followed
_EACH: Final = 5.0  # samples for a cell of the square about a map, on average
_AT_ONCE: Final = 20_000  # samples in a round
_RIM: Final = 2  # cells at the edge in which the outline is looked for
_GAPS: Final = 2  # cells: half the width of the gaps between known ones that are taken as missed by chance


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

    Rounds end when no cell gets better, or with a number of samples in proportion to those of the workspace. The same
    call gives the same maps.
    """
    budget = _EFFORT[robot.follows] * workspace.count
    longer = float(np.clip(np.sqrt(budget / (_EACH * len(places))), *_LONGER))
    samples, rng = workspace.samples, np.random.default_rng(0)
    reached = samples.reachable
    with Progress(f"map of {robot.name}", 2 * budget) as progress:

        def search(maps: Sequence[Cells], left: Sequence[NDArray[np.bool_]], before: int) -> None:
            taken = 0
            while taken < budget:
                most = min(_AT_ONCE, budget - taken) // len(maps) + 1
                for cells, which in zip(maps, left, strict=True):
                    cells.leave(which)
                u = np.concatenate([cells.about(workspace.ranges, most, rng) for cells in maps])
                if not len(u):
                    return
                samples = margins_at(robot, u, workspace.frame)
                for cells in maps:
                    cells.keep(samples)
                taken += len(u)
                progress.update(before + taken)

        grids = [Grid.about(place(samples)[reached], longer) for place in places]
        maps = [Cells(grid, place, judge, samples) for grid, place in zip(grids, places, strict=True)]
        search(maps, [np.zeros(grid.shape, dtype=np.bool_) for grid in grids], 0)
        found = margins_at(robot, np.concatenate([cells.u for cells in maps]), workspace.frame)
        cores = [_core(cells.known) for cells in maps]
        fine = [Cells(grid.finer(_FINER), place, _reached, found) for grid, place in zip(grids, places, strict=True)]
        search(fine, cores, budget)
    return [
        Map(cells.grid, cells.kept, rim.grid, binary_closing(core | rim.known, iterations=_GAPS) | core)
        for cells, rim, core in zip(maps, fine, cores, strict=True)
    ]


def _core(known: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which cells of the finer grid are away from the edge of the known ones."""
    inner = binary_erosion(binary_closing(known), iterations=_RIM)
    return np.asarray(np.kron(inner, np.ones((_FINER, _FINER), dtype=np.bool_)))


def _reached(samples: Margins) -> Array:
    """Nothing but whether a sample counts."""
    return np.where(samples.reachable, 0.0, np.nan)
