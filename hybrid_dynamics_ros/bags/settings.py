"""The node's parameters from a file, and its pipeline, without ROS."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import yaml

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.ground.file_kinds import FileKind, classify_path

from ..parameters import (
    BANDWIDTH,
    MAX_GAP,
    MEASURED,
    PARTIAL_AGE,
    PASS_THROUGH,
    ROS_NAMES,
    SENSOR,
    TABLE,
    NodeSettings,
    ParameterError,
    checked,
    sensor_joint,
    sensor_rows,
)
from ..stream.conditions import (
    Conditions,
    calibration_of,
    kalman_of,
    loads_of,
    poses_of,
)
from ..stream.pipeline import Pipeline
from .errors import BagError, wrong_kind

_NAME: Final = "hybrid_dynamics"  # name of the node in processed bags
_PARAMETERS: Final = "ros__parameters"
_ERRORS: Final = (OSError, ValueError, yaml.YAMLError, AttributeError, KeyError, TypeError)


def read_settings(path: Path | None) -> NodeSettings:
    """Settings from a parameter file of ROS 2; defaults without a file.

    Raises:
        BagCallError: the file is of another kind.
        BagError: the file cannot be read, or is for another node.
        ParameterError: a parameter is unknown, or its value is wrong.
    """
    if path is None:
        return NodeSettings()
    rows = {row.name: row for row in TABLE}
    values = {}
    for name, value in _parameters(path).items():
        if ROS_NAMES.fullmatch(name):
            continue
        if name.startswith(f"{SENSOR}.") and sensor_joint(name):
            rows |= {row.name: row for row in sensor_rows(sensor_joint(name))}
        if name not in rows:
            raise ParameterError(f"{path}: there is no parameter {name}")
        values[name] = checked(rows[name], value)
    return NodeSettings(values)


def require_measured(settings: NodeSettings, measured: Sequence[str]) -> None:
    """Check that settings of sensors refer to measured joints.

    Raises:
        ParameterError: a joint with a sensor setting is not measured.
    """
    for joint in settings.sensors:
        if joint not in measured:
            raise ParameterError(
                f"{SENSOR}.{joint}: '{joint}' is not measured; measured are {', '.join(measured)}"
            )


def make_pipeline(robot: Robot, settings: NodeSettings) -> Pipeline:
    """Make the node's pipeline for given parameters.

    Raises:
        ParameterError: the settings do not fit the robot.
    """
    bandwidth, max_gap = settings[BANDWIDTH], settings[MAX_GAP]
    pipeline = Pipeline(
        robot,
        bandwidth,
        max_gap,
        settings[MEASURED],
        kalman_of(settings),
        poses_of(robot, settings),
    )
    conditions = Conditions().with_settings(settings, None, robot.end_effector)
    pipeline.readings.joiner.max_age = settings[PARTIAL_AGE]
    pipeline.pressures.max_age = settings[PARTIAL_AGE]
    if settings[PASS_THROUGH]:
        pipeline.pass_through(settings[PARTIAL_AGE])
    evaluator = pipeline.evaluator
    evaluator.loads = loads_of(robot, conditions)
    require_measured(settings, evaluator.measured)
    evaluator.calibrate(calibration_of(settings, evaluator.measured))
    return pipeline


def _parameters(path: Path) -> dict[str, Any]:
    """The parameters of the node by dotted names; raises BagError."""
    sections = _sections(path)
    matching = [name for name in sections if _is_for_the_node(name)]
    chosen = matching
    if not matching and len(sections) == 1:
        chosen = list(sections)
    parameters: dict[str, Any] = {}
    for name in chosen:
        parameters |= sections[name]  # as in ROS, a later section wins
    if sections and not parameters and not matching:
        listed = ", ".join(map(str, sections))
        raise BagError(
            f"{path}: no section is for a node named {_NAME}; there are {listed}; call one"
            f" '{_NAME}' or '/**'"
        )
    return parameters


def _sections(path: Path) -> dict[Any, dict[str, Any]]:
    """The parameters of each section."""
    if classify_path(path).kind not in (FileKind.SETTINGS, FileKind.TEXT):
        raise wrong_kind(path, "a parameter file of the node ('/**:' above 'ros__parameters:')")
    try:
        tree = yaml.safe_load(path.read_text(encoding="utf-8"))
        return {name: dict(_flatten(section[_PARAMETERS])) for name, section in tree.items()}
    except _ERRORS as error:
        raise BagError(
            f"{path}: expected a parameter file, '/**:' above 'ros__parameters:' ({error})"
        ) from error


def _is_for_the_node(section: object) -> bool:
    last = str(section).rsplit("/", 1)[-1]
    return last in (_NAME, "*", "**")


def _flatten(tree: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Values by dotted names."""
    for key, value in tree.items():
        if isinstance(value, Mapping):
            yield from _flatten(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value
