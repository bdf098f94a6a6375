"""The comment of a plain URDF that this library wrote: which loops are cut in it."""

from __future__ import annotations

import re

from ..xml.reader import XmlReader

NONE = "none"
_COMMENT = re.compile(r"Loops that are cut: (.*?)\. Not in this file: ")


def comment_of(cut: str, omitted: str) -> str:
    """The comment at the top of a plain URDF.

    Args:
        cut: names of the loops, with commas, or `NONE`.
        omitted: what else URDF has no words for.
    """
    return f"Loops that are cut: {cut}. Not in this file: {omitted}."


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
