"""From Denavit-Hartenberg rows to joints, in both conventions.

Standard: T = Rz(theta) Tz(d) Tx(a) Rx(alpha). The joint moves about or along z of the link before.
The constant part after the joint, Tx(a) Rx(alpha), becomes a frame with the link's name, in which
the link's data are given. Modified (Craig): T = Rx(alpha) Tx(a) Rz(theta) Tz(d). The link's frame
stands at its own joint.
"""

from __future__ import annotations

from ..document import Data, Document, KeyPath

_JOINT_KEYS = (  # keys of a row that are keys of a joint too
    "limits",
    "effort_limit",
    "velocity_limit",
    "power_limit",
    "acceleration_limit",
    "effort_table",
    "friction",
    "drive",
    "spring",
)


def expand_chain(document: Document) -> None:
    """Add a joint for every row and, in the standard convention, a frame for its link."""
    chain = document.data.pop("chain", None)
    if chain is None:
        return
    add_row = _add_modified
    if chain["convention"] == "standard":
        add_row = _add_standard
    parent = chain.get("base", document.data.get("base", "base"))
    for k, row in enumerate(chain["rows"]):
        row_path: KeyPath = ("chain", "rows", k)
        parent_path: KeyPath = ("chain", "base")
        if "parent" in row:
            parent = row["parent"]
            parent_path = (*row_path, "parent")
        add_row(document, row, parent, row_path)
        document.alias(("joints", row["joint"], "parent"), parent_path)
        parent = row["child"]


def _add_standard(document: Document, row: Data, parent: str, row_path: KeyPath) -> None:
    about_z, about_x = _poses(row)
    joint_path = ("joints", row["joint"])
    joint = _joint(row, parent, [about_z])
    document.add(joint_path, joint, row_path)
    frame_path = ("frames", row["child"])
    document.add(frame_path, {"link": row["child"], **about_x}, row_path)
    _alias_numbers(document, (*joint_path, "origin", 0), frame_path, row_path)


def _add_modified(document: Document, row: Data, parent: str, row_path: KeyPath) -> None:
    about_z, about_x = _poses(row)
    joint_path = ("joints", row["joint"])
    joint = _joint(row, parent, [about_x, about_z])
    document.add(joint_path, joint, row_path)
    origin_path = (*joint_path, "origin")
    _alias_numbers(document, (*origin_path, 1), (*origin_path, 0), row_path)


def _poses(row: Data) -> tuple[Data, Data]:
    """Rz(theta) Tz(d) and Rx(alpha) Tx(a) as entries."""
    theta = row.get("theta", 0)
    d = row.get("d", 0)
    a = row.get("a", 0)
    alpha = row.get("alpha", 0)
    about_z = {"xyz": [0, 0, d], "rpy": [0, 0, theta]}
    about_x = {"xyz": [a, 0, 0], "rpy": [alpha, 0, 0]}
    return about_z, about_x


def _joint(row: Data, parent: str, origin: list[Data]) -> Data:
    joint: Data = {
        "type": row.get("type", "revolute"),
        "parent": parent,
        "child": row["child"],
        "origin": origin,
        "axis": "z",
    }
    for key in _JOINT_KEYS:
        if key in row:
            joint[key] = row[key]
    return joint


def _alias_numbers(
    document: Document, about_z_path: KeyPath, about_x_path: KeyPath, row_path: KeyPath
) -> None:
    """Let errors in the poses point at the numbers of the row."""
    document.alias((*about_z_path, "xyz", 2), (*row_path, "d"))
    document.alias((*about_z_path, "rpy", 2), (*row_path, "theta"))
    document.alias((*about_x_path, "xyz", 0), (*row_path, "a"))
    document.alias((*about_x_path, "rpy", 0), (*row_path, "alpha"))
