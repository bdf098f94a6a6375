"""Legs: joints in a row from one link, each on a link of its own, and the closure that ties the end to another link."""

from __future__ import annotations

from typing import Any

from ..document import Document, Path_


def expand_legs(document: Document) -> None:
    """Add links, joints and the closure of every leg."""
    for name, leg in document.data.get("legs", {}).items():
        path: Path_ = ("legs", name)
        parent = leg.get("on", document.data.get("base", "base"))
        for k, entry in enumerate(leg["joints"]):
            child = entry.get("link", f"{name}_{k + 1}")
            _add_joint(document, entry, parent, child, (*path, "joints", k))
            if k == 0:
                document.alias(("joints", entry["name"], "parent"), (*path, "on"))
            parent = child
        _add_closure(document, name, leg, parent)


def _add_joint(
    document: Document, entry: dict[str, Any], parent: str, child: str, written: Path_
) -> None:
    body = ("links", child)
    document.add(body, entry.get("body", {}), written)
    for key in entry.get("body", {}):
        document.alias((*body, key), (*written, "body", key))
    joint = {key: value for key, value in entry.items() if key not in ("name", "link", "body")}
    document.add(("joints", entry["name"]), {**joint, "parent": parent, "child": child}, written)


def _add_closure(document: Document, name: str, leg: dict[str, Any], last: str) -> None:
    path: Path_ = ("legs", name)
    closure: dict[str, Any] = {
        "kind": leg.get("kind", "point"),
        "between": {last: leg.get("end", {}), **leg["to"]},
    }
    if "assembly" in leg:
        closure["assembly"] = leg["assembly"]
    document.add(("closures", name), closure, path)
    for link in leg["to"]:
        document.alias(("closures", name, "between", link), (*path, "to", link))
    document.alias(("closures", name, "between", last), (*path, "end"))
