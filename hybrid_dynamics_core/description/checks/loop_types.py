"""Loops of Type A to D, Chu et al. (2020), Section 2: whether the links given form the type that is claimed.

The letter says which link hangs on which, what the cut pin ties, and on which link the arm goes on.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...ground.suggestions import no_such_name
from ..document import Document, Path_
from ..model import Loop, RobotDescription


class _Type(NamedTuple):
    arm_on: str
    k2_on: str
    pin: tuple[str, str]
    goes_on: str


TYPES = {  # C is B, and D is A, with l_i and l_k2 exchanged; l_k1 always hangs on the base
    "A": _Type("base", "k1", ("arm", "k2"), "arm"),
    "B": _Type("base", "arm", ("k1", "k2"), "k2"),
    "C": _Type("k2", "base", ("k1", "arm"), "arm"),
    "D": _Type("k1", "base", ("k2", "arm"), "k2"),
}
ROLES = ("base", "arm", "k1", "k2")


def check_loop_names(document: Document) -> None:
    """Raise a DescriptionError where a loop names a link that does not exist, or one link in two roles."""
    known = [document.data.get("base", "base"), *document.data.get("links", {})]
    for name, entry in document.data.get("loops", {}).items():
        for role in ROLES:
            path: Path_ = ("loops", name, role)
            link = entry[role]
            if link not in known:
                problem = no_such_name("link", link, known)
                raise document.error(path, problem)
            other = next(r for r in ROLES if entry[r] == link)
            if other != role:
                raise document.error(
                    path, f"'{link}' is also {other}; a four-bar loop has four links"
                )


def check_loops(document: Document, robot: RobotDescription) -> None:
    """Raise a DescriptionError at the first loop whose links do not form its type."""
    for name, loop in robot.loops.items():
        _Check(document, robot, name, loop).check()


class _Check:
    def __init__(self, document: Document, robot: RobotDescription, name: str, loop: Loop) -> None:
        self.document, self.robot, self.loop = document, robot, loop
        self.path: Path_ = ("loops", name)
        self.links = {role: str(getattr(loop, role)) for role in ROLES}
        closure = next(c for c in robot.closures if c.name == name)
        self.pin = {closure.link_a, closure.link_b}
        self.joint_of = {joint.child: joint for joint in robot.joints.values()}

    def check(self) -> None:
        problem = self.misfit(self.loop.type)
        if problem is not None:
            key, text = problem
            fitting = [letter for letter in TYPES if self.misfit(letter) is None]
            hint = f"; the links as given form Type {fitting[0]}" if fitting else ""
            raise self.document.error((*self.path, key), text + hint)
        self.goes_on()

    def misfit(self, letter: str) -> tuple[str, str] | None:
        """The first contradiction between the tree and a type: (key, text)."""
        wanted = TYPES[letter]
        for role, on in (("k1", "base"), ("k2", wanted.k2_on), ("arm", wanted.arm_on)):
            if not self.hangs(role, on):
                found = (
                    self.joint_of[self.links[role]].parent
                    if self.links[role] in self.joint_of
                    else "nothing"
                )
                return (
                    role,
                    (
                        f"in a loop of Type {letter} the link of `{role}` hangs on that of `{on}`,"
                        f" but here '{self.links[role]}' hangs on '{found}', not on"
                        f" '{self.links[on]}'"
                    ),
                )
        tied = {self.links[role] for role in wanted.pin}
        if self.pin != tied:
            return (
                "pin",
                (
                    f"in a loop of Type {letter} the pin ties the links of `{wanted.pin[0]}` and"
                    f" `{wanted.pin[1]}` ('{self.links[wanted.pin[0]]}' and"
                    f" '{self.links[wanted.pin[1]]}'), but here it ties"
                    f" {' and '.join(repr(x) for x in sorted(self.pin))}"
                ),
            )
        return None

    def hangs(self, role: str, on: str) -> bool:
        """Whether a link hangs on another, or beside it on the same pivot (one pin through three links)."""
        joint, other = self.joint_of.get(self.links[role]), self.joint_of.get(self.links[on])
        if joint is None:
            return False
        if joint.parent == self.links[on]:
            return True
        if on != "base" or other is None or other.parent != joint.parent:
            return False
        if joint.type != "revolute" or other.type != "revolute":
            return False
        axis = joint.rotation @ joint.axis
        apart = joint.translation - other.translation
        skew = float(np.linalg.norm(np.cross(axis, other.rotation @ other.axis)))
        return skew < 1e-9 and float(np.linalg.norm(np.cross(axis, apart))) < 1e-9

    def goes_on(self) -> None:
        """The claim about the link that carries the arm on, where the tree tells."""
        claimed = self.links[TYPES[self.loop.type].goes_on]
        members = [self.links[role] for role in ("arm", "k1", "k2")]
        on_the_way = [link for link in self._to_end_effector() if link in members]
        if not on_the_way or on_the_way[0] == claimed or self._carries(claimed):
            return
        raise self.document.error(
            (*self.path, "type"),
            f"in a loop of Type {self.loop.type} the arm goes on from '{claimed}', but the end"
            f" effector hangs on '{on_the_way[0]}' and '{claimed}' carries nothing; choose another"
            f" type, or hang the next link on '{claimed}'",
        )

    def _to_end_effector(self) -> list[str]:
        """Links from the end effector down to the base."""
        link = self.robot.frames[self.robot.end_effector].link
        links = [link]
        while link in self.joint_of:
            link = self.joint_of[link].parent
            links.append(link)
        return links

    def _carries(self, link: str) -> bool:
        members = set(self.links.values())
        hung = any(
            joint.parent == link and joint.child not in members
            for joint in self.robot.joints.values()
        )
        tied = any(
            link in (c.link_a, c.link_b) for c in self.robot.closures if c.name != self.loop.name
        )
        return hung or tied
