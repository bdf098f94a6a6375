"""The spanning tree of an SDFormat model: its joints, and the direction of each."""

from __future__ import annotations

from collections.abc import Sequence

from .joints import JointReader


def spanning_tree(joints: Sequence[JointReader], base: Sequence[str]) -> dict[str, bool]:
    """Choose the joints of the tree; for each name, whether the joint is reversed.

    Joints that no closure can replace come first, then all others in the order of the file.

    Args:
        joints: joints of the model.
        base: fixed links, where the tree begins.
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
    """All links that joints connect with the base, in either direction."""
    reached = {base}
    while True:
        steps = [joint for joint in joints if _is_next(joint, reached)]
        if not steps:
            return reached
        for joint in steps:
            reached.update((joint.parent(), joint.child()))


def _without_cycles(joints: Sequence[JointReader], base: Sequence[str]) -> list[JointReader]:
    """Joints without those that would close a cycle (union-find)."""
    first = [joint for joint in joints if not joint.closure_kind()]
    others = [joint for joint in joints if joint.closure_kind()]
    first_link, *standing = base
    # next link towards the representative of its group
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
    """Whether exactly one end of a joint is reached."""
    return (joint.parent() in reached) != (joint.child() in reached)
