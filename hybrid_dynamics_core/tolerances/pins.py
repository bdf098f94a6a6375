"""Where a pin has play: joints of the tree, and closures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from ..closure.constraints.plane import normal_basis, plane_basis
from ..description.model import Closure, Joint, RobotDescription
from ..errors import InputError
from ..ground.arrays import Array, frozen
from ..ground.suggestions import suggestion
from ..mechanism.tree import Tree
from .entries import PLAY

Place = Literal["joint", "closure"]
_EVERY_WAY = np.eye(3)


@dataclass(frozen=True, eq=False)
class Pin:
    """A pin with play.

    Attributes:
        name: path of the play, such as `joints.q2.play`.
        place: what it is part of.
        key: name of the joint or closure.
        link: the link that has the hole.
        free_directions: columns (3, d), in axes of the link, along which the pin is free.
    """

    name: str
    place: Place
    key: str
    link: str
    free_directions: Array


def pin_of(name: str, robot: RobotDescription, tree: Tree) -> Pin:
    """The pin of a path such as `joints.q2.play` or `loops.lift.play`.

    Raises:
        InputError: there is no such pin.
    """
    part, _, key = name.removesuffix(PLAY).partition(".")
    closures = {closure.name: closure for closure in robot.closures}
    if part == "joints" and key in robot.multi_dof:
        return _ball(name, robot, key)
    if part == "joints" and key in robot.joints:
        joint = robot.joints[key]
        across = joint.rotation @ normal_basis(joint.axis)[:2].T
        return Pin(name, "joint", key, joint.parent, across)
    if part in ("loops", "closures") and key in closures:
        closure = closures[key]
        return Pin(name, "closure", key, closure.link_a, _ways(name, tree, closure))
    pins = [f"joints.{joint}{PLAY}" for joint in (*robot.joints, *robot.multi_dof)]
    pins += [f"{part}.{closure}{PLAY}" for closure in closures]
    raise InputError(
        f"tolerances: there is no pin '{name}'{suggestion(name, pins)}; expected"
        f" joints.NAME{PLAY}, loops.NAME{PLAY} or closures.NAME{PLAY}"
    )


def _ball(name: str, robot: RobotDescription, key: str) -> Pin:
    """The centre of a ball joint."""
    joint = robot.multi_dof[key]
    if joint.type != "ball":
        raise InputError(
            f"tolerances: {name}: '{key}' is a {joint.type} joint, which has no single pin;"
            " give the play of a hinge, slide or ball joint"
        )
    return Pin(name, "joint", joint.joints[0], joint.parent, _EVERY_WAY)


def _ways(name: str, tree: Tree, closure: Closure) -> Array:
    """Directions (3, d) in which the pin of a closure is free, in the axes of link a."""
    if closure.kind == "point":
        return _EVERY_WAY
    if closure.kind == "axis":
        return np.asarray(closure.rotation_a[:, :2])
    if closure.kind == "frame":
        raise InputError(f"tolerances: {name}: a weld has no pin, and no play")
    a, b = tree.body_index(closure.link_a), tree.body_index(closure.link_b)
    path_a, path_b, ancestor = tree.branches(a, b)
    in_plane = plane_basis(tree, path_a + path_b, ancestor)[:2]
    rotation, _ = tree.zero_pose(a, ancestor)
    return np.asarray(rotation.T @ in_plane.T)


def with_displaced(
    robot: RobotDescription, pins: Sequence[Pin], displacements: Sequence[Any]
) -> RobotDescription:
    """The description with each pin displaced in its hole.

    Args:
        robot: a description; not changed.
        pins: the pins.
        displacements: of each, (d,) along its directions [m]; numbers may be live.
    """
    joints: dict[str, Joint] = dict(robot.joints)
    closures = {closure.name: closure for closure in robot.closures}
    for pin, displacement in zip(pins, displacements, strict=True):
        moved = pin.free_directions @ np.array(displacement)
        if pin.place == "joint":
            joint = joints[pin.key]
            joints[pin.key] = replace(joint, translation=frozen(joint.translation + moved))
        else:
            closure = closures[pin.key]
            closures[pin.key] = replace(closure, point_a=frozen(closure.point_a + moved))
    return replace(robot, joints=joints, closures=tuple(closures.values()))
