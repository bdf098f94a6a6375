"""Legs: a chain of joints from one link, and a closure that ties its end to another link."""

from __future__ import annotations

from ..document import Data, Document, KeyPath


def expand_legs(document: Document) -> None:
    """Add links, joints and the closure of every leg; each joint carries a link of its own."""
    for name, leg in document.entries("legs").items():
        path: KeyPath = ("legs", name)
        parent = leg.get("on", document.data.get("base", "base"))
        for k, entry in enumerate(leg["joints"]):
            child = entry.get("link", f"{name}_{k + 1}")
            _add_joint(document, entry, parent, child, (*path, "joints", k))
            if k == 0:
                document.alias(("joints", entry["name"], "parent"), (*path, "on"))
            parent = child
        _add_closure(document, name, leg, parent)


def _add_joint(document: Document, entry: Data, parent: str, child: str, written: KeyPath) -> None:
    joint = dict(entry)
    name = joint.pop("name")
    body = joint.pop("body", {})
    joint.pop("link", None)
    joint["parent"] = parent
    joint["child"] = child
    link_path = ("links", child)
    document.add(link_path, body, written)
    for key in body:
        document.alias((*link_path, key), (*written, "body", key))
    document.add(("joints", name), joint, written)


def _add_closure(document: Document, name: str, leg: Data, last_link: str) -> None:
    leg_path: KeyPath = ("legs", name)
    end = leg.get("end", {})
    closure: Data = {
        "kind": leg.get("kind", "point"),
        "between": {last_link: end, **leg["to"]},
    }
    if "assembly" in leg:
        closure["assembly"] = leg["assembly"]
    closure_path = ("closures", name)
    document.add(closure_path, closure, leg_path)
    for link in leg["to"]:
        document.alias((*closure_path, "between", link), (*leg_path, "to", link))
    document.alias((*closure_path, "between", last_link), (*leg_path, "end"))
