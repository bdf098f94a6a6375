"""Twists of all links and of the places on them, per unit of each joint and deformation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from ..ground.arrays import Array
from .attachments import Key, places_on
from .posed_tree import PosedTree
from .virtual_joints import VirtualJoints

Places = Mapping[tuple[int, Key], Array]

ROOT: Final[Key] = ("root", "")


def places_of(posed: PosedTree, joints: VirtualJoints) -> Places:
    """Twists (6, n_s + k) about the base origin, by body and place.

    Args:
        posed: the tree at a state.
        joints: its virtual joints, with k deformations.
    """
    size = len(posed.tree.coordinates)
    width = size + len(joints.deformations)
    places: dict[tuple[int, Key], Array] = {}
    places[-1, ROOT] = np.zeros((6, width))
    _attach(posed, joints, -1, places)
    for body, link in enumerate(posed.tree.bodies):
        on_parent: Key = ("joint", link.joint)
        twists = places[link.parent, on_parent].copy()
        _add(twists, joints, joints.of_joints.get(body, []))
        twists[:, link.coordinate] = posed.joint_twist(body)
        places[body, ROOT] = twists
        _attach(posed, joints, body, places)
    return places


def _attach(
    posed: PosedTree,
    joints: VirtualJoints,
    body: int,
    places: dict[tuple[int, Key], Array],
) -> None:
    """Add the places on a body, which move with the springs between them and its joint."""
    root = places[body, ROOT]
    flex = joints.flexes.get(body)
    for key in places_on(posed.description, _name(posed, body)):
        places[body, key] = root
        if flex is None:
            continue
        twists = root.copy()
        for spring in flex.chains[key]:
            _add(twists, joints, joints.of_links[body][spring])
        places[body, key] = twists


def _add(twists: Array, joints: VirtualJoints, indices: list[int]) -> None:
    """Set the columns of some deformations, which are the last ones."""
    first = twists.shape[1] - len(joints.deformations)
    for k in indices:
        twist = joints.deformations[k].twist
        twists[:, first + k] = twist


def _name(posed: PosedTree, body: int) -> str:
    """Name of the link of a body."""
    if body < 0:
        return posed.description.base
    return posed.tree.bodies[body].name
