"""The visuals of a robot as triangles that move with its links."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import Final

import numpy as np

from ...description.model import Colour, RobotDescription, Visual
from ...ground.arrays import Array
from ..parts import Part
from ..skeleton import Pose
from .meshes import MeshError, MeshPart, Result, read_meshes
from .primitives import Faces, triangles_of

_STEEL: Final = (0.76, 0.8, 0.84, 1.0)  # default colour
_ANGLES: Final = np.linspace(0.0, 2.0 * np.pi, 65)[:-1]
_DIRECTIONS: Final = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)])


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles that move with a link.

    Attributes:
        link: a moving link or the base.
        vertices: (k, 3) in the axes of the link [m].
        faces: (m, 3) indices of vertices, counterclockwise seen from outside.
        colour: colour of all triangles.
    """

    link: str
    vertices: Array
    faces: Faces
    colour: Colour

    def placed(self, poses: Mapping[str, Pose]) -> Surface:
        """The surface in base axes.

        Args:
            poses: poses of the links.
        """
        rotation, origin = poses[self.link]
        return replace(self, vertices=self.vertices @ rotation.T + origin)

    def box(self) -> Array:
        """Corners (8, 3) of its bounding box [m]."""
        ends = np.stack([self.vertices.min(axis=0), self.vertices.max(axis=0)])
        corners = np.array(list(product((0, 1), repeat=3)))
        return np.asarray(ends[corners, np.arange(3)])


@dataclass(frozen=True, eq=False)
class Surfaces:
    """All surfaces of a robot.

    Attributes:
        surfaces: surfaces in the axes of their links.
        problems: sentences on meshes that could not be read.
    """

    surfaces: tuple[Surface, ...] = ()
    problems: tuple[str, ...] = ()

    @property
    def links(self) -> frozenset[str]:
        """Names of links that have a surface."""
        return frozenset(surface.link for surface in self.surfaces)


NONE: Final = Surfaces()


def surfaces_of(robot: RobotDescription) -> Surfaces:
    """Read the surfaces of a robot, including its mesh files.

    Args:
        robot: the robot.
    """
    visuals = [visual for of_link in robot.visuals.values() for visual in of_link]
    files = [visual.file for visual in visuals if visual.file is not None]
    results = read_meshes(files) if files else {}
    surfaces: list[Surface] = []
    problems: dict[str, None] = {}
    for visual in visuals:
        if visual.uri:
            result: Result = MeshError("not there, as a note of the robot says")
            if visual.file is not None:
                result = results[visual.file]
            if isinstance(result, MeshError):
                problems[f"mesh {visual.uri} is not shown: {result}"] = None
            else:
                surfaces.extend(_of_part(visual, part) for part in result)
        else:
            vertices, faces = triangles_of(visual.shape, visual.size)
            surfaces.append(_surface(visual, vertices, faces, visual.colour))
    shown = tuple(surface for surface in surfaces if surface.colour[3] > 0.0)
    return Surfaces(shown, tuple(problems))


def _of_part(visual: Visual, part: MeshPart) -> Surface:
    faces = part.faces
    scale = np.array(visual.size)
    if scale.prod() < 0.0:  # a mirror image
        faces = faces[:, ::-1]
    return _surface(visual, part.vertices * scale, faces, visual.colour or part.colour)


def _surface(visual: Visual, vertices: Array, faces: Faces, colour: Colour | None) -> Surface:
    frame = visual.frame
    placed = vertices @ frame.rotation.T + frame.translation
    return Surface(frame.link, placed, faces, colour or _STEEL)


def outline(points: Array) -> Array:
    """Corners (n, 2) of the convex outline of points (k, 2) in 64 directions, counterclockwise."""
    farthest = np.argmax(points @ _DIRECTIONS, axis=0)
    return np.asarray(points[farthest])


def is_covered(part: Part, links: frozenset[str]) -> bool:
    """Whether surfaces replace a part: a body of their links, or a part that slides between two.

    Args:
        part: part of the skeleton.
        links: links with surfaces.
    """
    kind, _, name = part.owner.partition(":")
    if kind == "link":
        return name in links
    if part.role in ("rail", "block", "collar"):
        return links.issuperset(part.links)
    return False
