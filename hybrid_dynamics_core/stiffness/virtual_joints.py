"""Virtual joints: deformations of links and bearings, as twists of all that they carry."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..description.elasticity import Elasticity
from ..ground.arrays import Array
from .held import joint_bearing
from .link_springs import LinkFlex, link_flex
from .posed_tree import Pose, PosedTree


class Deformation(NamedTuple):
    """A deformation of unit stiffness.

    Attributes:
        name: name of its element.
        twist: (6,) about the base origin, of all that it carries.
    """

    name: str
    twist: Array


@dataclass(eq=False)
class VirtualJoints:
    """The virtual joints of a tree.

    Attributes:
        deformations: all of them.
        flexes: springs of each elastic link, by body.
        of_links: indices of the deformations of each spring of a link, by body.
        of_joints: indices of the deformations of a joint's bearing, by the body that it carries.
    """

    deformations: list[Deformation] = field(default_factory=list)
    flexes: dict[int, LinkFlex] = field(default_factory=dict)
    of_links: dict[int, list[list[int]]] = field(default_factory=dict)
    of_joints: dict[int, list[int]] = field(default_factory=dict)

    def add(self, name: str, twists: Array) -> list[int]:
        """Add deformations (6, k); their indices are returned."""
        first = len(self.deformations)
        for twist in twists.T:
            self.deformations.append(Deformation(name, twist))
        return list(range(first, len(self.deformations)))

    def order(self, posed: PosedTree) -> Array:
        """Order (n_s + k,) of joints and deformations on every path from the base to a tip.

        What comes first carries what comes later. Deformations of one spring are at one place.
        """
        size = len(posed.tree.coordinates)
        groups = [[size + k for k in spring] for spring in self.of_links.get(-1, [])]
        for body, link in enumerate(posed.tree.bodies):
            groups.append([size + k for k in self.of_joints.get(body, [])])
            groups.append([link.coordinate])
            groups += [[size + k for k in spring] for spring in self.of_links.get(body, [])]
        order = np.zeros(size + len(self.deformations))
        for place, group in enumerate(groups):
            order[group] = place
        return order


def virtual_joints(posed: PosedTree, elasticity: Elasticity) -> VirtualJoints:
    """The virtual joints of a robot at a state.

    Args:
        posed: its tree at the state.
        elasticity: what of it is elastic.

    Raises:
        InputError: a beam or bearing cannot be what is said of it.
    """
    joints = VirtualJoints()
    for name in elasticity.links:
        _add_link(joints, posed, name, elasticity)
    for body, link in enumerate(posed.tree.bodies):
        bearing = elasticity.pins.get(link.joint)
        if bearing is None:
            continue
        freedom = "z"
        if link.is_revolute:
            freedom = "Z"
        local = joint_bearing(link.joint, freedom, bearing, posed.length)
        twists = posed.joint_pose(body).twists(local)
        joints.of_joints[body] = joints.add(f"pins.{link.joint}", twists)
    return joints


def _add_link(joints: VirtualJoints, posed: PosedTree, name: str, elasticity: Elasticity) -> None:
    """Add the springs of an elastic link."""
    link = elasticity.link(name)
    if link is None:
        return
    body = posed.tree.body_index(name)
    flex = link_flex(posed.description, name, link)
    pose = posed.pose(body)
    indices: list[list[int]] = []
    for spring in flex.springs:
        at = Pose(pose.rotation, pose.point(spring.point))
        twists = at.twists(spring.deformations)
        indices.append(joints.add(f"links.{name}", twists))
    joints.flexes[body] = flex
    joints.of_links[body] = indices
