"""What the schema cannot say: names that exist, one tree, loops of the type they claim."""

from __future__ import annotations

from collections.abc import Iterable

from .located_yaml import LocatedDocument, Path_
from .model import RobotDescription
from .schema import nearest


def check_description(document: LocatedDocument, robot: RobotDescription) -> None:
    """Raise a DescriptionError at the first entry that contradicts another one."""
    _check_tree(document, robot)
    _check_frames(document, robot)
    _check_loops(document, robot)
    _check_active(document, robot)


def _require(document: LocatedDocument, name: str, known: Iterable[str], path: Path_, kind: str) -> None:
    known = list(known)
    if name not in known:
        raise document.error(path, f"there is no {kind} '{name}'{nearest(name, known)}; known: {', '.join(known)}")


def _links(robot: RobotDescription) -> list[str]:
    return [robot.base, *(name for name in robot.links if name != robot.base)]


def _check_tree(document: LocatedDocument, robot: RobotDescription) -> None:
    parent_joint: dict[str, str] = {}
    for name, joint in robot.joints.items():
        path: Path_ = ("joints", name)
        _require(document, joint.parent, _links(robot), (*path, "parent"), "link")
        _require(document, joint.child, _links(robot), (*path, "child"), "link")
        if joint.child == robot.base:
            raise document.error((*path, "child"), f"the base '{robot.base}' cannot be a child; swap parent and child")
        if joint.child in parent_joint:
            other = parent_joint[joint.child]
            raise document.error(
                (*path, "child"),
                f"link '{joint.child}' already hangs on joint '{other}'; a link has one joint to its parent: "
                "close the second connection with a loop",
            )
        parent_joint[joint.child] = name
    for link in robot.links:
        if link != robot.base and link not in parent_joint:
            raise document.error(
                ("links", link), "no joint has this link as its child; add the joint or remove the link"
            )
        _check_reaches_base(document, robot, parent_joint, link)


def _check_reaches_base(
    document: LocatedDocument, robot: RobotDescription, parent_joint: dict[str, str], link: str
) -> None:
    seen = [link]
    while seen[-1] != robot.base:
        parent = robot.joints[parent_joint[seen[-1]]].parent
        if parent in seen:
            chain = " -> ".join([*reversed(seen), parent] if len(seen) == 1 else [*seen, parent])
            raise document.error(
                ("joints", parent_joint[link]),
                f"the joints form a cycle ({chain}) that never reaches the base '{robot.base}'",
            )
        seen.append(parent)


def _check_frames(document: LocatedDocument, robot: RobotDescription) -> None:
    for name, frame in robot.frames.items():
        path: Path_ = (name,) if name == "end_effector" else ("frames", name)
        _require(document, frame.link, _links(robot), (*path, "link"), "link")
        if name in _links(robot) and name != frame.link:
            raise document.error(path, f"'{name}' is also the name of a link; frames need names of their own")
    for name, (place, _) in robot.payloads.items():
        _require(document, place, (*robot.frames, *_links(robot)), ("payloads", name, "on"), "frame or link")


def _check_active(document: LocatedDocument, robot: RobotDescription) -> None:
    for k, name in enumerate(robot.active):
        _require(document, name, robot.joints, ("active", k), "joint")
    for name, value in robot.reference.items():
        _require(document, name, robot.joints, ("reference", name), "joint")
        lower, upper = robot.joints[name].limits
        if not lower <= value <= upper:
            raise document.error(
                ("reference", name), f"is {value:g}, outside the limits [{lower:g}, {upper:g}] of the joint"
            )


def _check_loops(document: LocatedDocument, robot: RobotDescription) -> None:
    hangs_on = {joint.child: joint.parent for joint in robot.joints.values()}
    pins = {closure.name: {closure.link_a, closure.link_b} for closure in robot.closures}
    for name, loop in robot.loops.items():
        path: Path_ = ("loops", name)
        for role in ("base", "arm", "k1", "k2"):
            _require(document, getattr(loop, role), _links(robot), (*path, role), "link")
        for link in pins[name]:
            _require(document, link, (loop.base, loop.arm, loop.k1, loop.k2), (*path, "pin"), "link of this loop")
        k2_on, pin_to = (loop.k1, {loop.k2, loop.arm}) if loop.type == "A" else (loop.arm, {loop.k1, loop.k2})
        if hangs_on.get(loop.k2) != k2_on:
            raise document.error(
                (*path, "k2"),
                f"in a loop of Type {loop.type} '{loop.k2}' hangs on '{k2_on}', not on '{hangs_on.get(loop.k2)}'",
            )
        if hangs_on.get(loop.k1) != loop.base:
            raise document.error((*path, "k1"), f"l_k1 = '{loop.k1}' must hang on the loop's base '{loop.base}'")
        if pins[name] != pin_to:
            raise document.error(
                (*path, "pin"), f"in a loop of Type {loop.type} the pin ties {' and '.join(sorted(pin_to))}"
            )
