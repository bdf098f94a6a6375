"""Which joints of an SDFormat model make up its tree, and from which end each is walked."""

from __future__ import annotations

from collections.abc import Sequence

from .joints import JointReader


def spanning_tree(joints: Sequence[JointReader], base: Sequence[str]) -> dict[str, bool]:
    """The joints of the tree by name, each with whether it is walked from child to parent.

    Joints that no closure can stand for go before all others, then the order of the file holds.

    Args:
        joints: of the model.
        base: links that do not move, where the tree begins.
    """
    chosen = _without_cycles(joints, base)
    reached = set(base)
    directions: dict[str, bool] = {}
    while True:
        steps = [joint for joint in chosen if _is_next(joint, reached)]
        if not steps:
            return directions
        for joint in steps:
            directions[joint.name] = joint.child() in reached
            reached.update((joint.parent(), joint.child()))


def reached_links(joints: Sequence[JointReader], base: str) -> set[str]:
    """The links that joints connect with one, in whatever direction."""
    reached = {base}
    while True:
        steps = [joint for joint in joints if _is_next(joint, reached)]
        if not steps:
            return reached
        for joint in steps:
            reached.update((joint.parent(), joint.child()))


def _without_cycles(joints: Sequence[JointReader], base: Sequence[str]) -> list[JointReader]:
    """Joints that join what none before has joined."""
    first = [joint for joint in joints if not joint.closure_kind()]
    others = [joint for joint in joints if joint.closure_kind()]
    first_link, *standing = base
    # a link of the same group, nearer to its first one
    groups = dict.fromkeys(standing, first_link)
    chosen: list[JointReader] = []
    for joint in (*first, *others):
        parent_group = _first_of(groups, joint.parent())
        child_group = _first_of(groups, joint.child())
        if parent_group != child_group:
            groups[child_group] = parent_group
            chosen.append(joint)
    names = {joint.name for joint in chosen}
    return [joint for joint in joints if joint.name in names]


def _first_of(groups: dict[str, str], link: str) -> str:
    while link in groups:
        link = groups[link]
    return link


def _is_next(joint: JointReader, reached: set[str]) -> bool:
    """Whether one end of a joint is reached, and the other is not."""
    return (joint.parent() in reached) != (joint.child() in reached)
