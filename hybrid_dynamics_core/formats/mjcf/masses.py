"""The mass of an MJCF body: its <inertial>, or its shapes, within the bounds of <compiler>."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...description.document import Data, KeyPath
from ...description.geometry import Transform
from ...ground.arrays import Array
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from .poses import PoseReader
from .shapes import Body, ShapeReader, joined
from .vocabulary import ORIENTATIONS

NEGLIGIBLE = 1e-9  # [kg, kg m^2] stands for none, since MuJoCo wants some mass of what moves
_NOTHING = Body(0.0, np.zeros(3), np.zeros((3, 3)))
_ROWS = (0, 1, 2, 0, 0, 1)  # of xx, yy, zz, xy, xz, yz
_COLUMNS = (0, 1, 2, 1, 2, 2)

PlacedShape = tuple[LocatedElement, Transform]  # with the frame around it, in the body


class MassReader:
    """Reads the masses of bodies."""

    def __init__(self, xml: XmlReader, poses: PoseReader) -> None:
        self.xml = xml
        self.poses = poses
        self.settings = poses.settings
        self.shapes = ShapeReader(xml, poses)

    def entry(
        self, element: LocatedElement, geoms: Sequence[PlacedShape], path: tuple[str, str]
    ) -> Data:
        """Mass, centre of mass and inertia of a body; nothing where they stand for none.

        Args:
            element: the body, which moves.
            geoms: its shapes.
            path: of its entry.
        """
        body = self._body(element, geoms, path)
        largest = float(np.linalg.eigvalsh(body.inertia)[-1])
        bound = max(self.settings.least_mass, self.settings.least_moment)
        if body.mass <= NEGLIGIBLE and largest <= NEGLIGIBLE and bound <= NEGLIGIBLE:
            return {}
        body = self._within_bounds(body, element, path)
        inertia = (body.inertia + body.inertia.T) / 2.0
        return {"mass": body.mass, "com": body.com.tolist(), "inertia": inertia.tolist()}

    def _body(
        self, element: LocatedElement, geoms: Sequence[PlacedShape], path: tuple[str, str]
    ) -> Body:
        inertial = element.first("inertial")
        use = self.settings.masses_from_shapes
        if use == "false" or (use == "auto" and inertial is not None):
            geoms = ()
        made: list[Body] = []
        for geom, around in geoms:
            shape = self.shapes.body(geom, path)
            if shape is not None:
                made.append(_placed(shape, around))
        if made:
            body = joined(made)
            _, name = path
            self.xml.note(element, f"body {name} has the mass of its shapes: {body.mass:.6g} kg")
            return body
        if inertial is None:
            return _NOTHING
        return self._explicit(inertial, path)

    def _explicit(self, inertial: LocatedElement, path: KeyPath) -> Body:
        """The body of an <inertial>."""
        mass = self.xml.number(inertial, "mass", (*path, "mass"))
        pose = self.poses.pose(inertial, path)
        tensor = self._tensor(inertial, (*path, "inertia"))
        return _placed(Body(mass, np.zeros(3), tensor), pose)

    def _tensor(self, inertial: LocatedElement, key: KeyPath) -> Array:
        """The inertia tensor (3, 3) in the frame of an <inertial> [kg m^2]."""
        if "fullinertia" not in inertial.attributes:
            return np.diag(self.xml.numbers(inertial, "diaginertia", 3, key))
        turned = [name for name in inertial.attributes if name in ORIENTATIONS]
        if turned or "diaginertia" in inertial.attributes:
            problem = f"has fullinertia and {', '.join(turned) or 'diaginertia'}; leave one"
            raise self.xml.error(inertial, key, problem)
        tensor = np.zeros((3, 3))
        components = self.xml.numbers(inertial, "fullinertia", 6, key)
        tensor[_ROWS, _COLUMNS] = components
        tensor[_COLUMNS, _ROWS] = components
        return tensor

    def _within_bounds(self, body: Body, element: LocatedElement, path: tuple[str, str]) -> Body:
        """The body as MuJoCo raises and balances it; a note says so."""
        moments, axes = np.linalg.eigh(body.inertia)
        raised = np.maximum(moments, self.settings.least_moment)
        mass = max(body.mass, self.settings.least_mass)
        if self.settings.is_balanced and raised[0] + raised[1] < raised[2]:
            raised = np.full(3, raised.mean())
        if mass == body.mass and np.array_equal(raised, moments):
            return body
        _, name = path
        self.xml.note(element, f"body {name} is raised or balanced, as <compiler> says")
        return replace(body, mass=mass, inertia=axes @ np.diag(raised) @ axes.T)


def _placed(body: Body, pose: Transform) -> Body:
    """A body in the frame in which `pose` stands."""
    inertia = pose.rotation @ body.inertia @ pose.rotation.T
    return Body(body.mass, pose.point(body.com), inertia)
