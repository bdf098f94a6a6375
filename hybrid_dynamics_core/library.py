"""The shipped robots, and `load`."""

from __future__ import annotations

import os
from dataclasses import replace
from importlib import resources
from pathlib import Path

from .description.model import RobotDescription
from .errors import DescriptionError, InputError, UndecidedModeError
from .formats.reader import parse_description, read_description
from .ground.suggestions import nearest
from .robot.robot import Robot

_SUFFIXES = (".yaml", ".yml", ".urdf", ".sdf", ".xml", ".mjcf")


def shipped_robots() -> tuple[str, ...]:
    """Names that `load` knows without a path."""
    files = resources.files(__package__).joinpath("robots").iterdir()
    return tuple(sorted(Path(f.name).stem for f in files if f.name.endswith(".yaml")))


def load(robot: str | os.PathLike[str]) -> Robot:
    """A robot from a shipped name such as "forging_chu2020" or from the path of a description file.

    The content of the file tells its format: YAML, URDF(+), robot.yaml beside a URDF, SDFormat,
    MJCF as it is exported. Raises InputError for a name that is neither, DescriptionError for a
    file that is wrong; NoDescriptionError, which is both, for a path at which there is nothing or
    no robot description.
    """
    return Robot(_description(robot))


def load_undecided(robot: str | os.PathLike[str]) -> tuple[Robot, tuple[UndecidedModeError, ...]]:
    """A robot as `load` gives it, and the loops whose assembly mode its file leaves open.

    There the first one is taken in which the loops after it close too.

    For looking at the modes before one is chosen; nothing should be computed with a robot that has
    open loops.
    """
    return _decided(_description(robot))


def _decided(description: RobotDescription) -> tuple[Robot, tuple[UndecidedModeError, ...]]:
    """The robot with the first of the open modes in which the loops after it close too."""
    try:
        return Robot(description), ()
    except UndecidedModeError as error:
        failures = []
        for mode in error.modes:
            try:
                robot, later = _decided(_with_mode(description, error.loop, mode))
            except DescriptionError as failure:
                failures.append(failure)
            else:
                return robot, (error, *later)
        raise failures[0] from error


def _with_mode(description: RobotDescription, loop: str, mode: str) -> RobotDescription:
    closures = (
        replace(one, assembly=mode) if one.name == loop else one for one in description.closures
    )
    return replace(description, closures=tuple(closures))


def _description(robot: str | os.PathLike[str]) -> RobotDescription:
    if not isinstance(robot, (str, os.PathLike)):
        raise InputError(
            f"a robot is named by a text or a path, not by {robot!r} ({type(robot).__name__})"
        )
    name = os.fspath(robot)
    if name in shipped_robots():
        resource = resources.files(__package__).joinpath("robots", f"{name}.yaml")
        return parse_description(resource.read_text(encoding="utf-8"), file=f"{name}.yaml")
    if not Path(name).exists() and Path(name).suffix not in (".yaml", ".yml"):
        known = shipped_robots()
        hint = nearest(name, [*_files_beside(Path(name)), *known])
        raise InputError(
            f"'{name}' is neither a shipped robot nor a file{hint}: {', '.join(known)}"
        )
    return read_description(name)


def _files_beside(path: Path) -> list[str]:
    """Files where a path points that may be robots, each as it would be written."""
    there = path.parent.iterdir() if path.parent.is_dir() else []
    return [str(path.parent / file.name) for file in there if file.suffix in _SUFFIXES]
