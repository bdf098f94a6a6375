"""A robot as the pair that Gepetto's loader for Pinocchio reads: a robot.yaml with closed_loop pairs, and its URDF.

The URDF is the spanning tree with a link without mass at either end of every closure. A pair of
type 3d ties two origins, one of 6d two frames; an axis is two pairs of type 3d along it, of whose
six equations five are independent.
"""

from __future__ import annotations

from typing import Any, NamedTuple
from xml.etree.ElementTree import Comment

import numpy as np

from ...description.model import Closure, Frame, RobotDescription
from .. import shapes
from ..extras_reader import TAG
from ..extras_writer import as_text, in_words, rest_of
from ..urdf.writer import CARRIED, add_frame, as_xml, tree_element

ARM = 0.5  # between the two points that tie an axis, over the size of the robot
TYPES = {"planar": "3d", "point": "3d", "axis": "3d", "frame": "6d"}


class Pair(NamedTuple):
    """The texts of the two files."""

    yaml: str
    urdf: str


def to_gepetto(robot: RobotDescription) -> Pair:
    """robot.yaml and robot.urdf of a robot; the two belong beside each other, with one stem.

    What the pair has no words for stands under a key of its own, which Gepetto's loader passes
    over.
    """
    root = tree_element(robot)
    taken = {element.get("name", "") for element in root.findall("link")}
    marks = [mark for link in (robot.base, *robot.links) for mark in shapes.marks(robot, link)]
    arm = ARM * max((float(np.linalg.norm(mark)) for mark in marks), default=1.0)
    pairs: list[list[str]] = []
    names: list[str] = []
    types: list[str] = []
    rest = rest_of(robot, CARRIED)
    for closure in robot.closures:
        for suffix, shift in (
            (("", 0.0), ("_axis", arm)) if closure.kind == "axis" else (("", 0.0),)
        ):
            ends = [_free(f"{closure.name}{suffix}_{end}", taken) for end in "AB"]
            for name, frame in zip(ends, _frames(closure, shift), strict=True):
                add_frame(root, name, frame)
            pairs.append(ends)
            types.append(TYPES[closure.kind])
            names.append(f"{closure.name}{suffix}")
        if closure.kind == "axis":
            rest["closures"][closure.name]["second"] = f"{closure.name}_axis"
    told: dict[str, Any] = {"closed_loop": pairs, "type": types, "name_mot": list(robot.active)}
    told |= {"joint_name": [], "joint_type": [], TAG: {"pairs": names, **rest}}
    root.insert(0, Comment(" The tree of a robot; its loops are in the robot.yaml beside it. "))
    head = (
        f"# {robot.name}: pairs of frames that close the loops of the URDF beside this file, and"
        " the motors.\n"
    )
    more = f"# {TAG}: what pairs have no words for: {in_words(rest)}.\n"
    return Pair(f"{head}{more}{as_text(told)}\n", as_xml(root))


def _frames(closure: Closure, shift: float) -> tuple[Frame, Frame]:
    ends = (
        (closure.link_a, closure.rotation_a, closure.point_a),
        (closure.link_b, closure.rotation_b, closure.point_b),
    )
    one, other = (
        Frame(link, rotation, point + shift * rotation[:, 2]) for link, rotation, point in ends
    )
    return one, other


def _free(name: str, taken: set[str]) -> str:
    while name in taken:
        name += "_"
    taken.add(name)
    return name
