"""Denavit-Hartenberg rows -> joints, in both conventions.

Standard:  T = Rz(theta) Tz(d) Tx(a) Rx(alpha). The joint moves about or along z of the link before,
so its constant
part behind the joint, Tx(a) Rx(alpha), becomes the frame in which the link's data are given: the
link's frame stays the
Denavit-Hartenberg frame.
Modified (Craig):  T = Rx(alpha) Tx(a) Rz(theta) Tz(d). The link's frame stands at its own joint.
"""

from __future__ import annotations

from typing import Any

from ..document import Document, Path_

COPIED = ("limits", "friction", "drive", "spring")  # keys of a row that a joint has too


def expand_chain(document: Document) -> None:
    """Add the joint of every row, and the frame of its link in the standard convention."""
    chain = document.data.pop("chain", None)
    if chain is None:
        return
    parent = chain.get("base", document.data.get("base", "base"))
    for k, row in enumerate(chain["rows"]):
        _expand_row(
            document,
            row,
            row.get("parent", parent),
            ("chain", "rows", k),
            chain["convention"] == "standard",
        )
        parent = row["child"]


def _expand_row(
    document: Document, row: dict[str, Any], parent: str, written: Path_, standard: bool
) -> None:
    theta, d, a, alpha = (row.get(key, 0) for key in ("theta", "d", "a", "alpha"))
    about_z = {"xyz": [0, 0, d], "rpy": [0, 0, theta]}
    about_x = {"xyz": [a, 0, 0], "rpy": [alpha, 0, 0]}
    joint: dict[str, Any] = {
        "type": row.get("type", "revolute"),
        "parent": parent,
        "child": row["child"],
        "origin": [about_z] if standard else [about_x, about_z],
        "axis": "z",
    }
    joint |= {key: row[key] for key in COPIED if key in row}
    path = ("joints", row["joint"])
    document.add(path, joint, written)
    document.alias(
        (*path, "parent"), (*written, "parent") if "parent" in row else (*written[:1], "base")
    )
    about_z_path = (*path, "origin", 0 if standard else 1)
    document.alias((*about_z_path, "xyz", 2), (*written, "d"))
    document.alias((*about_z_path, "rpy", 2), (*written, "theta"))
    about_x_path: Path_ = (*path, "origin", 0)
    if standard:
        frame = ("frames", row["child"])
        document.add(frame, {"link": row["child"], **about_x}, written)
        about_x_path = frame
    document.alias((*about_x_path, "xyz", 0), (*written, "a"))
    document.alias((*about_x_path, "rpy", 0), (*written, "alpha"))
