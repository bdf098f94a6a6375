"""The shipped robots, and `load`."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cache
from importlib import resources
from pathlib import Path

from .description.model import RobotDescription
from .errors import DescriptionError, InputError, UndecidedModeError
from .ground.file_options import (
    NO_OPTIONS,
    FileOptions,
    Parameter,
    PathText,
    RobotFile,
    file_options,
    options_of,
)
from .ground.regular_files import answered_in_time
from .ground.suggestions import suggestion
from .robot.robot import Robot

_SUFFIXES = (".yaml", ".yml", ".json", ".urdf", ".sdf", ".xml", ".mjcf", ".xacro")


def shipped_robots() -> tuple[str, ...]:
    """Names of the robots in this package, for `load`."""
    files = resources.files(__package__).joinpath("robots").iterdir()
    names = [Path(file.name).stem for file in files if file.name.endswith(".yaml")]
    return tuple(sorted(names))


def load(
    robot: PathText,
    strict: bool = False,
    *,
    parameters: Mapping[str, Parameter] | None = None,
    xacro_args: Mapping[str, object] | None = None,
    search_path: PathText | Iterable[PathText] = (),
    model: str = "",
) -> Robot:
    """Load a shipped robot, such as "forging_chu2020", or a description file.

    The format is recognised by the content: YAML or JSON, URDF(+), robot.yaml beside a URDF,
    SDFormat, or MJCF. A file whose name ends in .xacro is expanded first.

    Args:
        robot: name of a shipped robot, or path of a file.
        strict: whether impossible inertias are refused. Otherwise each gets a note.
        parameters: values that replace those in `parameters` of a description file: numbers in SI
            units, or expressions.
        xacro_args: arguments of a xacro file.
        search_path: a folder, or several, to search for packages.
        model: name of the model in an SDFormat file of several; the name of the world for all.

    Returns:
        The robot, with its loops analysed.

    Raises:
        InputError: the name is neither a shipped robot nor a file, or a parameter or argument is
            unknown.
        DescriptionError: the file is wrong.
        NoDescriptionError: the path is missing, or no robot description; it is both an InputError
            and a DescriptionError.
    """
    options = file_options(parameters, xacro_args, search_path, model)
    return Robot(_checked_description(_with_options(robot, options), strict))


def load_undecided(
    robot: PathText, strict: bool = False
) -> tuple[Robot, tuple[UndecidedModeError, ...]]:
    """Load a robot, with an error for each loop whose assembly mode is undecided.

    Such a loop takes the first mode in which the loops after it close too. This is for showing the
    modes before one is chosen. Do not compute with a robot that has undecided loops.

    Args:
        robot: name of a shipped robot, or path of a file; a RobotFile has options too.
        strict: as in `load`.

    Returns:
        The robot, and the errors that `load` would raise for its undecided loops.

    Raises:
        InputError, DescriptionError: as in `load`.
    """
    return _first_closing(_checked_description(robot, strict))


def _with_options(robot: PathText, options: FileOptions) -> PathText:
    """The robot's name with the options of a call; by default, with its own options."""
    if not options or not isinstance(robot, (str, os.PathLike)):
        return robot
    return RobotFile(os.fspath(robot), options)


def _checked_description(robot: PathText, strict: bool) -> RobotDescription:
    """The description; `strict` refuses impossible inertias."""
    description = _description(robot)
    if strict:
        for key, problem in description.impossible.items():
            raise description.error(key, f"{problem}; without `strict` it is taken as it stands")
    return description


def _first_closing(
    description: RobotDescription,
) -> tuple[Robot, tuple[UndecidedModeError, ...]]:
    """The robot with the first undecided modes in which all loops close."""
    try:
        return Robot(description), ()
    except UndecidedModeError as error:
        failures = []
        for mode in error.modes:
            decided = _with_mode(description, error.loop, mode)
            try:
                robot, later_errors = _first_closing(decided)
            except DescriptionError as failure:
                failures.append(failure)
            else:
                return robot, (error, *later_errors)
        raise failures[0] from error


def _with_mode(description: RobotDescription, loop: str, mode: str) -> RobotDescription:
    closures = list(description.closures)
    for k, closure in enumerate(closures):
        if closure.name == loop:
            closures[k] = replace(closure, assembly=mode)
    return replace(description, closures=tuple(closures))


def _description(robot: PathText) -> RobotDescription:
    if not isinstance(robot, (str, os.PathLike)):
        raise InputError(
            f"a robot is named by a text or a path, not by {robot!r} ({type(robot).__name__})"
        )
    name = os.fspath(robot)
    shipped = shipped_robots()
    if name in shipped:
        return _shipped_description(name, options_of(name))
    path = Path(name)
    if not _is_there(path) and path.suffix not in (".yaml", ".yml"):
        hint = suggestion(name, [*_robot_files_beside(path), *shipped])
        raise InputError(
            f"'{name}' is neither a shipped robot nor a file{hint}: {', '.join(shipped)}"
        )
    from .formats.reader import read_description  # noqa: PLC0415  slow to import

    return read_description(name, options_of(name))


def _shipped_description(name: str, options: FileOptions) -> RobotDescription:
    if options:
        return _read_shipped(name, options)
    return _unchanged(name)


@cache
def _unchanged(name: str) -> RobotDescription:
    """A shipped robot as its file has it, read once a process: descriptions are not changed."""
    return _read_shipped(name, NO_OPTIONS)


def _read_shipped(name: str, options: FileOptions) -> RobotDescription:
    from .formats.reader import parse_description  # noqa: PLC0415  slow to import

    file = f"{name}.yaml"
    resource = resources.files(__package__).joinpath("robots", file)
    return parse_description(resource.read_text(encoding="utf-8"), file, options)


def _is_there(path: Path) -> bool:
    """Whether a path exists; True without an answer, since reading will fail then."""
    try:
        return answered_in_time(path.exists)
    except TimeoutError:
        return True


def _robot_files_beside(path: Path) -> list[str]:
    """Possible robot files in the folder of a path, for messages."""
    folder = path.parent
    if not folder.is_dir():
        return []
    return [str(folder / file.name) for file in folder.iterdir() if file.suffix in _SUFFIXES]
