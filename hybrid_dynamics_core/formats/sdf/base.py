"""The base of an SDFormat model: a link, or the world with links fixed to it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..xml.reader import XmlReader
from .joints import JointReader
from .poses import WORLD, ModelPoses, pose_entry
from .spanning_tree import reached_links

_MAX_LISTED = 8  # links in a note


@dataclass(frozen=True, eq=False)
class Base:
    """The base, and the links fixed to it.

    Attributes:
        link: the base.
        on_it: links fixed to it.
        joints: joints of the movable links.
    """

    link: str
    on_it: list[str]
    joints: list[JointReader]


def find_base(xml: XmlReader, poses: ModelPoses, joints: Sequence[JointReader]) -> Base:
    """Find the base of a model.

    Each part without a joint to the world is fixed at its first link without a parent.

    Args:
        xml: the file, whose links are in the document.
        poses: poses of the model.
        joints: joints of the model.
    """
    grounded = [joint for joint in joints if joint.is_grounded()]
    roots = _loose_roots(xml, joints, bool(grounded))
    if len(roots) == 1 and not grounded:
        (base,) = roots
        xml.document.notes.append(f"{base}: not joined to the world; taken as what stands still")
        return Base(base, [], list(joints))
    if len(grounded) == 1 and not roots and _welds_child(grounded[0]):
        (ground,) = grounded
        ground.note_unused()
        return Base(ground.child(), [], [joint for joint in joints if joint is not ground])
    xml.document.section("links").setdefault(WORLD, {})
    for root in roots:
        _put_on_world(xml, poses, root)
    return Base(WORLD, roots, list(joints))


def _welds_child(joint: JointReader) -> bool:
    return joint.type == "fixed" and joint.parent() == WORLD


def _loose_roots(xml: XmlReader, joints: Sequence[JointReader], is_grounded: bool) -> list[str]:
    """A root link of each part without a joint to the world."""
    links = list(xml.document.section("links"))
    children = {joint.child() for joint in joints}
    in_order = sorted(links, key=lambda link: link in children)  # links without a parent first
    reached: set[str] = set()
    if is_grounded:
        reached = reached_links(joints, WORLD)
    roots: list[str] = []
    for link in in_order:
        if link not in reached:
            roots.append(link)
            reached |= reached_links(joints, link)
    return roots


def _put_on_world(xml: XmlReader, poses: ModelPoses, root: str) -> None:
    """Fix the root of a floating part at its drawn pose."""
    origin = pose_entry(poses.in_link(WORLD, poses.link(root)))
    entry = {"type": "fixed", "parent": WORLD, "child": root, "origin": origin}
    joints = xml.document.section("joints")
    name = f"world_to_{root}"
    while name in joints:
        name += "_"
    joints[name] = entry
    xml.document.notes.append(f"{root}: not joined to the world; taken as standing still on it")
