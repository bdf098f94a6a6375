"""What older versions of SDFormat say otherwise, written in the words of 1.7.

Before 1.5 an axis is in the frame of the model; in 1.5 and 1.6 `use_parent_model_frame` says so.
From 1.7 on an axis is in the frame of its joint, or names its frame. All else is the same.
"""

from __future__ import annotations

import re

from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader

Version = tuple[int, int]

MODEL = "__model__"  # the frame of a model, in it
NAMED_FRAMES: Version = (1, 7)  # from then on a pose or an axis can name its frame
_JOINT_AXES: Version = (1, 5)  # from then on an axis is in the frame of its joint
_OLDEST: Version = (1, 3)
CONVERT = "'gz sdf -p FILE' prints a file in the newest version"
_YES = ("true", "1")
_AXES = ("axis", "axis2")
_OLDER_WORD = "use_parent_model_frame"


def read_version(xml: XmlReader, root: LocatedElement) -> Version:
    """The version of a file, which says in what frame its axes are.

    Raises:
        DescriptionError: its version is older than 1.3, or none.
    """
    version = root.get("version")
    match = re.fullmatch(r"\s*(\d+)\.(\d+)(\.\d+)?\s*", version)
    if match is None or (int(match[1]), int(match[2])) < _OLDEST:
        problem = f"is '{version}'; expected 1.3 or later; {CONVERT}"
        raise xml.error(root, ("version",), problem)
    return int(match[1]), int(match[2])


def upgrade(element: LocatedElement, version: Version) -> None:
    """Give axes of an older version the frame that they are in, as 1.7 writes it.

    Args:
        element: a model or a world; what is in it is changed.
        version: of its file.
    """
    if version >= NAMED_FRAMES:
        return
    for child in element.children:
        if child.tag == "model":
            upgrade(child, version)
        if child.tag == "joint":
            for axis in child.children:
                if axis.tag in _AXES and _is_in_model(axis, version):
                    _express_in_model(axis)


def _is_in_model(axis: LocatedElement, version: Version) -> bool:
    if version < _JOINT_AXES:
        return True
    word = axis.first(_OLDER_WORD)
    return word is not None and word.text.strip() in _YES


def _express_in_model(axis: LocatedElement) -> None:
    xyz = axis.first("xyz")
    if xyz is None:
        xyz = LocatedElement("xyz", {}, axis.line, text="0 0 1", file=axis.file)
        axis.children.append(xyz)
    xyz.attributes["expressed_in"] = MODEL
