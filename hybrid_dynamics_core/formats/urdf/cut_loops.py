"""The comment at the top of a URDF that this library wrote: where its loops are."""

from __future__ import annotations

import re

from ..extras_reader import TAG
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader

NONE = "none"
BESIDE = "The tree of a robot; its loops are in the robot.yaml beside it."
_COMMENT = re.compile(r"Loops that are cut: (.*?)\. Not in this file: ")


def comment_of(cut: str, omitted: str) -> str:
    """The comment at the top of a plain URDF.

    Args:
        cut: names of the loops, with commas, or `NONE`.
        omitted: what else URDF has no words for.
    """
    return f"Loops that are cut: {cut}. Not in this file: {omitted}."


def is_ours(root: LocatedElement) -> bool:
    """Whether this library wrote a URDF or URDF+."""
    if root.first(TAG) is not None or root.comment == BESIDE:
        return True
    return _COMMENT.match(root.comment) is not None


def note_cut_loops(xml: XmlReader) -> None:
    """Say which loops are not in the file, where its comment names some."""
    match = _COMMENT.match(xml.root.comment)
    if match is None or match[1] == NONE or xml.document.section("closures"):
        return
    xml.note(
        xml.root,
        f"loops were cut when this file was written: {match[1]}. What is read is the tree alone, in"
        " which their joints are free; the format urdf+ keeps loops",
    )
