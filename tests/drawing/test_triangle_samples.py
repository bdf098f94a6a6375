"""Large triangles are filled row by row: the same samples as of points all over them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core.drawing.paint import triangle_samples
from tests.sampling import examples

SHAPE = (60, 80)  # rows and columns
FACES = np.array([[0, 1, 2]])


def depths_of(corners: np.ndarray) -> np.ndarray:
    """An image (60, 80) of the depths of a triangle, row by row."""
    image = np.full(SHAPE, -np.inf)
    for rows, columns, depths in triangle_samples.bands(corners, SHAPE):
        image[rows, columns] = depths
    return image


def points_in(corners: np.ndarray, count: int = 200) -> np.ndarray:
    """Points (n, 3) all over a triangle, its corners among them."""
    one, other = np.meshgrid(np.linspace(0.0, 1.0, count), np.linspace(0.0, 1.0, count))
    inside = one + other <= 1.0
    weights = np.stack([1.0 - one - other, one, other], axis=2)[inside]
    return weights @ corners


@examples(64)
@given(
    corners=st.lists(
        st.tuples(st.floats(1.0, 78.0), st.floats(1.0, 58.0), st.floats(-5.0, 5.0)),
        min_size=3,
        max_size=3,
    ),
    band=st.sampled_from((1, 500, 200_000)),
)
def test_samples_and_depths_are_those_of_points_on_the_triangle(corners, band) -> None:
    triangle = np.array(corners)
    sides = triangle[1:, :2] - triangle[0, :2]
    if abs(np.linalg.det(sides)) < 50.0:
        return  # such a one is sampled by points
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(triangle_samples, "_BAND", band)
        depths = depths_of(triangle)
    points = points_in(triangle)
    columns, rows = points[:, 0].astype(int), points[:, 1].astype(int)
    gradient = np.linalg.solve(sides, triangle[1:, 2] - triangle[0, 2])
    within = np.abs(gradient).sum() / 2.0 + 1e-9  # from a corner of a sample to its centre
    assert np.all(np.abs(depths[rows, columns] - points[:, 2]) <= within)
    touched = np.zeros(SHAPE, bool)
    touched[rows, columns] = True
    # those that only a corner touches fall between the points
    near = np.pad(touched, 1)
    near = near[:-2, 1:-1] | near[2:, 1:-1] | near[1:-1, :-2] | near[1:-1, 2:] | touched
    assert not np.any(np.isfinite(depths) & ~near)


@examples(64)
@given(shift=st.floats(0.0, 1.0), size=st.floats(80.0, 200.0), turned=st.booleans())
def test_both_ways_show_the_same_depths(shift: float, size: float, turned: bool) -> None:
    triangle = np.array([[0.0, 0.0, 1.0], [size, 3.0, 2.0], [5.0, size, -1.0]]) + shift
    triangle = triangle[[0, 2, 1]] if turned else triangle
    shape = (int(size) + 3, int(size) + 3)
    assert triangle_samples.are_large(triangle, FACES)[0]
    image = np.full(shape, -np.inf)
    for rows, columns, depths in triangle_samples.bands(triangle, shape):
        image[rows, columns] = depths
    for numbers, points in triangle_samples.points_on(triangle, FACES):
        assert not numbers.any()
        shown = image[points[:, 1].astype(int), points[:, 0].astype(int)]
        assert np.allclose(shown, points[:, 2], atol=0.1)
