"""The same robot on another spanning tree.

A loop is cut at another joint, and what hung on it hangs on the pin.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hybrid_dynamics_core.description import Closure, Frame, Joint, RobotDescription
from hybrid_dynamics_core.ground.arrays import frozen
from tests.generated.assembly import Pose, frame_with_normal, unit
from tests.generated.assembly import turn as turn_about
from tests.generated.robots import swapped
from tests.generated.space import Space

CUTTABLE = ("planar", "axis")  # closures that are a turning joint
PARALLELOGRAM = "parallelogram"


def other_cuts(robot: RobotDescription) -> list[tuple[str, str]]:
    """(closure, joint) wherever a loop may as well be cut.

    Turning joints that are not active, in loops of one pin. Not where bars of another loop turn
    round that is named a parallelogram: its four bars say so.
    """
    cuts: list[tuple[str, str]] = []
    for closure in robot.closures:
        if closure.kind not in CUTTABLE:
            continue
        others = [c for c in robot.closures if c is not closure and c.assembly == PARALLELOGRAM]
        for name in _loop(robot, closure):
            if robot.joints[name].type != "revolute" or name in robot.active:
                continue
            turned = {name, *turned_by(robot, closure, name)}
            if all(turned.isdisjoint(_loop(robot, other)) for other in others):
                cuts.append((closure.name, name))
    return sorted(cuts)


def turned_by(robot: RobotDescription, closure: Closure, cut: str) -> list[str]:
    """Joints between a cut and the closure, which turn round."""
    for link in (closure.link_a, closure.link_b):
        names = chain(robot, link)
        if cut in names:
            return names[names.index(cut) + 1 :]
    raise AssertionError("the cut is in the loop")


def chain(robot: RobotDescription, link: str) -> list[str]:
    """Joints from the base to a link."""
    carrier = {joint.child: name for name, joint in robot.joints.items()}
    names: list[str] = []
    while link in carrier:
        names.insert(0, carrier[link])
        link = robot.joints[carrier[link]].parent
    return names


def _loop(robot: RobotDescription, closure: Closure) -> set[str]:
    """Joints of the loop that a closure closes."""
    return set(chain(robot, closure.link_a)) ^ set(chain(robot, closure.link_b))


def rerooted(
    robot: RobotDescription, s: np.ndarray, names: tuple[str, ...], closure: str, cut: str
) -> RobotDescription:
    """The robot with a pin as a joint of the tree and a joint as the closure.

    The new joint has the closure's name, the new closure the joint's. The links between both turn
    round: each hangs on what hung on it.

    Args:
        robot: the robot.
        s: a closed configuration (n_s,).
        names: the coordinates in its order.
        closure: name of the pin.
        cut: name of the joint.
    """
    return _Rerooting(robot, s, names, closure, cut).description()


class _Rerooting:
    """A robot before and after its links between a pin and a joint have turned round."""

    def __init__(
        self, robot: RobotDescription, s: np.ndarray, names: tuple[str, ...], closure: str, cut: str
    ) -> None:
        self.robot = robot
        self.closure = closure
        self.cut = cut
        self.poses = Space(robot, names).poses(s)
        self.values = dict(zip(names, s.tolist(), strict=True))
        self.pin = next(c for c in robot.closures if c.name == closure)
        if cut not in chain(robot, self.pin.link_a):
            self.pin = swapped(self.pin)
        self.turned = turned_by(robot, self.pin, cut)
        self.new_poses = self._new_poses()

    def description(self) -> RobotDescription:
        """The robot on the other tree."""
        joints = self._joints()
        closures = [self._moved_closure(c) for c in self.robot.closures if c.name != self.closure]
        reference = {name: self.values[name] for name in joints if name in self.values}
        return replace(
            self.robot,
            links=self._links(),
            joints=joints,
            closures=(*closures, self._new_closure()),
            loops={},
            frames=self._frames(),
            reference={**reference, self.closure: 0.0},
            effects={n: effect for n, effect in self.robot.effects.items() if n != self.cut},
        )

    def _place(self, joint: str) -> np.ndarray:
        """Where a joint is, in the base frame."""
        _, place = self.poses[self.robot.joints[joint].child]
        return place

    def _axis(self, joint: str) -> np.ndarray:
        """Axis of a joint, in the base frame."""
        turn, _ = self.poses[self.robot.joints[joint].child]
        return turn @ self.robot.joints[joint].axis

    def _new_poses(self) -> dict[str, Pose]:
        """Poses of links, whose origins are at the joints that carry them now."""
        turn, origin = self.poses[self.pin.link_a]
        origins = {self.pin.link_a: origin + turn @ self.pin.point_a}
        for name in self.turned:
            origins[self.robot.joints[name].parent] = self._place(name)
        poses: dict[str, Pose] = {}
        for link, (turn, origin) in self.poses.items():
            poses[link] = (turn, origins.get(link, origin))
        return poses

    def _joints(self) -> dict[str, Joint]:
        """The joints of the new tree, that of the pin first."""
        pin = self.pin
        if pin.kind == "planar":
            axis = self._axis(self.cut)
        else:
            axis = self.poses[pin.link_a][0] @ pin.rotation_a[:, 2]
        first = self._joint(self.closure, "revolute", (pin.link_b, pin.link_a), axis, 0.0)
        joints = {self.closure: first}
        for name, joint in self.robot.joints.items():
            if name == self.cut:
                continue
            links = (joint.parent, joint.child)
            axis = self._axis(name)
            # the same joint seen from its other link: its axis turns round
            if name in self.turned:
                links = (joint.child, joint.parent)
                axis = -axis
            joints[name] = self._joint(name, joint.type, links, axis, self.values[name])
        return joints

    def _joint(
        self, name: str, kind: str, links: tuple[str, str], axis: np.ndarray, value: float
    ) -> Joint:
        """The joint that lets the child be at its pose for this value."""
        parent, child = links
        turn, origin = self.new_poses[child]
        parent_turn, parent_origin = self.new_poses[parent]
        axis_in_child = turn.T @ axis
        if kind == "revolute":
            rotation = parent_turn.T @ turn @ turn_about(axis_in_child, -value)
            place = parent_turn.T @ (origin - parent_origin)
        else:
            rotation = parent_turn.T @ turn
            place = parent_turn.T @ (origin - value * axis - parent_origin)
        return Joint(
            name, kind, parent, child, frozen(rotation), frozen(place), frozen(axis_in_child)
        )

    def _new_closure(self) -> Closure:
        """The joint as a closure."""
        joint = self.robot.joints[self.cut]
        place = self._place(self.cut)
        axle = frame_with_normal(unit(self._axis(self.cut)), None)
        (turn_a, origin_a), (turn_b, origin_b) = (
            self.new_poses[link] for link in (joint.parent, joint.child)
        )
        return Closure(
            self.cut,
            joint.parent,
            frozen(turn_a.T @ (place - origin_a)),
            joint.child,
            frozen(turn_b.T @ (place - origin_b)),
            kind=self.pin.kind,
            rotation_a=frozen(turn_a.T @ axle),
            rotation_b=frozen(turn_b.T @ axle),
            assembly=_parallelogram_only(self.pin),
        )

    def _moved_closure(self, closure: Closure) -> Closure:
        """The closure on links whose frames have moved."""
        return replace(
            closure,
            point_a=frozen(closure.point_a - self._shift(closure.link_a)),
            point_b=frozen(closure.point_b - self._shift(closure.link_b)),
            assembly=_parallelogram_only(closure),
        )

    def _links(self) -> dict:
        links = {}
        for name, link in self.robot.links.items():
            links[name] = replace(link, com=frozen(link.com - self._shift(name)))
        return links

    def _frames(self) -> dict[str, Frame]:
        frames = {}
        for name, frame in self.robot.frames.items():
            moved = frozen(frame.translation - self._shift(frame.link))
            frames[name] = Frame(frame.link, frame.rotation, moved)
        return frames

    def _shift(self, link: str) -> np.ndarray:
        """How far a link's origin has moved, in link axes."""
        turn, origin = self.poses[link]
        _, new_origin = self.new_poses[link]
        return turn.T @ (new_origin - origin)


def _parallelogram_only(closure: Closure) -> str | None:
    """Its mode, if it is a parallelogram; others are then those of the reference."""
    if closure.assembly == PARALLELOGRAM:
        return PARALLELOGRAM
    return None
