"""A map of stiffness: how far a frame gives way over the places that two joints move it to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..description.elasticity import Elasticity
from ..errors import InputError, SingularityError
from ..ground.arrays import Array
from ..ground.check_arguments import integer
from ..ground.check_arrays import finite_vectors, real_array
from ..ground.suggestions import no_such_name
from .drive_springs import PistonError
from .robot_interface import ElasticRobot
from .stiffness import Stiffness

INSET = 1e-6  # share of a range, since rounding may put its very ends outside


@dataclass(frozen=True, eq=False)
class StiffnessMap:
    """Deflections of a frame over two joints, in a grid of c by c states.

    Attributes:
        joints: names of the two joints that move.
        u: (c, c, n) active coordinates [rad, m].
        position: (c, c, 3) of the frame [m]; NaN where the robot cannot be.
        deflection: (c, c) how far the frame's origin moves under the force [m]; NaN where the
            drives do not hold it, or a piston is beyond its stroke.
        largest_share: (c, c) index in `elements` of the element that holds most energy; -1 where
            there is none.
        elements: names of the elastic elements.
        force: (3,) the force, base axes [N].
    """

    joints: tuple[str, str]
    u: Array
    position: Array
    deflection: Array
    largest_share: np.ndarray
    elements: tuple[str, ...]
    force: Array


def stiffness_map(  # noqa: PLR0913 - options of one map
    robot: ElasticRobot,
    joints: tuple[str, str],
    force: ArrayLike,
    *,
    u: ArrayLike | None = None,
    elasticity: Elasticity | None = None,
    frame: str | None = None,
    cells: int = 16,
) -> StiffnessMap:
    """How far a frame gives way under a force on it, over two joints.

    Args:
        robot: the robot.
        joints: the two active joints that move, over their limits.
        force: (3,) on the frame, base axes [N].
        u: (n,) where the other active joints stay [rad, m]; the reference if None.
        elasticity: compliance of drives, pins and links; that of the description if None.
        frame: name of the frame; the end effector if None.
        cells: number of states along each joint.

    Raises:
        InputError: a name is unknown or given twice, a joint has no limits, or nothing is elastic.
    """
    load = real_array("force", force)
    if load.shape != (3,) or not np.isfinite(load).all():
        raise InputError(f"force has shape {load.shape}; expected 3 finite numbers")
    count = integer("cells", cells, 2)
    start = robot.reference
    if u is not None:
        start = finite_vectors("u", u, robot.active, -1)
    grid = _grid(robot, joints, start, count)
    place = np.full((*grid.shape[:2], 3), np.nan)
    moved = np.full(grid.shape[:2], np.nan)
    leading = np.full(grid.shape[:2], -1)
    elements: tuple[str, ...] = ()
    batch = robot.close(grid.reshape(-1, len(start)), check=False)
    status = np.reshape(batch.status, grid.shape[:2])
    for index in zip(*np.nonzero(status == 0), strict=True):
        state = robot.close(grid[index])
        try:
            stiffness = Stiffness(robot, state, elasticity, frame)
        except (PistonError, SingularityError):  # no oil, or nothing holds it here
            continue
        elements = stiffness.elements
        under = stiffness.under(load)
        place[index] = stiffness.position
        moved[index] = under.distance
        energies = [under.energy_by_element[name] for name in elements]
        leading[index] = int(np.argmax(energies))
    return StiffnessMap(joints, grid, place, moved, leading, elements, load)


def _grid(robot: ElasticRobot, joints: tuple[str, str], start: Array, count: int) -> Array:
    """States (c, c, n) over the limits of two joints."""
    given = [*joints]
    if len(given) != 2 or given[0] == given[1]:
        raise InputError(f"joints: {joints!r}; expected two different joints that move")
    lines: list[Array] = []
    columns: list[int] = []
    for name in joints:
        if name not in robot.active:
            raise InputError(f"joints: {no_such_name('active joint', name, robot.active)}")
        k = robot.active.index(name)
        low, high = robot.limits[k]
        if not np.isfinite(high - low):
            raise InputError(f"joints: '{name}' has no limits; expected a joint with limits")
        inset = INSET * (high - low)
        lines.append(np.linspace(low + inset, high - inset, count))
        columns.append(k)
    first, second = np.meshgrid(*lines, indexing="ij")
    grid = np.tile(start, (count, count, 1))
    grid[..., columns[0]] = first
    grid[..., columns[1]] = second
    return grid
