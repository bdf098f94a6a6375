"""A description file becomes a RobotDescription, or one clear DescriptionError."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..description.build import build_description
from ..description.checks.loop_types import check_loop_names, check_loop_types
from ..description.checks.names import check_names
from ..description.checks.schema import check_schema
from ..description.checks.values import check_values
from ..description.defaults import driven_joints, farthest_link
from ..description.document import Document
from ..description.expand.short_forms import expand_short_forms
from ..description.files import read_text
from ..description.located_yaml import read_yaml
from ..description.model import RobotDescription
from ..ground.file_kinds import require_description
from .gepetto.reader import gepetto_document, is_gepetto
from .mjcf.reader import mjcf_document
from .sdf.reader import sdf_document
from .urdf.reader import expand_urdf
from .xml.tree import parse_xml


def read_description(path: str | Path) -> RobotDescription:
    """Read, check and expand a description file; its content tells which kind it is.

    YAML of format 1, a robot.yaml beside its URDF, URDF and URDF+, SDFormat, MJCF as this library
    writes it. Raises DescriptionError with file, line, key, what was expected and how to mend it;
    NoDescriptionError, which is one, where there is nothing, or a file of another kind.
    """
    require_description(Path(path))
    text = read_text(Path(path))
    if not text.removeprefix("\ufeff").lstrip().startswith("<"):
        return parse_description(text, file=path)
    root = parse_xml(text, Path(path))
    if root.tag == "sdf":
        return describe(sdf_document(root, Path(path)))
    if root.tag == "mujoco":
        return describe(mjcf_document(root, Path(path)))
    return read_urdf(path)


def parse_description(text: str, file: str | Path | None = None) -> RobotDescription:
    """The same from text; `file` is named in messages."""
    document = read_yaml(text, file)
    if is_gepetto(document.data):
        return describe(gepetto_document(document))
    check_schema(document)
    return describe(document)


def read_urdf(
    path: str | Path,
    closures: Mapping[str, Any] | None = None,
    active: Sequence[str] = (),
    end_effector: str | Mapping[str, Any] | None = None,
    **entries: Any,
) -> RobotDescription:
    """A robot from a URDF file, its loops and its driven joints, all as plain data of a description file.

    `closures`: {name: {kind, between: {link: place, link: place}}}; `active`: may be left out where
    there are none, or where a URDF+ has them; `end_effector`: a link or {link, xyz, rpy}, the link
    behind the most joints if None; `entries`: anything else a description file may hold, such as
    `reference` or `frames`. Raises DescriptionError.
    """
    path = Path(path)
    require_description(path)
    data = {
        "format": 1,
        "name": "robot",
        "urdf": path.name,
        "closures": dict(closures or {}),
        **entries,
    }
    data["active"] = list(active) or ["all"]
    told = {"link": end_effector} if isinstance(end_effector, str) else end_effector
    data["end_effector"] = {"link": "farthest"} if told is None else dict(told)
    document = Document(data, path, {})
    check_schema(document)
    data["name"] = expand_urdf(document, alone=True)
    data.update(entries)
    if active:
        data["active"] = list(active)
    elif closures:
        raise document.error(("active",), "with closures, name the driven joints")
    elif data["active"] == ["all"]:
        data["active"] = driven_joints(document)
    if told is not None:
        data["end_effector"] = dict(told)
    elif data["end_effector"] == {"link": "farthest"}:
        data["end_effector"] = {"link": farthest_link(document)}
    return describe(document)


def describe(document: Document) -> RobotDescription:
    """Expand, check and build a document that fits the schema."""
    expand_urdf(document)
    expand_short_forms(document)
    check_names(document)
    check_loop_names(document)
    description = build_description(document)
    check_values(document, description)
    check_loop_types(document, description)
    return description
