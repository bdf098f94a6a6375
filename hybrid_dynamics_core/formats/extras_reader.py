"""What a file of another format says beyond that format, in entries of a description file (`export.rest` writes it)."""

from __future__ import annotations

from typing import Any

from ..description.checks.schema import check_schema
from ..description.document import Document, FilePath
from ..description.located_yaml import read_yaml
from ..ground.suggestions import suggestion

TAG = "hybrid_dynamics"  # of the element, text or key that holds the entries


def extend(document: Document, text: str, file: FilePath, line: int) -> None:
    """Join the entries written in a text that begins at a line of a file with those that the format gave.

    DescriptionError where they are not entries of this kind, or name what the format did not give.
    """
    inner = read_yaml("\n" * (line - 1) + text, file)
    check_schema(inner, "rest")
    apply_rest(document, inner)


def apply_rest(document: Document, inner: Document) -> None:
    """The same for entries that are read and checked."""
    _rename_base(document, inner.data.pop("base", ""))
    _check_names(document, inner)
    closures = document.section("closures")
    for entry in inner.data.get("closures", {}).values():
        closures.pop(entry.pop("second", ""), None)
    for name in inner.data.get(
        "payloads", {}
    ):  # bodies of their own where the format has no payloads
        document.section("links").pop(payload_body(name), None)
        document.section("joints").pop(f"{payload_body(name)}_fixed", None)
    for name in inner.data.get("links", {}):
        document.section("links").pop(name, None)
    if "reference" in inner.data:  # in place of what the format draws
        document.data["reference"] = {}
    _count_from(document, inner.data.pop("zero", {}))
    document.merge(inner)
    for name in inner.data.get("loops", {}):
        _as_loop(document, name)


def payload_body(name: str) -> str:
    """The link that stands for a payload in other formats."""
    return f"{name}_payload"


def _rename_base(document: Document, name: str) -> None:
    old = document.data.get("base", "base")
    if not name or name == old:
        return
    document.data["base"] = name
    for joint in document.section("joints").values():
        joint["parent"] = name if joint["parent"] == old else joint["parent"]
    for frame in document.section("frames").values():
        frame["link"] = name if frame["link"] == old else frame["link"]
    for closure in document.section("closures").values():
        closure["between"] = {
            name if link == old else link: place for link, place in closure["between"].items()
        }


def _check_names(document: Document, inner: Document) -> None:
    for section, known_in in (
        ("joints", "joints"),
        ("closures", "closures"),
        ("loops", "closures"),
        ("zero", "joints"),
    ):
        known = document.section(known_in)
        for name in inner.data.get(section, {}):
            if name not in known:
                problem = (
                    f"there is no {known_in[:-1]} '{name}'{suggestion(name, known)} in the file"
                )
                raise inner.error((section, name), problem)


def _count_from(document: Document, zero: dict[str, Any]) -> None:
    """Coordinates that the format counts from the pose it draws, counted as the robot does."""
    joints = document.section("joints")
    for name, value in zero.items():
        joint = joints[name]
        joint["offset"] = -value
        if "limits" in joint:
            joint["limits"] = [limit + value for limit in joint["limits"]]
        if "spring" in joint:
            joint["spring"]["rest"] = joint["spring"].get("rest", 0.0) + value
    for name, joint in joints.items():
        mimic = joint.get("mimic")
        if mimic and (name in zero or mimic["joint"] in zero):
            mimic["offset"] += zero.get(name, 0.0) - mimic["multiplier"] * zero.get(
                mimic["joint"], 0.0
            )


def _as_loop(document: Document, name: str) -> None:
    """A planar closure that is a loop of Type A to D: the same pin under `loops`."""
    closure, loop = document.section("closures").pop(name), document.section("loops")[name]
    loop["pin"] = {
        link: place["xyz"] if isinstance(place, dict) else place
        for link, place in closure["between"].items()
    }
    if "assembly" in closure:
        loop["assembly"] = closure["assembly"]
