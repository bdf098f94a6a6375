"""Reader of extras: data that a format cannot express, as entries of a description file.

`extras_writer` writes them.
"""

from __future__ import annotations

from ..description.checks.schema import check_schema
from ..description.document import Data, Document, FilePath
from ..description.followers import multipliers_of
from ..description.located_yaml import read_yaml
from ..ground.suggestions import suggestion

TAG = "hybrid_dynamics"  # of the element, text or key that holds the entries
EXTRAS_DEFINITION = "rest"  # name of their schema

_CHECKED_SECTIONS = {  # section of extras: section of the document with their names
    "joints": "joints",
    "closures": "closures",
    "loops": "closures",
    "zero": "joints",
}


def read_extras(document: Document, text: str, file: FilePath, line: int) -> None:
    """Merge extras, written as a text in a file, into a document.

    Args:
        document: document from the format.
        text: the extras, as YAML.
        file: the file of the text.
        line: first line of the text in the file.

    Raises:
        DescriptionError: an entry is wrong, or refers to an unknown name.
    """
    extras = read_yaml("\n" * (line - 1) + text, file)
    check_schema(extras, EXTRAS_DEFINITION)
    apply_extras(document, extras)


def apply_extras(document: Document, extras: Document) -> None:
    """Merge checked extras into a document.

    Raises:
        DescriptionError: they refer to an unknown name.
    """
    _rename_base(document, extras.data.pop("base", ""))
    _check_names(document, extras)
    closures = document.section("closures")
    for entry in extras.entries("closures").values():
        closures.pop(entry.pop("second", ""), None)
    for name in extras.entries("payloads"):
        _remove_payload_body(document, name)
    for name, entry in extras.entries("links").items():
        replaced = document.section("links").pop(name, None) or {}
        if "visuals" in replaced:
            entry.setdefault("visuals", replaced["visuals"])
    if "reference" in extras.data:  # replaces the drawn configuration
        document.data["reference"] = {}
    _shift_coordinates(document, extras.data.pop("zero", {}))
    document.merge(extras)
    for name in extras.entries("loops"):
        _turn_into_loop(document, name)


def payload_body(payload: str) -> str:
    """Name of the link that represents a payload in other formats."""
    return f"{payload}_payload"


def _rename_base(document: Document, name: str) -> None:
    old_name = document.data.get("base", "base")
    if not name or name == old_name:
        return
    document.data["base"] = name
    _rename_link(document, old_name, name)
    for joint in document.section("joints").values():
        if joint["parent"] == old_name:
            joint["parent"] = name
    for frame in document.section("frames").values():
        if frame["link"] == old_name:
            frame["link"] = name
    for closure in document.section("closures").values():
        between: Data = {}
        for link, end in closure["between"].items():
            new_link = name if link == old_name else link
            between[new_link] = end
        closure["between"] = between


def _rename_link(document: Document, old_name: str, name: str) -> None:
    """Give the entry of a link another name, if it has one."""
    links = document.section("links")
    if old_name in links:
        links[name] = links.pop(old_name)
        document.alias(("links", name), ("links", old_name))


def _check_names(document: Document, extras: Document) -> None:
    for section, document_section in _CHECKED_SECTIONS.items():
        names = document.section(document_section)
        kind = document_section.removesuffix("s")
        for name in extras.entries(section):
            if name not in names:
                hint = suggestion(name, names)
                raise extras.error(
                    (section, name), f"there is no {kind} '{name}'{hint} in the file"
                )


def _remove_payload_body(document: Document, payload: str) -> None:
    """Remove the link that represents a payload in a format without payloads."""
    body = payload_body(payload)
    document.section("links").pop(body, None)
    document.section("joints").pop(f"{body}_fixed", None)


def _shift_coordinates(document: Document, zero: dict[str, float]) -> None:
    """Shift coordinates from the format's zero, its drawn configuration, to the robot's zero.

    Args:
        document: document from the format.
        zero: the robot's coordinates in the drawn configuration, by joint [rad or m].
    """
    joints = document.section("joints")
    for name, value in zero.items():
        joint = joints[name]
        joint["offset"] = -value
        if "limits" in joint:
            joint["limits"] = [limit + value for limit in joint["limits"]]
        if "spring" in joint:
            spring = joint["spring"]
            spring["rest"] = spring.get("rest", 0.0) + value
    for name, joint in joints.items():
        if "mimic" not in joint:
            continue
        mimic = joint["mimic"]
        mimic["offset"] += zero.get(name, 0.0)
        for source, multiplier in multipliers_of(mimic).items():
            mimic["offset"] -= float(multiplier) * zero.get(source, 0.0)


def _turn_into_loop(document: Document, name: str) -> None:
    """Turn a planar closure into a loop of Type A to D."""
    closure = document.section("closures").pop(name)
    loop = document.section("loops")[name]
    pin: Data = {}
    for link, end in closure["between"].items():
        pin[link] = end["xyz"] if isinstance(end, dict) else end
    loop["pin"] = pin
    if "assembly" in closure:
        loop["assembly"] = closure["assembly"]
