"""Which robot a bag was made with: told in its metadata, and found there again."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any, Final

import yaml

from hybrid_dynamics_core import Robot, load, shipped_robots
from hybrid_dynamics_core.errors import HybridDynamicsError
from hybrid_dynamics_core.ground.file_kinds import BAG_METADATA

from .errors import BagCallError
from .storage.bag_reader import require_recording

_NAME: Final = "robot"
_FILE: Final = "robot_file"  # absolute path, of a robot that is not shipped
_DIGEST: Final = "robot_digest"  # of all files that describe it


def robot_notes(given: str, robot: Robot) -> dict[str, str]:
    """What a bag's metadata tells of the robot that was loaded by a name or path."""
    if given in shipped_robots():
        return {_NAME: given}
    return {_NAME: robot.name, _FILE: str(Path(given).resolve()), _DIGEST: _digest(robot)}


def known_robot(bag: Path) -> Robot:
    """The robot that a bag was made with.

    Raises:
        BagCallError: the bag does not tell, or tells of a file that is not there any more or is not
        what it was.
    """
    require_recording(bag)
    notes = _notes(bag)
    name = notes.get(_NAME)
    if name is None:
        raise BagCallError(f"{bag}: does not tell which robot it is of; name it with --robot")
    if _FILE not in notes:
        if name not in shipped_robots():
            raise BagCallError(
                f"{bag}: was made with '{name}', which is not a shipped robot, and does not tell"
                " its file; give --robot FILE"
            )
        return load(str(name))
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


def smoothing_of(bag: Path) -> str | None:
    """How the accelerations of a processed bag were found; None for a recording."""
    told = _notes(bag).get("smooth")
    return None if told is None else str(told)


def _notes(bag: Path) -> dict[str, Any]:
    try:
        told = yaml.safe_load((bag / BAG_METADATA).read_text(encoding="utf-8"))
        return dict(told["rosbag2_bagfile_information"]["custom_data"])
    except (OSError, KeyError, TypeError, ValueError, yaml.YAMLError):
        return {}


def _digest(robot: Robot) -> str:
    """Of the contents of all files that describe a robot."""
    description = robot.description
    files = {
        Path(file) for file in (description.file, *description.files.values()) if file is not None
    }
    contents = sorted(hashlib.sha256(file.read_bytes()).digest() for file in files)
    return hashlib.sha256(b"".join(contents)).hexdigest()
