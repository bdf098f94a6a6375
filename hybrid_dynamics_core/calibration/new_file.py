"""The description file of a calibrated robot, as the user wrote it where that is possible."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import resources
from pathlib import Path

import numpy as np

from ..description.document import KeyPath
from ..description.model import RobotDescription
from ..errors import HybridDynamicsError
from ..formats.reader import parse_description
from ..formats.yaml.writer import to_yaml
from ..ground.file_options import options_of
from ..library import shipped_robots
from ..robot.model import RobotModel
from .adjustable import OUTSIDE
from .file_text import NotWritableError, with_numbers, without_entry
from .loop_choices import broken_parallelograms, with_general_bars
from .result import Calibration

SAME = 1e-10  # [m, or of unit vectors] difference of two texts of one robot


def new_text(calibration: Calibration, folder: str | Path | None = None) -> str:
    """The text of the new description file.

    Numbers of the robot's file are replaced. Comments at the top say by how much each one changed.
    A robot whose parameters have no place in its file, as those of a URDF or of a joint of a
    template, is written with its links and joints one by one.

    Args:
        calibration: the result.
        folder: folder of the file, for relative paths of meshes.
    """
    text = _edited(calibration)
    header = "".join(f"# {line}\n" for line in changes(calibration))
    if text is None:
        robot = calibration.robot.with_visuals(calibration.free, calibration.values)
        general = with_general_bars(robot, calibration.robot.robot)
        return f"{header}{to_yaml(general, folder)}"
    if text.lstrip("\ufeff \t\r\n").startswith("{"):
        return text  # JSON has no comments
    return f"{header}{text}"


def changes(calibration: Calibration) -> Iterator[str]:
    """A line for each parameter: its value, the one before, and the change."""
    yield f"calibrated: reduced chi-squared {calibration.chi2:.3g}"
    for parameter in calibration.free:
        one = calibration.parameters[parameter.name]
        change = f"changed by {one.change:+.3g} +- {one.half:.2g} {one.unit}".rstrip()
        warning = ""
        if not one.identifiable:
            change = f"changed by {one.change:+.3g} {one.unit}".rstrip()
            warning = "; the measurements do not show it"
        elif parameter.place in OUTSIDE:
            warning = "; it has no place in this file"
        yield f"{parameter.name}: {one.value:.9g}, was {one.start:.9g}, {change}{warning}"
    for loop in _broken(calibration):
        yield f"{loop}: no parallelogram any more; it is closed as a four-bar near the reference"


def _edited(calibration: Calibration) -> str | None:
    """The robot's own text with the numbers replaced; None if that is not the same robot."""
    text = _source(calibration)
    if text is None or any(one.place == "expanded" for one in calibration.free):
        return None
    numbers = calibration.robot.changes(calibration.free, calibration.values)
    document = calibration.robot.written.document
    try:
        edited = with_numbers(text, numbers)
        for loop in _broken(calibration):
            edited = without_entry(edited, (*_section_of(loop, calibration), "assembly"))
        read = parse_description(edited, document.file, document.options)
        RobotModel.from_description(read)
    except (NotWritableError, HybridDynamicsError):
        return None
    return edited if _same_geometry(read, calibration.description) else None


def _broken(calibration: Calibration) -> list[str]:
    """Loops that the file declares parallelograms, and that are none with the estimates."""
    robot = calibration.robot.with_visuals(calibration.free, calibration.values)
    return list(broken_parallelograms(robot))


def _section_of(loop: str, calibration: Calibration) -> KeyPath:
    """The path of a loop or closure in the file."""
    _, after = calibration.robot.written.expanded
    written, _ = after.as_written(("closures", loop))
    return written


def _source(calibration: Calibration) -> str | None:
    """The text of the robot's file; None if it is neither YAML nor JSON."""
    name = calibration.robot.name
    if name in shipped_robots():
        folder = resources.files("hybrid_dynamics_core").joinpath("robots")
        return folder.joinpath(f"{name}.yaml").read_text(encoding="utf-8")
    if options_of(name):
        return None  # values of the call are not in the file
    text = Path(name).read_text(encoding="utf-8")
    return None if text.lstrip("\ufeff \t\r\n").startswith("<") else text


def _same_geometry(one: RobotDescription, other: RobotDescription) -> bool:
    """Whether two descriptions have the same joints, closures and frames."""
    first = np.array(list(_numbers(one)))
    second = np.array(list(_numbers(other)))
    return first.shape == second.shape and bool(np.abs(first - second).max(initial=0.0) < SAME)


def _numbers(robot: RobotDescription) -> Iterator[float]:
    """All numbers of the geometry."""
    for joint in robot.joints.values():
        yield from (*joint.rotation.ravel(), *joint.translation, *joint.axis)
    for closure in robot.closures:
        for frame in closure.frames():
            yield from (*frame.rotation.ravel(), *frame.translation)
    for frame in robot.frames.values():
        yield from (*frame.rotation.ravel(), *frame.translation)
    for mimic in robot.mimics.values():
        yield from (*mimic.multipliers.values(), mimic.offset)
