"""The robot that a bag was made with: noted in its metadata, and found there again."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from hybrid_dynamics_core import Robot, load, shipped_robots
from hybrid_dynamics_core.errors import HybridDynamicsError

from .errors import BagCallError
from .storage.bag_reader import require_recording
from .storage.metadata import read_notes

_NAME: Final = "robot"
_FILE: Final = "robot_file"  # absolute path, of a robot that is not shipped
_DIGEST: Final = "robot_digest"  # of all files that describe it
_SMOOTHING: Final = "smooth"


def robot_notes(given: str, robot: Robot) -> dict[str, str]:
    """What a bag's metadata say of a robot.

    Args:
        given: the name or path that the robot was loaded by.
        robot: the robot.
    """
    if given in shipped_robots():
        return {_NAME: given}
    file = str(Path(given).resolve())
    return {_NAME: robot.name, _FILE: file, _DIGEST: _digest(robot)}


def robot_of(bag: Path) -> Robot:
    """The robot that a bag was made with.

    Raises:
        BagCallError: the bag does not say, or its file is gone or was changed.
    """
    require_recording(bag)
    notes = read_notes(bag)
    name = notes.get(_NAME)
    if name is None:
        raise BagCallError(f"{bag}: does not tell which robot it is of; name it with --robot")
    if _FILE in notes:
        return _robot_of_file(bag, notes)
    if name not in shipped_robots():
        raise BagCallError(
            f"{bag}: was made with '{name}', which is not a shipped robot, and does not tell"
            " its file; give --robot FILE"
        )
    return load(str(name))


def smoothing_of(bag: Path) -> str | None:
    """How the accelerations of a processed bag were found; None for a recording."""
    smoothing = read_notes(bag).get(_SMOOTHING)
    return None if smoothing is None else str(smoothing)


def _robot_of_file(bag: Path, notes: Mapping[str, Any]) -> Robot:
    file = str(notes[_FILE])
    try:
        robot = load(file)
    except (OSError, HybridDynamicsError) as error:
        raise BagCallError(
            f"{bag}: was made with {file}, which cannot be read ({error}); give --robot FILE"
        ) from error
    if _digest(robot) != notes.get(_DIGEST):
        raise BagCallError(
            f"{bag}: was made with {file}, which has been changed since then; give --robot FILE"
        )
    return robot


def _digest(robot: Robot) -> str:
    """SHA-256 of the contents of all files that describe a robot."""
    description = robot.description
    names = {description.file, *description.files.values()}
    files = {Path(name) for name in names if name is not None}
    contents = sorted(hashlib.sha256(file.read_bytes()).digest() for file in files)
    return hashlib.sha256(b"".join(contents)).hexdigest()
