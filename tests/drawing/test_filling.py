"""Maps of a workspace: their outline is that of the workspace, their values are the least."""

from functools import cache

import numpy as np
import pytest

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.drawing.maps.interpolate import CellMap, filled_maps
from hybrid_dynamics_core.drawing.maps.planes import choose_planes
from hybrid_dynamics_core.drawing.maps.workspace import values_of
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.kinematics.workspace import Margins, margins_at

from .conftest import robot_of

ARM = """
format: 1
name: two_links
links: {base: {}, upper: {}, fore: {}}
joints:
  q1: {type: revolute, parent: base, child: upper, axis: y, limits: [-pi, pi]}
  q2:
    {type: revolute, parent: upper, child: fore, origin: {xyz: [1, 0, 0]}, axis: y,
     limits: [0.5, pi/2]}
active: [q1, q2]
end_effector: {link: fore, xyz: [0.6, 0, 0]}
reference: {q2: 1}
"""
# [m] what q2 lets the arm reach
INNER = np.sqrt(1.36)
OUTER = np.sqrt(1.36 + 1.2 * np.cos(0.5))


@cache
def map_of(name: str, count: int) -> tuple[Robot, CellMap]:
    robot = Robot(parse_description(ARM)) if name == "two_links" else robot_of(name)
    return robot, new_map(robot, count)


def new_map(robot: Robot, count: int) -> CellMap:
    """The map of a workspace of some samples."""
    (plane,) = choose_planes(robot)
    workspace = robot.workspace(count)
    (drawn,) = filled_maps(robot, workspace, [plane.points], singularity_of)
    return drawn


def singularity_of(samples: Margins) -> np.ndarray:
    return values_of(samples, "singularity")


def test_the_outline_is_that_of_the_workspace() -> None:
    """A ring: every cell that is inside the map is, and all but few on its edges are in the map."""
    _, drawn = map_of("two_links", 4_000)
    x, y = drawn.outline.middles
    radius = np.hypot(x[:, None], y[None])
    half = drawn.outline.size / np.sqrt(2.0)  # from the middle of a cell to its corner
    ring = (radius > INNER - half) & (radius < OUTER + half)
    assert not (drawn.inside & ~ring).any()  # no reach that is not there
    within = (radius > INNER + half) & (radius < OUTER - half)
    assert (within & ~drawn.inside).sum() < 2e-3 * within.sum()  # the search is by chance
    assert drawn.outline.size < 0.01 * 2.0 * OUTER


def test_no_cell_inside_is_far_from_a_place_that_was_reached() -> None:
    """Of an arm with concave edges, where closing gaps could invent reach: cells against a grid."""
    robot, drawn = map_of("excavator", 8_000)
    low, high = robot.limits[1:].T
    places = np.meshgrid(*np.linspace(low, high, 60).T, indexing="ij")
    grid = np.stack(places, axis=-1).reshape(-1, 3)
    (plane,) = choose_planes(robot)
    column = np.full(len(grid), robot.reference[0])
    samples = margins_at(robot, np.column_stack([column, grid]))
    points = plane.points(samples)[samples.reachable]
    index = np.floor((points - drawn.outline.low) / drawn.outline.size).astype(int)
    reached = np.zeros(drawn.outline.shape, dtype=bool)
    reached[index[:, 0], index[:, 1]] = True
    # Cells that the edge cuts may stay out.
    assert (reached & ~drawn.inside).sum() < 1e-2 * reached.sum()
    near = np.zeros_like(reached)
    for a in range(-2, 3):  # two cells, which the grid may leave between its own places
        for b in range(-2, 3):
            near |= np.roll(reached, (a, b), (0, 1))
    assert (drawn.inside & ~near).sum() < 5e-3 * drawn.inside.sum()


def test_values_are_the_least_behind_a_point() -> None:
    robot, drawn = map_of("excavator", 8_000)
    (plane,) = choose_planes(robot)
    samples = robot.workspace(60_000).samples  # by chance alone, many more than the map began with
    good = samples.reachable
    places = plane.points(samples)[good] - drawn.grid.low
    index = np.floor(places / drawn.grid.size).astype(int)
    least = np.full(drawn.grid.shape, np.inf)
    np.minimum.at(least, (index[:, 0], index[:, 1]), samples.singularity[good])
    both = np.isfinite(least) & np.isfinite(drawn.values)
    worse = (drawn.values - least)[both]
    assert both.sum() > 1_000
    assert np.mean(worse > 0.01) < 0.02  # values go up to 0.3: a step of the colours is 0.015
    assert np.mean(worse < 0.0) > 0.5  # the map finds lower ones in most cells


def test_the_same_call_gives_the_same_map() -> None:
    robot, drawn = map_of("two_links", 4_000)
    repeated = new_map(robot, 4_000)
    assert np.array_equal(repeated.inside, drawn.inside)
    assert repeated.values == pytest.approx(drawn.values, nan_ok=True, abs=0.0)
