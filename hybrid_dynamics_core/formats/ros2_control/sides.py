"""The two sides of a transmission: drives, and the joints of the serial arm."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...errors import InputError
from ...ground.arrays import Array
from ...ground.suggestions import no_such_name
from ...robot.robot import Robot

INDEPENDENT = 1e-6  # least singular value of unit rows of rates


@dataclass(frozen=True)
class Sides:
    """A robot with the drives as independent coordinates, and the same with the joints.

    Attributes:
        drives: the robot as it is.
        joints: the same robot, whose active coordinates are the joints.
        same: whether the joints are the drives.
    """

    drives: Robot
    joints: Robot
    same: bool

    @property
    def joints_in_drives(self) -> list[int]:
        """Index of each joint among the coordinates of the drives' model."""
        return _places(self.joints.active, self.drives)

    @property
    def drives_in_joints(self) -> list[int]:
        """Index of each drive among the coordinates of the joints' model."""
        return _places(self.drives.active, self.joints)

    @property
    def order(self) -> list[int]:
        """Index of each coordinate of the joints' model in that of the drives."""
        return _places(self.joints.coordinates, self.drives)


def _places(names: Sequence[str], robot: Robot) -> list[int]:
    return [robot.coordinates.index(name) for name in names]


def sides_of(robot: Robot, joints: Sequence[str] | None = None) -> Sides:
    """Both sides of a robot.

    Args:
        robot: the robot.
        joints: names of the joints; if None, those on the way to the end effector that move
            independently, and as many drives as are missing.

    Raises:
        InputError: nothing moves, a coordinate has no drive of its own, a name is unknown, or the
            joints do not determine the motion.
    """
    if not robot.active:
        raise InputError(f"{robot.name}: nothing moves, so there is nothing to control")
    if tuple(robot.all_drives) != robot.active:
        listed = ", ".join(robot.all_drives) or "none"
        raise InputError(
            f"{robot.name}: a transmission needs one drive for each independent coordinate"
            f" ({', '.join(robot.active)}); the drives are {listed}"
        )
    state = robot.close(robot.reference)
    if joints is None:
        joints = _serial_joints(robot, state.R)
    _check(robot, joints, state.R)
    chosen = tuple(joints)
    if chosen == robot.active:
        return Sides(robot, robot, same=True)
    return Sides(robot, _with_active(robot, chosen, state.s), same=False)


def _with_active(robot: Robot, active: tuple[str, ...], s: Array) -> Robot:
    """The robot with other independent coordinates, on the assembly modes of a configuration."""
    description = robot.description
    # the names of modes are those of other unknowns: the configuration itself decides
    closures = tuple(replace(closure, assembly=None) for closure in description.closures)
    reference = dict(zip(robot.coordinates, s.tolist(), strict=True))
    changed = replace(
        description,
        active=active,
        active_set="exact",
        closures=closures,
        reference=reference,
    )
    return Robot(changed)


def _serial_joints(robot: Robot, rates: Array) -> list[str]:
    """Independent joints from the base to the end effector, then drives until n are there."""
    chosen: list[str] = []
    for name in (*_chain(robot), *robot.active):
        if name not in chosen and _is_independent(robot, [*chosen, name], rates):
            chosen.append(name)
    return chosen


def _chain(robot: Robot) -> list[str]:
    """All joints from the base to the end effector."""
    description = robot.description
    carriers = {joint.child: joint for joint in description.joints.values()}
    link = description.frames[robot.end_effector].link
    names = []
    while link in carriers:
        names.append(carriers[link].name)
        link = carriers[link].parent
    return names[::-1]


def _is_independent(robot: Robot, names: Sequence[str], rates: Array) -> bool:
    """Whether the rates of coordinates are independent, at a state with rates per unit u'."""
    rows = rates[_places(names, robot)]
    lengths = np.linalg.norm(rows, axis=1, keepdims=True)
    if len(names) > rows.shape[1] or not (lengths > INDEPENDENT).all():
        return False
    least = np.linalg.svd(rows / lengths, compute_uv=False)[-1]
    return bool(least > INDEPENDENT)


def _check(robot: Robot, joints: Sequence[str], rates: Array) -> None:
    """Raise InputError if joints do not determine the motion."""
    for name in joints:
        if name not in robot.coordinates:
            raise InputError(no_such_name("joint", name, robot.coordinates))
    count = len(robot.active)
    if len(joints) != count or not _is_independent(robot, joints, rates):
        raise InputError(
            f"{robot.name}: the joints {', '.join(joints)} do not determine the motion; expected"
            f" {count} that move independently at the reference"
        )
