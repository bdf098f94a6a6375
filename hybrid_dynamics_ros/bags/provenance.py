"""Provenance of bags in their metadata: the robot, and the processing."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from hybrid_dynamics_core import Robot, load, shipped_robots
from hybrid_dynamics_core.errors import HybridDynamicsError
from hybrid_dynamics_core.ground.file_options import options_of

from .errors import BagCallError
from .storage.bag_reader import require_recording
from .storage.metadata import read_notes

# Keys of a bag's custom data:
_NAME: Final = "robot"
_FILE: Final = "robot_file"  # absolute path, for robots that are not shipped
_DIGEST: Final = "robot_digest"  # SHA-256 of all its files, together with _FILE
_READ_WITH: Final = "robot_read_with"  # parameters and arguments of its file, if given
_SMOOTHING: Final = "smooth"  # of processed bags only
_SOURCE: Final = "source"  # name of the original bag


def robot_notes(given: str, robot: Robot) -> dict[str, str]:
    """The custom data from which `robot_of` loads the robot of a bag.

    Args:
        given: name or path that the robot was loaded from.
        robot: the robot.

    Returns:
        Its name; for a robot that is not shipped also the absolute path of its file, and a digest
        of all its files; and the options of the file, if any were given.
    """
    notes = _read_with_notes(given)
    if given in shipped_robots():
        return {_NAME: str(given), **notes}
    file = str(Path(given).resolve())
    return {_NAME: robot.name, _FILE: file, _DIGEST: _digest(robot), **notes}


def _read_with_notes(given: str) -> dict[str, str]:
    """The options of a robot's file, as JSON; empty if there are none."""
    options = options_of(given)
    if not options:
        return {}
    folders = [str(Path(folder).resolve()) for folder in options.search_path]
    entries = {
        "parameters": dict(options.parameters),
        "xacro_args": dict(options.xacro_args),
        "search_path": folders,
        "model": options.model,
    }
    return {_READ_WITH: json.dumps(entries)}


def _loaded(name: str, notes: Mapping[str, Any]) -> Robot:
    """The robot of a name or file, read with the options in the notes."""
    entries = json.loads(str(notes.get(_READ_WITH, "{}")))
    return load(name, **entries)


def process_notes(source: Path, smoothing: str) -> dict[str, str]:
    """The custom data on how a bag was processed.

    Args:
        source: the original bag.
        smoothing: estimator of accelerations, one of `job.SMOOTHINGS`.
    """
    return {_SOURCE: source.name, _SMOOTHING: smoothing}


def robot_of(bag: Path) -> Robot:
    """The robot of a bag, from its metadata.

    Args:
        bag: a recording or a processed bag.

    Raises:
        BagCallError: the bag names no robot, or the robot's file is missing or has changed.
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
    return _loaded(str(name), notes)


def smoothing_of(bag: Path) -> str | None:
    """The estimator of accelerations of a processed bag; None for a recording."""
    smoothing = read_notes(bag).get(_SMOOTHING)
    if smoothing is None:
        return None
    return str(smoothing)


def _robot_of_file(bag: Path, notes: Mapping[str, Any]) -> Robot:
    """The robot of the file named in the notes.

    Raises:
        BagCallError: the file cannot be read, or has changed since the bag was made.
    """
    file = str(notes[_FILE])
    try:
        robot = _loaded(file, notes)
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
    """SHA-256 of the contents of all files of a robot, independent of their names.

    The digests of the files are sorted before they are joined, so their order does not matter.
    """
    description = robot.description
    files: set[Path] = set()
    for name in (description.file, *description.files.values()):
        if name is not None:  # parts without a file have no name
            files.add(Path(name))
    digests = sorted(hashlib.sha256(file.read_bytes()).digest() for file in files)
    return hashlib.sha256(b"".join(digests)).hexdigest()
