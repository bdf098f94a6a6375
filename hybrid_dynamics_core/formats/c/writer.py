"""A robot as a folder of C99: header, source, build files, and a check of the build."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

from ...errors import InputError
from ...robot.robot import Robot
from ...robot.taken import AnyRobot, robot_of
from .calls import CFunction, calls_of
from .cpp import cpp_text
from .header import header_text
from .names import identifier, identifiers
from .package_files import cmake_text, package_text, readme_text
from .real import PRECISIONS, REALS, Real, in_single_precision
from .shared import LARGE
from .signatures import Names
from .source import source_text
from .tracer import TracedFunction, Tracer
from .vectors_file import vectors_text

LOADS = ("description", "arguments")
LoadsOf = Literal["description", "arguments"]


def to_c(
    robot: AnyRobot,
    programs: Sequence[str] | None = None,
    *,
    real: Real = "double",
    loads: LoadsOf = "description",
) -> dict[str, str]:
    """The model of a robot as C99.

    Args:
        robot: the robot, or its description.
        programs: names of the functions, such as "inverse_dynamics"; if None, those for closure,
            kinematics and dynamics. Reactions, derivatives and others are written on request.
        real: type of the numbers, "double" or "float".
        loads: "description" to compile its loads in; "arguments" for functions that take a
            payload and friction.

    Returns:
        The text of each file, by its name: ROBOT.h, ROBOT.c, ROBOT.hpp, CMakeLists.txt,
        package.xml, README.md and test_vectors.c.

    Raises:
        InputError: there is no such program, type or place of loads, the robot lacks what a program
            needs, or nothing moves.
    """
    machine = robot_of(robot)
    calls = calls_of(programs, machine)
    _require("real", real, REALS)
    _require("loads", loads, LOADS)
    names = names_of(machine)
    tracer = Tracer(machine, with_loads=loads == "arguments", real=real)
    traced = _traced(tracer, calls)
    readme = readme_text(machine, names, traced, tracer.follows)
    code = {
        **_source(machine, names, tracer, traced),
        f"{names.prefix}.hpp": cpp_text(names, traced),
        "test_vectors.c": vectors_text(machine, names, traced, PRECISIONS[real]),
    }
    if real == "float":
        code = {name: in_single_precision(text) for name, text in code.items()}
        readme = readme.replace("double ", "float ")
    return {
        **code,
        "CMakeLists.txt": cmake_text(names),
        "package.xml": package_text(names),
        "README.md": readme,
    }


def source_of(
    robot: Robot,
    programs: Sequence[str],
    loads: LoadsOf = "description",
    prefix: str = "",
    further: Sequence[CFunction] = (),
) -> dict[str, str]:
    """The source and header alone, for code that is built around them.

    Args:
        robot: the robot.
        programs: names of the functions.
        loads: as of `to_c`.
        prefix: of all names; that of the robot if empty.
        further: functions besides.

    Returns:
        The text of ROBOT.h and ROBOT.c, by their names.

    Raises:
        InputError: as of `to_c`.
    """
    calls = [*calls_of(programs, robot), *further]
    _require("loads", loads, LOADS)
    names = names_of(robot)
    if prefix:
        names = replace(names, prefix=prefix)
    tracer = Tracer(robot, with_loads=loads == "arguments")
    return _source(robot, names, tracer, _traced(tracer, calls))


def _source(
    robot: Robot, names: Names, tracer: Tracer, traced: Sequence[TracedFunction]
) -> dict[str, str]:
    """The texts of header and source."""
    start = tracer.trace_start() if tracer.follows else None
    return {
        f"{names.prefix}.h": header_text(robot, names, traced, start),
        f"{names.prefix}.c": source_text(robot, names, traced, start, tracer.precision),
    }


def _traced(tracer: Tracer, calls: Sequence[CFunction]) -> list[TracedFunction]:
    """The traces of calls; in one graph where they are long."""
    first = tracer.trace(calls[0])
    if len(calls) > 1 and len(first.trace.live) * len(calls) > LARGE:
        return tracer.trace_together(calls)
    return [first, *map(tracer.trace, calls[1:])]


def _require(name: str, value: object, allowed: Sequence[str]) -> None:
    if value not in allowed:
        raise InputError(f"{name}: {value!r}: expected {' or '.join(allowed)}")


def names_of(robot: Robot) -> Names:
    """Identifiers of a robot.

    Raises:
        InputError: it has no active coordinate.
    """
    if not robot.active:
        raise InputError(f"{robot.name}: nothing moves, so there is no model to write in C")
    coordinates = identifiers(robot.coordinates)
    ordered = tuple(coordinates[name] for name in robot.coordinates)
    return Names(identifier(robot.name), ordered, len(robot.active))
