"""Writer of a robot.yaml with its URDF, as Gepetto's loader for Pinocchio reads them.

The robot.yaml has closed_loop pairs. The URDF is the spanning tree, with a link without mass at
either end of every closure. A pair of type 3d ties two origins, one of 6d two frames. An axis is
two pairs of type 3d along it, with six equations of which five are independent.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element

from ...description.document import Data
from ...description.model import Closure
from ...robot.taken import AnyRobot, description_of
from .. import shapes
from ..extras_reader import TAG
from ..extras_writer import extras_of, extras_summary, extras_text
from ..urdf.writer import FEATURES, add_frame, tree_element
from ..xml.writer import insert_comment, xml_text

_AXIS_ARM = 0.5  # distance of the two points that tie an axis, over the size of the robot
_PAIR_TYPES = {
    "planar": "3d",
    "point": "3d",
    "axis": "3d",
    "frame": "6d",
}
_URDF_COMMENT = "The tree of a robot; its loops are in the robot.yaml beside it."


class Pair(NamedTuple):
    """The texts of the two files."""

    yaml: str
    urdf: str


def to_gepetto(robot: AnyRobot, folder: str | Path | None = None) -> Pair:
    """The texts of robot.yaml and robot.urdf, to be saved in one folder with one stem.

    Data that the pair cannot express are under a key of their own, which Gepetto's loader ignores.

    Args:
        robot: the robot to write, or its description.
        folder: folder of the file. Meshes in it get relative paths, others absolute ones.

    Raises:
        InputError: `robot` is neither.
    """
    description = description_of(robot)
    root = tree_element(description, folder)
    pairs = _Pairs(root, _AXIS_ARM * shapes.robot_size(description))
    extras = extras_of(description, FEATURES)
    for closure in description.closures:
        pairs.add(closure, "", 0.0)
        if closure.kind == "axis":
            pairs.add(closure, "_axis", pairs.arm)
            extras["closures"][closure.name]["second"] = f"{closure.name}_axis"
    entries: Data = {
        "closed_loop": pairs.ends,
        "type": pairs.types,
        "name_mot": list(description.motors),
        "joint_name": [],
        "joint_type": [],
        TAG: {"pairs": pairs.names, **extras},
    }
    insert_comment(root, _URDF_COMMENT)
    comment = (
        f"# {description.name}: pairs of frames that close the loops of the URDF beside this file,"
        f" and the motors.\n# {TAG}: what pairs have no words for: {extras_summary(extras)}.\n"
    )
    return Pair(f"{comment}{extras_text(entries)}\n", xml_text(root))


class _Pairs:
    """Pairs of links without mass at the ends of closures.

    Attributes:
        arm: distance of the two points that tie an axis [m].
        ends: names of the two links of each pair.
        types: 3d or 6d of each pair.
        names: names of the pairs.
    """

    def __init__(self, root: Element, arm: float) -> None:
        self.root = root
        self.arm = arm
        self.ends: list[list[str]] = []
        self.types: list[str] = []
        self.names: list[str] = []
        self._taken_names = {element.get("name", "") for element in root.findall("link")}

    def add(self, closure: Closure, suffix: str, shift: float) -> None:
        """Add the pair of a closure, shifted along z [m]."""
        name = f"{closure.name}{suffix}"
        ends: list[str] = []
        for letter, frame in zip("AB", closure.frames(), strict=True):
            end = self._free_name(f"{name}_{letter}")
            point = frame.translation + shift * frame.rotation[:, 2]
            add_frame(self.root, end, replace(frame, translation=point))
            ends.append(end)
        self.ends.append(ends)
        self.types.append(_PAIR_TYPES[closure.kind])
        self.names.append(name)

    def _free_name(self, name: str) -> str:
        while name in self._taken_names:
            name += "_"
        self._taken_names.add(name)
        return name
