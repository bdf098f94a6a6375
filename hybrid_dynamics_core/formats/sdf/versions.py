"""Conversion of older versions of SDFormat to 1.7.

Before 1.5 an axis is in the model frame; in 1.5 and 1.6 if `use_parent_model_frame` is set. From
1.7 on an axis is in the joint frame, or names its frame. All else is the same.
"""

from __future__ import annotations

import re

from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader

Version = tuple[int, int]

MODEL = "__model__"  # name of the model frame in a model
NAMED_FRAMES: Version = (1, 7)  # since then a pose or an axis can name its frame
ROOTS = ("sdf", "gazebo")  # the second one before 1.3
_JOINT_AXES: Version = (1, 5)  # since then an axis is in the joint frame
_OLDEST: Version = (1, 2)
CONVERT = "'gz sdf -p FILE' prints a file in the newest version"
YES = ("true", "1")
_AXES = ("axis", "axis2")
_OLDER_WORD = "use_parent_model_frame"


def read_version(xml: XmlReader, root: LocatedElement) -> Version:
    """The version of a file, which decides the frame of its axes.

    Raises:
        DescriptionError: the version is older than 1.2, or invalid.
    """
    version = root.get("version")
    match = re.fullmatch(r"\s*(\d+)\.(\d+)(\.\d+)?\s*", version)
    if match is None or (int(match[1]), int(match[2])) < _OLDEST:
        problem = f"is '{version}'; expected 1.2 or later; {CONVERT}"
        raise xml.error(root, ("version",), problem)
    return int(match[1]), int(match[2])


def upgrade(element: LocatedElement, version: Version) -> None:
    """Add the attribute `expressed_in` to axes of an older version.

    In a newer one, drop the older word where it repeats the attribute.

    Args:
        element: a model or a world; changed in place.
        version: version of its file.
    """
    for child in element.children:
        if child.tag == "model":
            upgrade(child, version)
        if child.tag == "joint":
            for axis in child.children:
                if axis.tag in _AXES:
                    _upgrade_axis(axis, version)


def _upgrade_axis(axis: LocatedElement, version: Version) -> None:
    if version >= NAMED_FRAMES:
        _drop_repeated_frame(axis)
    elif _is_in_model(axis, version):
        _express_in_model(axis)


def _drop_repeated_frame(axis: LocatedElement) -> None:
    """Drop the older word for the model frame where the newer attribute gives the same frame."""
    xyz = axis.first("xyz")
    if _says_model(axis) and xyz is not None and xyz.get("expressed_in") == MODEL:
        axis.children = [child for child in axis.children if child.tag != _OLDER_WORD]


def _is_in_model(axis: LocatedElement, version: Version) -> bool:
    if version < _JOINT_AXES:
        return True
    return _says_model(axis)


def _says_model(axis: LocatedElement) -> bool:
    word = axis.first(_OLDER_WORD)
    return word is not None and word.text.strip() in YES


def _express_in_model(axis: LocatedElement) -> None:
    xyz = axis.first("xyz")
    if xyz is None:
        xyz = LocatedElement("xyz", {}, axis.line, text="0 0 1", file=axis.file)
        axis.children.append(xyz)
    xyz.attributes["expressed_in"] = MODEL
