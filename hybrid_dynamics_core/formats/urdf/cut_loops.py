"""The comment on cut loops in a plain URDF that this library wrote."""

from __future__ import annotations

import re

from ..xml.reader import XmlReader

NONE = "none"
_COMMENT = re.compile(r"Loops that are cut: (.*?)\. Not in this file: ")


def comment_of(cut: str, omitted: str) -> str:
    """The comment at the top of a plain URDF.

    Args:
        cut: names of the loops, separated by commas, or `NONE`.
        omitted: other properties that URDF cannot express.
    """
    return f"Loops that are cut: {cut}. Not in this file: {omitted}."


def note_cut_loops(xml: XmlReader) -> None:
    """Add a note on loops that are not in the file, if its comment names any."""
    match = _COMMENT.match(xml.root.comment)
    if match is None or match[1] == NONE or xml.document.section("closures"):
        return
    xml.note(
        xml.root,
        f"loops were cut when this file was written: {match[1]}. What is read is the tree alone, in"
        " which their joints are free; the format urdf+ keeps loops",
    )
