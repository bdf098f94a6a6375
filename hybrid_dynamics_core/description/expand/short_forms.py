"""Short forms of a description: each becomes links, joints, frames and closures of the document."""

from __future__ import annotations

from ..document import Document
from .dh_chain import expand_chain
from .legs import expand_legs
from .modules import expand_modules
from .multi_dof import expand_multi_dof


def expand_short_forms(document: Document) -> None:
    """Replace all short forms of a document, in place."""
    expand_chain(document)
    expand_modules(document)
    expand_legs(document)
    _expand_loops(document)
    expand_multi_dof(document)


def _expand_loops(document: Document) -> None:
    """Add the cut pin of every loop of Type A to D as a planar closure."""
    for name, entry in document.entries("loops").items():
        closure = {"kind": "planar", "between": entry["pin"]}
        if "assembly" in entry:
            closure["assembly"] = entry["assembly"]
        document.add(("closures", name), closure, ("loops", name))
        document.alias(("closures", name, "between"), ("loops", name, "pin"))
