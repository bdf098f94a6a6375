"""A loop as its file draws it, with all joints at zero."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

from ...description.model import Closure, RobotDescription
from ...ground.arrays import Array
from ...mechanism.tree import Tree

SHOWN = 1e-8  # [rad, m] a smaller change is not noted, since it is rounding
Loop = TypeVar("Loop", bound="DrawnLoop")


class DrawnLoop:
    """The loop of a closure at zero, in the frame of the link where its chains start.

    Attributes:
        closure: its closure.
        paths: names of the joints from that link to either end.
        rotations: rotations of the joints' frames (3, 3), by name.
        origins: origins of the joints' frames (3,) [m], by name.
        ends: rotation (3, 3) and origin (3,) of the links at the ends.
    """

    def __init__(self, robot: RobotDescription, tree: Tree, name: str) -> None:
        self.closure = next(closure for closure in robot.closures if closure.name == name)
        self.robot = robot
        a = tree.body_index(self.closure.link_a)
        b = tree.body_index(self.closure.link_b)
        path_a, path_b, ancestor = tree.branches(a, b)
        self.paths = []
        self.rotations: dict[str, Array] = {}
        self.origins: dict[str, Array] = {}
        for path in (path_a, path_b):
            names = [tree.bodies[body].joint for body in path]
            self.paths.append(names)
            for body, joint in zip(path, names, strict=True):
                rotation, origin = tree.zero_pose(body, ancestor)
                self.rotations[joint] = rotation
                self.origins[joint] = origin
        self.ends = (tree.zero_pose(a, ancestor), tree.zero_pose(b, ancestor))

    @property
    def joints(self) -> list[str]:
        """Names of all its joints, chain a first."""
        return [*self.paths[0], *self.paths[1]]

    def axis(self, joint: str) -> Array:
        """Axis (3,) of a joint."""
        axis: Array = self.rotations[joint] @ self.robot.joints[joint].axis
        return axis

    @property
    def closure_frames(self) -> list[tuple[Array, Array]]:
        """Rotations (3, 3) and origins (3,) [m] of the closure's two frames."""
        frames: list[tuple[Array, Array]] = []
        for (rotation, origin), frame in zip(self.ends, self.closure.frames(), strict=True):
            frames.append((rotation @ frame.rotation, rotation @ frame.translation + origin))
        return frames

    @property
    def hinges(self) -> list[str]:
        """Names of its revolute joints."""
        return [name for name in self.joints if self.robot.joints[name].type == "revolute"]


def loops_by_hinge(loops: Sequence[Loop]) -> list[list[Loop]]:
    """Groups of loops that share hinges, and hence a plane or a centre."""
    groups: list[list[Loop]] = []
    for loop in loops:
        sharing = [group for group in groups if _shares_hinge(loop, group)]
        merged = [one for group in sharing for one in group]
        groups = [group for group in groups if group not in sharing]
        groups.append([*merged, loop])
    return groups


def _shares_hinge(loop: DrawnLoop, group: Sequence[DrawnLoop]) -> bool:
    hinges = set(loop.hinges)
    return any(hinges.intersection(one.hinges) for one in group)


def with_changed(
    robot: RobotDescription,
    closure: Closure,
    changes: Mapping[str, Any],
    notes: Iterable[str],
) -> RobotDescription:
    """The description with fields of a closure changed, and notes on it added."""
    changed = replace(closure, **changes)
    closures = [changed if one is closure else one for one in robot.closures]
    return replace(
        robot,
        closures=tuple(closures),
        notes=(*robot.notes, *notes),
    )


def notes_on(robot: RobotDescription, key: str, text: str, size: float) -> Iterator[str]:
    """A note on a change at a key, unless its size [rad or m] is rounding."""
    if size > SHOWN:
        located = replace(robot, warnings=()).error(key, text)
        yield str(located)
