"""A robot as a folder of C99: header, source, build files, and a check of the build."""

from __future__ import annotations

from collections.abc import Sequence

from ...errors import InputError
from ...robot.robot import Robot
from ...robot.taken import AnyRobot, robot_of
from .calls import Tracer, calls_of
from .header import header_text
from .names import identifier, identifiers
from .package_files import cmake_text, package_text, readme_text
from .signatures import Names
from .source import source_text
from .vectors_file import vectors_text


def to_c(robot: AnyRobot, programs: Sequence[str] | None = None) -> dict[str, str]:
    """The model of a robot as C99.

    Args:
        robot: the robot, or its description.
        programs: names of the functions, such as "inverse_dynamics"; all if None.

    Returns:
        The text of each file, by its name: ROBOT.h, ROBOT.c, CMakeLists.txt, package.xml,
        README.md and test_vectors.c.

    Raises:
        InputError: there is no such program, or nothing moves.
    """
    calls = calls_of(programs)
    machine = robot_of(robot)
    names = _names(machine)
    tracer = Tracer(machine)
    traced = [tracer.trace(call) for call in calls]
    start = tracer.trace_start() if tracer.follows else None
    return {
        f"{names.prefix}.h": header_text(machine, names, traced, tracer.follows),
        f"{names.prefix}.c": source_text(machine, names, traced, start),
        "CMakeLists.txt": cmake_text(names),
        "package.xml": package_text(names),
        "README.md": readme_text(machine, names, traced, tracer.follows),
        "test_vectors.c": vectors_text(machine, names, traced),
    }


def _names(robot: Robot) -> Names:
    """Identifiers of a robot.

    Raises:
        InputError: it has no active coordinate.
    """
    if not robot.active:
        raise InputError(f"{robot.name}: nothing moves, so there is no model to write in C")
    coordinates = identifiers(robot.coordinates)
    ordered = tuple(coordinates[name] for name in robot.coordinates)
    return Names(identifier(robot.name), ordered, len(robot.active))
