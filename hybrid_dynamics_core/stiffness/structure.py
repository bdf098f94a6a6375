"""The elastic structure of a posed robot: springs of unit stiffness, and equations between them.

Coordinates are q = [s; e]: joint coordinates s, and deformations e. Each spring is scaled, so that
its energy is e^2 / 2. A rigid element has no spring, or one whose e has no effect. So the equations
stay finite at the rigid limit:

    A_s s + A_e e = 0,  energy |e|^2 / 2.

This is the virtual joint method, Klimchik, Pashkevich and Chablat (2018), with closures as
equations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..description.elasticity import Elasticity
from ..ground.arrays import Array
from .attachments import Key
from .equations import Equation, HeldClosure, equations_of, held_closures
from .places import ROOT, Places, places_of
from .posed_tree import Pose, PosedTree
from .robot_interface import ElasticRobot
from .virtual_joints import virtual_joints


@dataclass(frozen=True, eq=False)
class Structure:
    """Springs, equations and places of a posed robot.

    Attributes:
        posed: the tree of the robot at the state.
        springs: name of the element of each deformation.
        A_s: (m, n_s) equations over joint coordinates.
        A_e: (m, n_e) equations over deformations.
        places: (6, n_s + n_e) twist about the base origin of each place, by body and key.
        order: (n_s + n_e,) grows from the base to the tips; deformations of one spring have one.
        closures: what each closure holds, in the order of the first equations.
    """

    posed: PosedTree
    springs: tuple[str, ...]
    A_s: Array
    A_e: Array
    places: Places
    order: Array
    closures: tuple[HeldClosure, ...]

    @property
    def length(self) -> float:
        """Length by which turns are compared with displacements [m]."""
        return self.posed.length

    @property
    def size(self) -> int:
        """Number of coordinates, n_s + n_e."""
        return int(self.A_s.shape[1]) + len(self.springs)

    def twists(self, frame: str) -> tuple[Pose, Array]:
        """Pose of a frame with base axes, and its twists (6, n_s + n_e) about the base origin."""
        description = self.posed.description
        if frame not in description.frames:
            return self.twists_of_link(frame)
        on = description.frames[frame]
        body = self.posed.tree.body_index(on.link)
        carrier = self.posed.pose(body)
        origin = carrier.point(on.translation)
        key: Key = ("frame", frame)
        return _in_base_axes(origin), self.places[body, key]

    def twists_of_link(self, link: str) -> tuple[Pose, Array]:
        """As `twists`, for the frame of a link."""
        body = self.posed.tree.body_index(link)
        pose = self.posed.pose(body)
        return _in_base_axes(pose.origin), self.places[body, ROOT]

    def frame_rotation(self, frame: str) -> Array:
        """Rotation (3, 3) of a frame in the base frame."""
        frames = self.posed.description.frames
        if frame not in frames:
            body = self.posed.tree.body_index(frame)
            return self.posed.pose(body).rotation
        on = frames[frame]
        body = self.posed.tree.body_index(on.link)
        return self.posed.pose(body).rotation @ on.rotation


def _in_base_axes(origin: Array) -> Pose:
    return Pose(np.eye(3), origin)


def build_structure(robot: ElasticRobot, posed: PosedTree, elasticity: Elasticity) -> Structure:
    """The elastic structure of a robot at a state.

    Args:
        robot: the robot.
        posed: its tree at the state.
        elasticity: what of it is elastic.

    Raises:
        InputError: an element cannot be what is said of it.
    """
    joints = virtual_joints(posed, elasticity)
    places = places_of(posed, joints)
    closures = held_closures(posed, elasticity)
    equations = equations_of(robot, posed, elasticity, places, closures)
    elastic = [equation for equation in equations if equation.deformation > 0.0]
    names = [joint.name for joint in joints.deformations]
    names += [equation.name for equation in elastic]
    size = len(posed.tree.coordinates)
    width = size + len(joints.deformations)
    rows = np.zeros((len(equations), width))
    for k, equation in enumerate(equations):
        rows[k] = equation.row
    of_joints = rows[:, size:]
    of_springs = _deformation_columns(equations, elastic)
    return Structure(
        posed=posed,
        springs=tuple(names),
        A_s=rows[:, :size],
        A_e=np.hstack([of_joints, of_springs]),
        places=_widened(places, len(elastic)),
        order=np.concatenate([joints.order(posed), np.zeros(len(elastic))]),
        closures=closures,
    )


def _deformation_columns(equations: list[Equation], elastic: list[Equation]) -> Array:
    """Columns (m, k) of the deformations of k elastic equations among m."""
    columns = np.zeros((len(equations), len(elastic)))
    for k, equation in enumerate(elastic):
        row = equations.index(equation)
        columns[row, k] = -equation.deformation
    return columns


def _widened(places: Places, count: int) -> Places:
    """Places with more coordinates, which do not move them."""
    wide: dict[tuple[int, Key], Array] = {}
    zeros = np.zeros((6, count))
    for key, twists in places.items():
        wide[key] = np.hstack([twists, zeros])
    return wide
