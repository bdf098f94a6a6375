"""Masses of SDFormat links that their collisions give: `<inertial auto="true">`, since 1.11."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...description.document import Data, KeyPath
from ...errors import DescriptionError
from ...ground.arrays import Array
from ...mechanism.inertia import parallel_axis_term
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .visuals import VisualReader

_WATER = 1000.0  # [kg/m^3] where no density is given
_SOLIDS = ("box", "cylinder", "sphere", "capsule", "ellipsoid")
_IGNORED = ("pose", "inertia", "auto_inertia_params")


def is_auto(inertial: LocatedElement) -> bool:
    """Whether collisions give the mass of a link."""
    return inertial.get("auto").strip() in ("true", "1")


class AutoInertia:
    """Computes masses from collisions.

    Args:
        xml: the file.
        shapes: reads shapes and their poses.
    """

    def __init__(self, xml: XmlReader, shapes: VisualReader) -> None:
        self.xml = xml
        self.shapes = shapes

    def body(self, link: LocatedElement, inertial: LocatedElement, path: KeyPath) -> Data:
        """Mass, centre of mass and inertia of a link.

        Raises:
            DescriptionError: it has no collision, one of another shape, or a mass of its own.
        """
        if inertial.first("mass") is not None:
            problem = 'has auto="true" and a <mass>; expected one of them'
            raise self.xml.error(inertial, path, problem)
        collisions = link.all("collision")
        if not collisions:
            raise self.xml.error(inertial, path, 'has auto="true", and no <collision> gives a mass')
        for tag in _IGNORED:
            ignored = inertial.first(tag)
            if ignored is not None:
                text = f'<{tag}> of {link.get("name")} is left out: auto="true"'
                self.xml.note(ignored, text)
        density = self.xml.text_number(inertial.first("density"), path, _WATER)
        parts = [self._part(collision, link.get("name"), density) for collision in collisions]
        total = sum(mass for mass, _, _ in parts)
        com = sum((mass * centre for mass, centre, _ in parts), np.zeros(3)) / total
        inertia = np.zeros((3, 3))
        for mass, centre, tensor in parts:
            inertia += tensor + parallel_axis_term(mass, centre - com)
        text = f"link {link.get('name')} has the mass of its collisions: {total:.6g} kg"
        self.xml.note(inertial, text)
        return {"mass": total, "com": com.tolist(), "inertia": inertia.tolist()}

    def _part(
        self, collision: LocatedElement, link: str, density: float
    ) -> tuple[float, Array, Array]:
        """Mass, centre (3,) and tensor (3, 3) about it in link axes, of one collision."""
        path: KeyPath = ("links", link)
        of_collision = collision.first("density")
        density = self.xml.text_number(of_collision, path, density)
        if density <= 0.0:
            raise self._error(
                collision, link, f"has a density of {density:g}; expected more than 0"
            )
        geometry = collision.first("geometry")
        shapes = [] if geometry is None else geometry.children
        if len(shapes) != 1 or shapes[0].tag not in _SOLIDS:
            listed = ", ".join(f"<{shape.tag}>" for shape in shapes) or "nothing"
            problem = f"has the shape {listed}; a mass is computed of {', '.join(_SOLIDS)}"
            raise self._error(collision, link, problem)
        shape = shapes[0]
        entry = self.shapes.shape(shape, path)[shape.tag]
        volume, moments = _solid(shape.tag, entry)
        mass = density * volume
        pose = self.shapes.pose(collision.first("pose"), link, path)
        tensor = pose.rotation @ np.diag(mass * np.array(moments)) @ pose.rotation.T
        return mass, np.array(pose.translation), (tensor + tensor.T) / 2.0

    def _error(self, collision: LocatedElement, link: str, problem: str) -> DescriptionError:
        return self.xml.error(collision, ("links", link, "collision"), problem)


def _solid(kind: str, sizes: Data) -> tuple[float, Sequence[float]]:
    """Volume [m^3] of a solid, and its moments of inertia [m^2] per mass, about its axes."""
    if kind == "box":
        x, y, z = sizes["size"]
        return x * y * z, _of_box(x, y, z, 12.0)
    if kind == "ellipsoid":
        a, b, c = sizes["radii"]
        return 4.0 / 3.0 * math.pi * a * b * c, _of_box(a, b, c, 5.0)
    radius = sizes["radius"]
    ball = 4.0 / 3.0 * math.pi * radius**3
    if kind == "sphere":
        return ball, _of_box(radius, radius, radius, 5.0)
    length = sizes["length"]
    tube = math.pi * radius**2 * length
    tube_across = (3.0 * radius**2 + length**2) / 12.0
    tube_along = radius**2 / 2.0
    if kind == "cylinder":
        return tube, (tube_across, tube_across, tube_along)
    # a capsule: the two halves of the ball are apart
    ball_along = 0.4 * radius**2
    ball_across = ball_along + length**2 / 4.0 + 3.0 / 8.0 * radius * length
    volume = tube + ball
    across = (tube * tube_across + ball * ball_across) / volume
    along = (tube * tube_along + ball * ball_along) / volume
    return volume, (across, across, along)


def _of_box(x: float, y: float, z: float, divisor: float) -> Sequence[float]:
    return (
        (y * y + z * z) / divisor,
        (x * x + z * z) / divisor,
        (x * x + y * y) / divisor,
    )
