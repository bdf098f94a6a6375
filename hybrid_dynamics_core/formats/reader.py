"""Reading of description files of all formats."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..description.build import build_description
from ..description.checks.circles import check_circles
from ..description.checks.loop_types import check_loop_names, check_loop_types
from ..description.checks.names import check_names
from ..description.checks.schema import check_schema
from ..description.checks.values import check_values
from ..description.defaults import driven_joints, farthest_link
from ..description.document import Document, FilePath
from ..description.expand.short_forms import expand_short_forms
from ..description.files import read_text
from ..description.located_yaml import read_yaml
from ..description.model import RobotDescription
from ..description.parameters.written import Written, carry
from ..errors import InputError
from ..ground.file_kinds import require_description
from ..ground.file_options import NO_OPTIONS, FileOptions
from ..ground.suggestions import suggestion
from .gepetto.reader import gepetto_document, is_gepetto
from .mesh_files import with_mesh_files
from .mjcf.reader import mjcf_document
from .sdf.reader import sdf_document
from .urdf.reader import expand_urdf
from .xacro.expand import expand_xacro, is_xacro_name
from .xml.located_xml import LocatedElement, parse_xml

XmlDocument = Callable[[LocatedElement, Path, FileOptions], Document]

_XML_READERS: dict[str, XmlDocument] = {
    "sdf": sdf_document,
    "gazebo": sdf_document,  # before 1.3
    "mujoco": mjcf_document,
}
_XML_ENDINGS = (".sdf", ".urdf", ".xacro", ".world", ".mjcf", ".xml")
_ALL_DRIVEN = ["all"]  # until the joints are known
_FARTHEST = {"link": "farthest"}


def read_description(path: str | Path, options: FileOptions = NO_OPTIONS) -> RobotDescription:
    """Read, check and expand a description file; its format is recognised by its content.

    Formats: YAML or JSON of format 1, a robot.yaml beside its URDF, URDF and URDF+, SDFormat, MJCF,
        and xacro files of these, whose names end in .xacro.

    Args:
        path: path of the file.
        options: options for reading.

    Raises:
        InputError: it has no parameter or argument of a name in the options.
        DescriptionError: the file is wrong; the error has file, line and key.
        NoDescriptionError: the file is missing, or of another kind; a DescriptionError.
    """
    path = Path(path)
    require_description(path)
    text = read_text(path)
    is_xml = text.removeprefix("\ufeff").lstrip().startswith("<")
    if not is_xml and path.suffix.lower() not in _XML_ENDINGS:
        _refuse_model(options, path)
        return parse_description(text, path, options)
    if options.parameters:
        raise InputError(f"parameters: {path} has none; description files (YAML, JSON) have them")
    root = parse_xml(text, path)
    reader = _XML_READERS.get(root.tag)
    if reader is not sdf_document:
        _refuse_model(options, path)
    is_xacro = is_xacro_name(path)
    if not is_xacro:
        _refuse_xacro_args(options, path)
    if reader is None:  # a URDF, whose reader expands xacro
        return read_urdf(path, options=options)
    if is_xacro:
        return _expanded(path, options, reader)
    return _described(reader(root, path, options))


def parse_description(
    text: str, file: FilePath = None, options: FileOptions = NO_OPTIONS
) -> RobotDescription:
    """Read, check and expand the text of a YAML or JSON description.

    Args:
        text: the description.
        file: named in messages; relative paths start at its folder.
        options: options for reading.

    Raises:
        InputError: it has no parameter or argument of a name in the options.
        DescriptionError: the text is wrong.
    """
    document = read_yaml(_without_tabs(text), file)
    document.options = options
    _set_parameters(document)
    if not _names_xacro(document.data):
        _refuse_xacro_args(options, file)
    if is_gepetto(document.data):
        return _described(gepetto_document(document))
    check_schema(document)
    return _described(document)


def read_urdf(
    path: str | Path,
    closures: Mapping[str, Any] | None = None,
    active: Sequence[str] = (),
    end_effector: str | Mapping[str, Any] | None = None,
    options: FileOptions = NO_OPTIONS,
    **entries: Any,
) -> RobotDescription:
    """Read a URDF file, with closures and driven joints as entries of a description file.

    Args:
        path: path of the URDF.
        closures: {name: {kind, between: {link: place, link: place}}}.
        active: driven joints; by default those of a URDF+, or all joints of a URDF without
            closures.
        end_effector: a link or {link, xyz, rpy}; None for the link behind the most joints.
        options: options for reading.
        entries: further entries of a description file, such as `reference` or `frames`.

    Raises:
        DescriptionError: the file is wrong, or the entries do not fit it.
    """
    path = Path(path)
    require_description(path)
    if isinstance(end_effector, str):
        end_effector = {"link": end_effector}
    data = {
        "format": 1,
        "name": "robot",
        "urdf": path.name,
        "closures": dict(closures or {}),
        **entries,
        "active": list(active or _ALL_DRIVEN),
        "end_effector": dict(_FARTHEST if end_effector is None else end_effector),
    }
    document = Document(data, path, {}, options)
    check_schema(document)
    data["name"] = expand_urdf(document, is_alone=True)
    data.update(entries)  # again: they override those of the URDF
    if active:
        data["active"] = list(active)
    elif closures:
        raise document.error(("active",), "with closures, name the driven joints")
    elif data["active"] == _ALL_DRIVEN:
        data["active"] = driven_joints(document)
    if end_effector is not None:
        data["end_effector"] = dict(end_effector)
    elif data["end_effector"] == _FARTHEST:
        data["end_effector"] = {"link": farthest_link(document)}
    return _described(document)


def _expanded(path: Path, options: FileOptions, reader: XmlDocument) -> RobotDescription:
    """The robot of a xacro file that expands to SDFormat or MJCF."""
    expansion = expand_xacro(path, options)
    document = reader(expansion.root, path, options)
    document.add_files(expansion.files)
    document.notes.extend(expansion.notes)
    return _described(document)


def _names_xacro(data: Any) -> bool:
    """Whether a description refers to a xacro file."""
    entry = data.get("urdf") if isinstance(data, dict) else None
    if isinstance(entry, dict):
        entry = entry.get("file")
    return isinstance(entry, str) and is_xacro_name(Path(entry))


def _set_parameters(document: Document) -> None:
    """Set parameters to the values of the call, with a note for each."""
    existing: object = None
    if isinstance(document.data, dict):
        existing = document.data.get("parameters")
    parameters = existing if isinstance(existing, dict) else {}
    for name, value in document.options.parameters.items():
        if name not in parameters:
            hint = suggestion(name, parameters)
            listed = ", ".join(parameters) or "none"
            raise InputError(
                f"parameters: {document.file} has no parameter '{name}'{hint}; it has: {listed}"
            )
        remark = f"{value}, as given in the call, in place of {parameters[name]}"
        document.note(("parameters", name), remark)
        parameters[name] = value


def _refuse_model(options: FileOptions, file: FilePath) -> None:
    if options.model:
        raise InputError(f"model: {file} has one robot; SDFormat files may have several")


def _refuse_xacro_args(options: FileOptions, file: FilePath) -> None:
    if options.xacro_args:
        raise InputError(f"xacro_args: {file} is no xacro file; their names end in .xacro")


def _without_tabs(text: str) -> str:
    """JSON with tabs between entries replaced by blanks, since YAML does not allow tabs."""
    is_json = text.lstrip("\ufeff \t\r\n").startswith("{")
    return text.replace("\t", " ") if is_json else text


def _described(document: Document) -> RobotDescription:
    """Expand, check and build a document that fits the schema."""
    expand_urdf(document)  # no effect if it is expanded already
    written = Written(document.copy(), described)
    expand_short_forms(document)
    return carry(described(document), written)


def described(document: Document) -> RobotDescription:
    """Check and build an expanded document."""
    check_names(document)
    check_loop_names(document)
    description = build_description(document)
    check_circles(document, description)
    check_values(document, description)
    check_loop_types(document, description)
    return with_mesh_files(document, description)
