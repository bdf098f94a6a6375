"""The node's parameters from a parameter file, without ROS."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from hybrid_dynamics_core.ground.file_kinds import FileKind, classify_path

from ..parameters import SENSOR, TABLE, NodeSettings, ParameterError, checked, sensor_rows
from .errors import BagError, wrong_kind

_NAME = "hybrid_dynamics"  # of the node whose topics a processed bag has


def read_settings(path: Path | None) -> NodeSettings:
    """NodeSettings of a file as `ros2 run ... --params-file` takes it; defaults without one.

    Raises:
        BagCallError: it is a file of another kind.
        BagError: it cannot be read as one, or is for another node.
        ParameterError: a parameter is unknown, or has a value that cannot be used.
    """
    if path is None:
        return NodeSettings()
    sections = _sections(path)
    given: dict[str, Any] = {}
    for name in [name for name in sections if _is_for_the_node(name)] or (
        list(sections) if len(sections) == 1 else []
    ):
        given |= sections[name]  # as ROS does: a later section wins
    if sections and not given and not any(map(_is_for_the_node, sections)):
        told = ", ".join(map(str, sections))
        raise BagError(
            f"{path}: no section is for a node named {_NAME}; there are {told}; call one '{_NAME}'"
            " or '/**'"
        )
    rows = {row.name: row for row in TABLE}
    values = {}
    for name, value in given.items():
        if name.startswith(f"{SENSOR}.") and name.count(".") == 2:
            rows |= {row.name: row for row in sensor_rows(name.split(".")[1])}
        if name not in rows:
            raise ParameterError(f"{path}: there is no parameter {name}")
        values[name] = checked(rows[name], value)
    return NodeSettings(values)


def _sections(path: Path) -> dict[Any, dict[str, Any]]:
    """The parameters of each section."""
    if classify_path(path).kind not in (FileKind.SETTINGS, FileKind.TEXT):
        raise wrong_kind(path, "a parameter file of the node ('/**:' above 'ros__parameters:')")
    try:
        tree = yaml.safe_load(path.read_text(encoding="utf-8"))
        return {name: dict(_flat(section["ros__parameters"])) for name, section in tree.items()}
    except (OSError, ValueError, yaml.YAMLError, AttributeError, KeyError, TypeError) as error:
        raise BagError(
            f"{path}: expected a parameter file, '/**:' above 'ros__parameters:' ({error})"
        ) from error


def require_known_sensors(settings: NodeSettings, measured: Sequence[str]) -> None:
    """Refuse what is said of sensors that there are not.

    Raises:
        ParameterError: a joint of the sensors is not measured.
    """
    for joint in settings.sensors:
        if joint not in measured:
            told = ", ".join(measured)
            raise ParameterError(
                f"{SENSOR}.{joint}: '{joint}' is not measured; measured are {told}"
            )


def _is_for_the_node(section: object) -> bool:
    last = str(section).rsplit("/", 1)[-1]
    return last in (_NAME, "*", "**")


def _flat(tree: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in tree.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value
