"""What is taken where a file of another format does not say."""

from __future__ import annotations

from typing import Any

from .document import Document

END_EFFECTOR = "end_effector"  # the name under which poses of the end effector are asked for


def farthest_link(document: Document) -> str:
    """For files that name no end effector: the link or frame that is called so, or else the one behind most joints."""
    if any(END_EFFECTOR in document.section(section) for section in ("links", "frames")):
        return END_EFFECTOR
    joints = {joint["child"]: joint for joint in document.section("joints").values()}

    def depth(link: str) -> int:
        count, seen = 0, set()
        while link in joints and link not in seen:
            seen.add(link)
            count += joints[link]["type"] != "fixed"
            link = joints[link]["parent"]
        return count

    tied = {
        link for closure in document.section("closures").values() for link in closure["between"]
    }
    links = [link for link in document.section("links") if link not in tied]
    solid = [link for link in links if document.section("links")[link].get("mass")]
    link = max(solid or links or [document.data["base"]], key=depth)
    document.notes.append(
        f"no end effector is given; taken: '{link}', the link behind the most joints"
    )
    return str(link)


def neutral(joint: dict[str, Any]) -> float:
    """Zero, or the nearest limit."""
    lower, upper = joint.get("limits", (0.0, 0.0))
    return min(max(0.0, float(lower)), float(upper))


def driven_joints(document: Document) -> list[str]:
    """All joints that move on their own."""
    joints = document.section("joints").items()
    return [name for name, joint in joints if joint["type"] != "fixed" and "mimic" not in joint]
