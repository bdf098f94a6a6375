"""Surfaces as an image with outlines, by a depth buffer.

Triangles are sampled more finely than pixels, and every sample shows what is nearest. So
triangles may intersect, and their order does not matter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.image import AxesImage
from numpy.typing import NDArray

from ...description.model import Colour
from ...ground.arrays import Array
from ...scene.projection import Projection
from ...scene.style import INK
from ...scene.visuals.primitives import Faces
from ...scene.visuals.surfaces import Surface
from .triangle_samples import are_large, bands, points_on

_DENSITY: Final = 320.0  # samples per inch; two by two are a pixel
_MAX_SIDE: Final = 4000  # samples along a side of the image
_AMBIENT: Final = 0.62  # brightness of surfaces in shadow
_DIFFUSE: Final = 0.5  # added where it falls straight
_LIGHT: Final = (-0.45, 0.75, 1.0)  # direction of the light: right, up, toward the viewer
_CREASE: Final = 0.8  # cosine between normals below which an edge is drawn
_DEPTH_STEP: Final = 0.006  # least step in depth at an outline, as a share of the size of the image
_FLAT: Final = 1e-9  # least area of a triangle, relative to the square of its longest side
_EDGE: Final = 0.55  # share of ink in an outline


Window = tuple[slice, ...]
Places = tuple[NDArray[np.intp], ...]


@dataclass(frozen=True, eq=False)
class Image:
    """Image of surfaces.

    Attributes:
        pixels: (h, w, 4) red, green, blue and opacity; the first row is at the bottom.
        corners: (2, 2) corners [[left, bottom], [right, top]] in the picture [m].
    """

    pixels: Array
    corners: Array


def add_surfaces(
    axes: Axes, surfaces: Sequence[Surface], projection: Projection, scale: float
) -> None:
    """Paint surfaces below all parts and names.

    Args:
        axes: Matplotlib axes.
        surfaces: surfaces in base axes.
        projection: projection of the picture.
        scale: metres of the picture per inch.
    """
    image = image_of(surfaces, projection, scale)
    (left, bottom), (right, top) = image.corners
    artist = AxesImage(
        axes,
        interpolation="antialiased",
        origin="lower",
        extent=(left, right, bottom, top),
        zorder=1.9,
        clip_on=False,
    )
    artist.set_data(image.pixels)
    artist.set_gid("visuals")
    axes.add_image(artist)


def image_of(surfaces: Sequence[Surface], projection: Projection, scale: float) -> Image:
    """The image of surfaces.

    Args:
        surfaces: surfaces in base axes.
        projection: projection of the picture.
        scale: metres of the picture per inch.
    """
    points = np.vstack([surface.vertices for surface in surfaces])
    flat = projection.project(points)
    low = flat.min(axis=0)
    extent = np.maximum(np.ptp(flat, axis=0), 1e-9)
    least = float(extent.max()) / _MAX_SIDE
    sample = max(scale / _DENSITY, least)
    width, height = (int(side) + 4 for side in np.ceil(extent / sample))
    width += width % 2
    height += height % 2
    corner = low - 2.0 * sample
    canvas = _Canvas(width, height, sample * max(width, height))
    directions = _directions(projection)
    for surface in surfaces:
        in_picture = projection.project(surface.vertices)
        places = (in_picture - corner) / sample
        depths = projection.depth(surface.vertices)
        vertices = np.column_stack([places, depths])
        canvas.add(surface, vertices, directions)
    size = sample * np.array([width, height])
    corners = np.array([corner, corner + size])
    return Image(canvas.pixels(), corners)


def _directions(projection: Projection) -> Array:
    """Directions (3, 3): rows right, up, and toward the viewer."""
    return np.stack([projection.right, projection.up, projection.toward])


class _Canvas:
    """Depth buffer: the nearest samples with their triangles."""

    def __init__(self, width: int, height: int, size: float) -> None:
        self.shape = (height, width)
        self.size = size
        self.depths = np.full(width * height, -np.inf)
        self.triangles = np.full(width * height, -1)
        self.colours: list[Array] = [np.zeros((0, 4))]  # colours (k, 4) of triangles
        self.normals: list[Array] = [np.zeros((0, 3))]
        self.paints: list[Faces] = [np.zeros(0, int)]  # numbers of colours
        self.palette: dict[Colour, int] = {}
        self.count = 0

    def add(self, surface: Surface, vertices: Array, directions: Array) -> None:
        """Add a surface.

        Args:
            surface: surface in base axes.
            vertices: (k, 3) vertices: right and up in samples, and the depth [m].
            directions: directions (3, 3) of the picture.
        """
        a, b, c = (surface.vertices[corner] for corner in surface.faces.T)
        first = b - a
        second = c - a
        normals = np.cross(first, second)
        lengths = np.linalg.norm(normals, axis=1)
        longest = np.maximum(np.linalg.norm(first, axis=1), np.linalg.norm(second, axis=1))
        solid = lengths > _FLAT * longest**2
        if not solid.any():
            return
        units = normals[solid] / lengths[solid, None]
        normals = units @ directions.T
        signs = np.where(normals[:, 2:] < 0.0, -1.0, 1.0)
        normals *= signs  # both sides are lit
        self.normals.append(normals)
        self.colours.append(_lit(surface, normals))
        paint = self.palette.setdefault(surface.colour, len(self.palette))
        self.paints.append(np.full(len(normals), paint))
        self._add_triangles(vertices, surface.faces[solid])
        self.count += len(normals)

    def _add_triangles(self, vertices: Array, faces: Faces) -> None:
        large = are_large(vertices, faces)
        for number in np.flatnonzero(large):
            corners = vertices[faces[number]]
            self._add_large(corners, self.count + int(number))
        small = np.flatnonzero(~large)
        for numbers, points in points_on(vertices, faces[small]):
            self._keep_nearest(points, self.count + small[numbers])

    def _add_large(self, corners: Array, triangle: int) -> None:
        nearest_depths = self.depths.reshape(self.shape)
        triangles = self.triangles.reshape(self.shape)
        for rows, columns, depths in bands(corners, self.shape):
            nearest = nearest_depths[rows, columns]
            nearer = depths > nearest
            nearest[nearer] = depths[nearer]
            triangles[rows, columns][nearer] = triangle

    def _keep_nearest(self, points: Array, triangles: Faces) -> None:
        height, width = self.shape
        columns, rows = points[:, :2].astype(int).T
        columns = np.clip(columns, 0, width - 1)
        rows = np.clip(rows, 0, height - 1)
        places = rows * width + columns
        nearer = points[:, 2] > self.depths[places]
        places = places[nearer]
        depths = points[nearer, 2]
        triangles = triangles[nearer]
        order = np.argsort(depths, kind="stable")  # the last of several at one sample remains
        ordered = places[order]
        self.depths[ordered] = depths[order]
        self.triangles[ordered] = triangles[order]

    def pixels(self) -> Array:
        """The pixels (h, w, 4) of the image with outlines; two by two samples are one pixel."""
        triangles = self.triangles.reshape(self.shape)
        painted = triangles >= 0
        colours = np.vstack([*self.colours, np.zeros((1, 4))])  # the last one is transparent
        samples = colours.astype(np.float32)[triangles]
        edges = self._edges(triangles) & painted
        ink = np.array([*bytes.fromhex(INK.removeprefix("#"))]) / 255.0
        behind = samples[edges, :3]
        samples[edges, :3] = behind + _EDGE * (ink - behind)
        samples[edges, 3] = 1.0
        height, width = self.shape
        blocks = samples.reshape(height // 2, 2, width // 2, 2, 4)
        colours = blocks[..., :3]
        opacities = blocks[..., 3:]
        opacity = opacities.sum(axis=(1, 3))
        weighted = (colours * opacities).sum(axis=(1, 3))
        colour = weighted / np.maximum(opacity, 1e-9)
        pixels = np.concatenate([colour, opacity / 4.0], axis=2)
        rounded = np.round(255.0 * pixels)
        return np.asarray(rounded.astype(np.uint8))

    def _edges(self, triangles: Faces) -> NDArray[np.bool_]:
        """Mask (h, w) of samples at an outline or a crease."""
        edges = np.zeros(self.shape, bool)
        for axis in (0, 1):
            one = [slice(None), slice(None)]
            other = [slice(None), slice(None)]
            one[axis] = slice(None, -1)
            other[axis] = slice(1, None)
            first = tuple(one)
            second = tuple(other)
            changes = triangles[first] != triangles[second]
            places = np.nonzero(changes)
            parted = self._part(triangles, first, second, places)
            edge = tuple(place[parted] for place in places)
            edges[first][edge] = True
            edges[second][edge] = True
        return edges

    def _part(self, triangles: Faces, first: Window, second: Window, places: Places) -> Array:
        """Mask (n,) of edges between samples of two triangles.

        Args:
            triangles: (h, w) triangles of the samples.
            first: window of the samples.
            second: window of their neighbours.
            places: rows and columns (n,) of samples in the windows.
        """
        one = triangles[first][places]
        other = triangles[second][places]
        paints = np.concatenate([*self.paints, [-1]])
        normals = np.vstack([*self.normals, np.zeros((1, 3))])
        depths = self.depths.reshape(self.shape)
        nearer = depths[first][places]
        farther = depths[second][places]
        facing = (normals[one] * normals[other]).sum(axis=1)
        with np.errstate(invalid="ignore"):  # depths of the background are infinite
            apart = np.abs(nearer - farther)
        is_step = apart > _DEPTH_STEP * self.size
        is_crease = facing < _CREASE
        is_painted_otherwise = paints[one] != paints[other]
        return np.asarray(is_painted_otherwise | is_crease | is_step)


def _lit(surface: Surface, normals: Array) -> Array:
    """Shaded colours (m, 4) of triangles.

    Args:
        surface: the surface.
        normals: (m, 3) normals: right, up, toward the viewer.
    """
    light = np.array(_LIGHT) / np.linalg.norm(_LIGHT)
    straight = np.maximum(normals @ light, 0.0)
    brightness = np.minimum(_AMBIENT + _DIFFUSE * straight, 1.0)
    colour = np.array(surface.colour[:3])
    colours = np.empty((len(normals), 4))
    colours[:, :3] = brightness[:, None] * colour
    colours[:, 3] = surface.colour[3]
    return colours
