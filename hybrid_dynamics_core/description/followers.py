"""Joints that follow others, as plain data."""

from __future__ import annotations

from .document import Data, KeyPath

_ONE = "as in mimic: {joint: q1, multiplier: 2}"
_SEVERAL = "as in mimic: {joints: {q1: -1, q2: -1}}"


def multipliers_of(mimic: Data) -> dict[str, float | str]:
    """Multiplier of each joint that a follower follows, by name."""
    if "joints" in mimic:
        return dict(mimic["joints"])
    return {mimic["joint"]: mimic.get("multiplier", 1.0)}


def multiplier_path(mimic: Data, path: KeyPath, source: str) -> KeyPath:
    """The path of the multiplier of a followed joint; `path` is that of the follower's entry."""
    if "joints" in mimic:
        return (*path, "joints", source)
    return (*path, "multiplier")


def form_problem(mimic: Data) -> str:
    """The error text for the keys of a follower's entry; empty if they are right."""
    has_one = "joint" in mimic
    has_several = "joints" in mimic
    if has_one and has_several:
        return f"has joint and joints; expected one of them, {_ONE}, or {_SEVERAL}"
    if has_several and "multiplier" in mimic:
        return f"has joints and a multiplier; the multipliers stand beside the joints, {_SEVERAL}"
    if not has_one and not has_several:
        return f"does not say what is followed; expected one joint, {_ONE}, or several, {_SEVERAL}"
    return ""


def mimic_entry(multipliers: dict[str, float], offset: float) -> Data:
    """The entry of a follower in a description file."""
    if len(multipliers) > 1:
        return {"joints": multipliers, "offset": offset}
    ((source, multiplier),) = multipliers.items()
    return {
        "joint": source,
        "multiplier": multiplier,
        "offset": offset,
    }
