"""Defaults for data that a file of another format does not give."""

from __future__ import annotations

from .document import Data, Document
from .model import END_EFFECTOR


def farthest_link(document: Document) -> str:
    """The end effector of a file that names none; a note is added.

    It is the link or frame `end_effector`, or else the link behind most joints.
    """
    if END_EFFECTOR in document.section("links") or END_EFFECTOR in document.section("frames"):
        return END_EFFECTOR
    joints = document.section("joints").values()
    joint_to = {joint["child"]: joint for joint in joints}
    link = max(_candidates(document), key=lambda name: _depth(name, joint_to))
    document.notes.append(
        f"no end effector is given; taken: '{link}', the link behind the most joints"
    )
    return str(link)


def neutral_coordinate(joint: Data) -> float:
    """Zero, or the limit nearest to it [rad or m]."""
    lower, upper = joint.get("limits", (0.0, 0.0))
    return min(max(0.0, float(lower)), float(upper))


def driven_joints(document: Document) -> list[str]:
    """All joints that follow no other, except those of floating bodies."""
    loose: set[str] = set()
    for row in document.entries("multi_dof").values():
        if row["type"] == "free":
            loose.update(row["joints"])
    driven: list[str] = []
    for name, joint in document.section("joints").items():
        is_driven = joint["type"] not in ("fixed", "free") and name not in loose
        if is_driven and "mimic" not in joint:
            driven.append(name)
    return driven


def _candidates(document: Document) -> list[str]:
    """Links without a closure, or the base if there are none; only those with mass if any has."""
    tied: set[str] = set()
    for closure in document.section("closures").values():
        tied.update(closure["between"])
    links = document.section("links")
    ends = [name for name in links if name not in tied]
    bodies = [name for name in ends if links[name].get("mass")]
    return bodies or ends or [document.data["base"]]


def _depth(link: str, joint_to: dict[str, Data]) -> int:
    """Number of moving joints from the base to a link; it ends if the joints form a cycle."""
    depth = 0
    visited: set[str] = set()
    while link in joint_to and link not in visited:
        visited.add(link)
        joint = joint_to[link]
        if joint["type"] != "fixed":
            depth += 1
        link = joint["parent"]
    return depth
