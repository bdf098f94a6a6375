"""Convex polytopes with vertices and facets, of one to three dimensions or more."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arrays import real_array

SAME = 1e-9  # share of the extent, below which two vertices or facets are the same
DIGITS = 8  # in which facets of scaled points are the same


@dataclass(frozen=True, eq=False)
class Polytope:
    """A convex polytope; empty where `vertices` has no row.

    Attributes:
        vertices: (v, k) in the units of the axes; in two dimensions counter-clockwise.
        normals: (f, k) unit normals of the facets, outward.
        offsets: (f,) with normals @ y <= offsets inside.
        axes: names of the k axes.
        at_limit: drives at a limit in each vertex, (v) tuples of names.
    """

    vertices: Array
    normals: Array
    offsets: Array
    axes: tuple[str, ...]
    at_limit: tuple[tuple[str, ...], ...]

    @property
    def is_empty(self) -> bool:
        """Whether the limits allow nothing."""
        return not len(self.vertices)

    def contains(self, point: ArrayLike, slack: float = 0.0) -> bool:
        """Whether a point (k,) is inside, up to a slack in its unit."""
        values = real_array("point", point)
        if values.shape != (len(self.axes),):
            raise InputError(f"point has shape {values.shape}; expected ({len(self.axes)},)")
        if self.is_empty:
            return False
        return bool((self.normals @ values <= self.offsets + slack).all())

    def support(self, direction: ArrayLike) -> float:
        """Largest product of a point with a direction (k,); minus infinity if empty."""
        values = real_array("direction", direction)
        return float((self.vertices @ values).max(initial=-np.inf))


def hull(points: Array, axes: tuple[str, ...], at_limit: list[tuple[str, ...]]) -> Polytope:
    """The convex hull of points.

    Args:
        points: (v, k) in the units of the axes.
        axes: names of the k axes.
        at_limit: drives at a limit in each point.
    """
    k = len(axes)
    if not len(points):
        return Polytope(points, np.zeros((0, k)), np.zeros(0), axes, ())
    middle = points.mean(axis=0)
    extent = np.abs(points - middle).max(axis=0)
    if k == 1:
        chosen = [int(np.argmin(points)), int(np.argmax(points))]
        if not extent[0] > 0.0:
            chosen = chosen[:1]
        normals = np.array([[-1.0], [1.0]])
        offsets = np.array([-points.min(), points.max()])
        return _polytope(points, chosen, normals, offsets, axes, at_limit)
    scaled = (points - middle) / np.where(extent > 0.0, extent, 1.0)
    values = np.linalg.svd(scaled, compute_uv=False)
    largest = max(float(values.max(initial=0.0)), 1.0)
    rank = int((values > SAME * largest).sum())
    if rank < k:
        return _flat(points, rank, (middle, extent), axes, at_limit)
    from scipy.spatial import ConvexHull  # noqa: PLC0415  slow to import

    result = ConvexHull(scaled)
    normals, offsets = _facets(result.equations, middle, extent)
    chosen = [int(index) for index in result.vertices]
    return _polytope(points, chosen, normals, offsets, axes, at_limit)


def _facets(equations: Array, middle: Array, extent: Array) -> tuple[Array, Array]:
    """Facets, each once: normals (f, k) and offsets (f,) as in `Polytope`.

    Args:
        equations: (f, k + 1) normals of the hull of scaled points, and offsets with other sign.
        middle: (k,) point that was subtracted.
        extent: (k,) what was divided by.
    """
    normals = equations[:, :-1] / extent
    sizes = np.linalg.norm(normals, axis=1)
    unit = normals / sizes[:, None]
    offsets = -equations[:, -1] / sizes + unit @ middle
    # a facet with more than k vertices comes in several simplices
    rounded = np.round(equations, DIGITS)
    _, first = np.unique(rounded, axis=0, return_index=True)
    first = np.sort(first)
    return unit[first], offsets[first]


def _flat(
    points: Array,
    rank: int,
    scales: tuple[Array, Array],
    axes: tuple[str, ...],
    at_limit: list[tuple[str, ...]],
) -> Polytope:
    """A polytope of fewer dimensions: facets of its hull, and two for each missing direction.

    Args:
        points: (v, k).
        rank: number of its dimensions.
        scales: middle (k,) and extent (k,) of the points.
        axes: names of the k axes.
        at_limit: drives at a limit in each point.
    """
    middle, extent = scales
    size = np.where(extent > 0.0, extent, 1.0)
    scaled = (points - middle) / size
    directions = np.linalg.svd(scaled)[2]
    facets, offsets = np.zeros((0, len(axes))), np.zeros(0)
    chosen = [0]
    if rank:
        inner = scaled @ directions[:rank].T
        part = hull(inner, axes[:rank], at_limit)
        facets, offsets = part.normals @ directions[:rank], part.offsets
        chosen = []
        for vertex in part.vertices:
            distances = np.abs(inner - vertex).max(axis=1)
            chosen.append(int(np.argmin(distances)))
    across = directions[rank:]
    normals = np.vstack([facets, across, -across]) / size
    limits = np.concatenate([offsets, np.zeros(2 * len(across))])
    lengths = np.linalg.norm(normals, axis=1)
    unit = normals / lengths[:, None]
    return _polytope(points, chosen, unit, limits / lengths + unit @ middle, axes, at_limit)


def _polytope(
    points: Array,
    chosen: list[int],
    normals: Array,
    offsets: Array,
    axes: tuple[str, ...],
    at_limit: list[tuple[str, ...]],
) -> Polytope:
    """The polytope whose vertices are the chosen points, with their drives at a limit."""
    limits = tuple(at_limit[index] for index in chosen)
    return Polytope(points[chosen], normals, offsets, axes, limits)
