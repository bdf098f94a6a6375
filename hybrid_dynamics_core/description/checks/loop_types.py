"""Whether the links of a loop form its type: A to D of Chu et al. (2020), Section 2.

A type fixes the parents of the links, the two links of the cut pin, and the link on which the arm
continues.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...ground.suggestions import no_such_name
from ..document import Document, KeyPath
from ..model import Joint, Loop, RobotDescription

_ROLES = ("base", "arm", "k1", "k2")
_SAME_DIRECTION = 1e-4  # [rad] between two axes, from numbers with few digits
_SAME_LINE = 1e-5  # [m] between them


class _LoopType(NamedTuple):
    """Roles of links: parents of arm and k2, ends of the pin, and the output link."""

    arm_on: str
    k2_on: str
    pin: tuple[str, str]
    output: str


_TYPES = {  # C is B, and D is A, with l_i and l_k2 exchanged; l_k1 always hangs on the base
    "A": _LoopType("base", "k1", ("arm", "k2"), "arm"),
    "B": _LoopType("base", "arm", ("k1", "k2"), "k2"),
    "C": _LoopType("k2", "base", ("k1", "arm"), "arm"),
    "D": _LoopType("k1", "base", ("k2", "arm"), "k2"),
}


def check_loop_names(document: Document) -> None:
    """Check that every loop names four links.

    Raises:
        DescriptionError: a link does not exist, or has two roles.
    """
    base = document.data.get("base", "base")
    links = [base, *document.entries("links")]
    for name, entry in document.entries("loops").items():
        for role in _ROLES:
            path: KeyPath = ("loops", name, role)
            link = entry[role]
            if link not in links:
                raise document.error(path, no_such_name("link", link, links))
            first_role = next(other for other in _ROLES if entry[other] == link)
            if first_role != role:
                raise document.error(
                    path, f"'{link}' is also {first_role}; a four-bar loop has four links"
                )


def check_loop_types(document: Document, robot: RobotDescription) -> None:
    """Check that the links of every loop form its type.

    Raises:
        DescriptionError: the first loop whose links do not.
    """
    for loop in robot.loops.values():
        _LoopCheck(document, robot, loop).check()


class _LoopCheck:
    def __init__(self, document: Document, robot: RobotDescription, loop: Loop) -> None:
        self.document = document
        self.robot = robot
        self.loop = loop
        self.path: KeyPath = ("loops", loop.name)
        self.links = {role: str(getattr(loop, role)) for role in _ROLES}
        closures = {closure.name: closure for closure in robot.closures}
        pin = closures[loop.name]
        self.pinned = {pin.link_a, pin.link_b}
        self.joint_to = robot.joint_to()

    def check(self) -> None:
        contradiction = self.contradiction(self.loop.type)
        if contradiction is not None:
            key, problem = contradiction
            for letter in _TYPES:
                if self.contradiction(letter) is None:
                    problem += f"; the links as given form Type {letter}"
                    break
            raise self.document.error((*self.path, key), problem)
        self.check_output()

    def contradiction(self, letter: str) -> tuple[str, str] | None:
        """The first contradiction between the tree and a type: (key, problem)."""
        loop_type = _TYPES[letter]
        carriers = {"k1": "base", "k2": loop_type.k2_on, "arm": loop_type.arm_on}
        for role, carrier in carriers.items():
            if not self.hangs_on(role, carrier):
                return role, self.wrong_carrier(letter, role, carrier)
        if self.pinned != {self.links[role] for role in loop_type.pin}:
            return "pin", self.wrong_pin(letter)
        return None

    def wrong_carrier(self, letter: str, role: str, carrier: str) -> str:
        link = self.links[role]
        parent = "nothing"
        if link in self.joint_to:
            parent = self.joint_to[link].parent
        return (
            f"in a loop of Type {letter} the link of `{role}` hangs on that of `{carrier}`, but"
            f" here '{link}' hangs on '{parent}', not on '{self.links[carrier]}'"
        )

    def wrong_pin(self, letter: str) -> str:
        one, other = _TYPES[letter].pin
        pinned = " and ".join(repr(link) for link in sorted(self.pinned))
        return (
            f"in a loop of Type {letter} the pin ties the links of `{one}` and `{other}`"
            f" ('{self.links[one]}' and '{self.links[other]}'), but here it ties {pinned}"
        )

    def hangs_on(self, role: str, carrier: str) -> bool:
        """Whether a link is a child of another, or shares a pivot with it on a common parent."""
        joint = self.joint_to.get(self.links[role])
        if joint is None:
            return False
        if joint.parent == self.links[carrier]:
            return True
        beside = self.joint_to.get(self.links[carrier])
        if carrier != "base" or beside is None or beside.parent != joint.parent:
            return False
        return _share_pivot(joint, beside)

    def check_output(self) -> None:
        """Check the output link, if the tree shows on which link the arm continues."""
        output = self.links[_TYPES[self.loop.type].output]
        members = [self.links[role] for role in ("arm", "k1", "k2")]
        carriers = [link for link in self.links_below_end_effector() if link in members]
        if not carriers or carriers[0] == output or self.carries_something(output):
            return
        raise self.document.error(
            (*self.path, "type"),
            f"in a loop of Type {self.loop.type} the arm goes on from '{output}', but the end"
            f" effector hangs on '{carriers[0]}' and '{output}' carries nothing; choose another"
            f" type, or hang the next link on '{output}'",
        )

    def links_below_end_effector(self) -> list[str]:
        """Links from the end effector down to the base."""
        link = self.robot.frames[self.robot.end_effector].link
        links = [link]
        while link in self.joint_to:
            link = self.joint_to[link].parent
            links.append(link)
        return links

    def carries_something(self, link: str) -> bool:
        """Whether a link carries links outside of the loop, or has other closures."""
        members = set(self.links.values())
        for joint in self.robot.joints.values():
            if joint.parent == link and joint.child not in members:
                return True
        for closure in self.robot.closures:
            ends = (closure.link_a, closure.link_b)
            if closure.name != self.loop.name and link in ends:
                return True
        return False


def _share_pivot(one: Joint, other: Joint) -> bool:
    """Whether two revolute joints on one link have the same axis."""
    if one.type != "revolute" or other.type != "revolute":
        return False
    axis = one.rotation @ one.axis
    skew = np.cross(axis, other.rotation @ other.axis)
    distance = np.cross(axis, one.translation - other.translation)
    is_parallel = np.linalg.norm(skew) < _SAME_DIRECTION
    return bool(is_parallel and np.linalg.norm(distance) < _SAME_LINE)
