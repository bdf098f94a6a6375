"""Parameters of the verbs: robots, vectors of numbers, output options."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from typing import Any, TypeVar

import click
import numpy as np
from click.shell_completion import CompletionItem

from hybrid_dynamics_core import (
    ClosedState,
    InputError,
    Robot,
    UndecidedModeError,
    load,
    shipped_robots,
)
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.ground.decimal_commas import POINT_HINT
from hybrid_dynamics_core.ground.suggestions import did_you_mean, suggestion
from hybrid_dynamics_core.ground.wording import counted
from hybrid_dynamics_core.library import load_undecided

from .quantities import coordinate_units, value_of
from .robot_options import with_options, with_robot_options

Command = TypeVar("Command", bound=Callable[..., Any])
T = TypeVar("T")


class RobotType(click.ParamType):  # type: ignore[type-arg]
    """Type of an argument with the name of a shipped robot, or the path of a robot file."""

    name = "robot"

    def convert(
        self,
        value: str,
        param: click.Parameter | None,  # noqa: ARG002
        ctx: click.Context | None,
    ) -> str:
        """The name, with the options for reading its file."""
        return with_options(value, ctx)

    def shell_complete(
        self,
        ctx: click.Context,  # noqa: ARG002
        param: click.Parameter,  # noqa: ARG002
        incomplete: str,
    ) -> list[CompletionItem]:
        """The names of shipped robots that fit, otherwise files."""
        robots = [CompletionItem(name) for name in shipped_robots() if name.startswith(incomplete)]
        return robots or [CompletionItem(incomplete, type="file")]


COORDINATES = "0,0.1,30*deg or by name, q12=0.1,q4=pi/2"  # form of a vector
EFFORTS = "0,5000,2000,0 or by name, q12=5000"  # form of a vector
robot_argument = with_robot_options(click.argument("robot", type=RobotType(), metavar="ROBOT"))
json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON for programs.")


def _complete_frames(ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    robot = _robot_so_far(ctx)
    if robot is None:
        return []
    return [name for name in robot.frames if name.startswith(incomplete)]


def _complete_values(ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """The names of active joints, after those already on the line."""
    robot = _robot_so_far(ctx)
    if robot is None:
        return []
    before, comma, begun = incomplete.rpartition(",")
    given = {part.partition("=")[0].strip() for part in before.split(",")}
    candidates = [name for name in robot.active if name not in given]
    return [f"{before}{comma}{name}=" for name in candidates if name.startswith(begun)]


def _robot_so_far(ctx: click.Context) -> Robot | None:
    """The robot in an incomplete command line.

    While a value is missing, click leaves it among the arguments.
    """
    try:
        name = ctx.params.get("robot")
        if not name:
            name = next(word for word in ctx.args if not word.startswith("-"))
        return load(name)
    except Exception:  # noqa: BLE001 - a shell that completes wants no errors
        return None


def vector_option(
    *names: str,
    help: str,  # noqa: A002 - as click
    form: str = COORDINATES,
) -> Callable[[Command], Command]:
    """An option for one value per active joint.

    All values are written as `0,0.1,0.15,0`, or some as `q12=0.1,q4=pi/2`, with defaults for the
    others.
    """
    text = f"{help} As {form}."
    return click.option(*names, metavar="VALUES", shell_complete=_complete_values, help=text)


u_option = vector_option(
    "-u", "--u", help="Active coordinates [rad or m]; the robot's reference where left out."
)
du_option = vector_option("--du", help="Their rates [per second]; zero where left out.")
ddu_option = vector_option(
    "--ddu", help="Their accelerations [per second squared]; zero where left out."
)


def frame_option(text: str) -> Callable[[Command], Command]:
    """An option for the name of a frame or link."""
    return click.option("--frame", metavar="NAME", shell_complete=_complete_frames, help=text)


def loaded(robot: str, strict: bool = False) -> Robot:
    """The robot with a name or path.

    Args:
        robot: name of a shipped robot, or path of a file.
        strict: whether to refuse inertias that no rigid body has.

    Raises:
        click.ClickException: the file cannot be read, or leaves assembly modes open.
        HybridDynamicsError: from `load`.
    """
    with _readable(robot), _file_options():
        try:
            return load(robot, strict=strict)
        except UndecidedModeError as error:
            text = f"{error}\n`hybrid-dynamics branches {robot}` shows where they are"
            raise click.ClickException(text) from error


def loaded_undecided(robot: str, strict: bool = False) -> tuple[Robot, list[str]]:
    """The robot, and a sentence for each assembly mode that its file does not decide.

    Raises:
        click.ClickException: the file cannot be read.
        HybridDynamicsError: from `load_undecided`.
    """
    with _readable(robot), _file_options():
        machine, undecided = load_undecided(robot, strict=strict)
    return machine, [str(error) for error in undecided]


@contextmanager
def _readable(robot: str) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise click.ClickException(f"{robot}: {error.strerror or error}") from error


def vector(
    option: str,
    text: str | None,
    names: Sequence[str],
    default: Array,
    units: Sequence[str] = (),
) -> Array:
    """The values from the text of an option.

    Args:
        option: name of the option, for messages.
        text: text of the option; None if it is not given.
        names: (n) names of the values.
        default: (n,) values without a name in the text.
        units: (n) allowed units of the values.

    Returns:
        The values (n,), in the units of `default`.

    Raises:
        InputError: an unknown name, or a wrong number of values.
        click.BadParameter: an invalid term, or a mixture of values with and without names.
    """
    values = np.array(default, dtype=float)
    if text is None:
        return values
    if not text.strip():
        default_is = "without the option they are the default ones"
        raise InputError(f"{option}: no values; expected those of {', '.join(names)}; {default_is}")
    parts = [part.strip() for part in text.split(",")]
    is_named = ["=" in part for part in parts]
    if any(is_named) and not all(is_named):
        problem = _mixed(text, parts, is_named.index(False))
        raise click.BadParameter(problem, param_hint=option)
    indices = [_index(option, text, part, names, k) for k, part in enumerate(parts)]
    terms = [
        _value_of(option, text, part, names, k, units[index : index + 1])
        for k, (part, index) in enumerate(zip(parts, indices, strict=True))
    ]
    if not any(is_named) and len(parts) != len(names):
        count = counted(len(parts), "value")
        expected = f"expected {len(names)}, for {', '.join(names)}"
        raise InputError(f"{option}: {count}; {expected}{_comma_hint(text)}")
    once_each(option, [(names[index], index) for index in indices])
    values[indices] = terms
    return values


def once_each(option: str, pairs: Iterable[tuple[str, T]]) -> dict[str, T]:
    """Values by name, of which none is given twice.

    Args:
        option: name of the option, for messages.
        pairs: names and values, in the order in which they were given.

    Raises:
        InputError: a name occurs twice.
    """
    values: dict[str, T] = {}
    for name, value in pairs:
        if name in values:
            raise InputError(f"{option}: {name} is given twice")
        values[name] = value
    return values


def closed(machine: Robot, u: str | None, du: str | None) -> ClosedState:
    """The closed state for the options -u and --du.

    Raises:
        StateError: the loops do not close, or are singular.
        InputError, click.BadParameter: from `vector`.
    """
    active = machine.active
    values = vector("-u", u, active, machine.reference, coordinate_units(machine))
    zero = np.zeros(len(active))
    rates = vector("--du", du, active, zero, coordinate_units(machine, "/s"))
    return machine.close(values, rates)


def accelerations_of(machine: Robot, ddu: str | None) -> Array:
    """The active accelerations (n,) for the option --ddu.

    Raises:
        InputError, click.BadParameter: from `vector`.
    """
    active = machine.active
    return vector("--ddu", ddu, active, np.zeros(len(active)), coordinate_units(machine, "/s^2"))


def _index(option: str, text: str, part: str, names: Sequence[str], position: int) -> int:
    """Index of the value set by a part of an option's text, by name or by position."""
    name = part.rpartition("=")[0].strip()
    if not name:
        return position
    if name in names:
        return names.index(name)
    hint = _comma_hint(text)
    if hint:
        raise click.BadParameter(f"'{part}'{hint}", param_hint=option)
    problem = f"'{name}' is not an active joint{suggestion(name, names)}"
    raise InputError(f"{option}: {problem}; they are {', '.join(names)}")


def _value_of(
    option: str,
    text: str,
    part: str,
    names: Sequence[str],
    position: int,
    units: Sequence[str],
) -> float:
    """The value of a part of an option's text."""
    name, _, term = part.rpartition("=")
    try:
        return value_of(term, units)
    except (ValueError, ArithmeticError) as error:
        joint = ""
        if not name.strip() and position < len(names):
            joint = f" of {names[position]}"
        problem = f"'{part}'{joint}: {error}{_comma_hint(text)}"
        raise click.BadParameter(problem, param_hint=option) from error


def _mixed(text: str, parts: Sequence[str], k: int) -> str:
    """The error for a text in which some values have names and the k-th has none."""
    bare = parts[k]
    previous = parts[max(k - 1, 0)]
    if bare.isdigit() and re.search(r"=\s*[-+]?\d+$", previous):
        joined = did_you_mean(f"{previous}.{bare}")
        return f"'{text}'{POINT_HINT}{joined}"
    problem = f"either all values by name, or none: '{text}'"
    if bare.isidentifier():
        problem += f"; where a word such as '{bare}' is taken, it stands alone"
    return problem


def _comma_hint(text: str) -> str:
    """A hint for values separated by blanks or semicolons; empty for other texts."""
    parts = [part for part in re.split(r"[\s,;]+", text.strip()) if part]
    if len(parts) == 1 + text.count(","):
        return ""
    try:
        for part in parts:
            value_of(part.rpartition("=")[2])
    except (ValueError, ArithmeticError):
        return ""
    hint = "; values are parted by commas"
    named = sum("=" in part for part in parts)
    if named in (0, len(parts)):
        hint += f": {','.join(parts)}"
    return hint


def pair(text: str, machine: Robot) -> tuple[str, tuple[float, float]]:
    """A name with two numbers, from `NAME=LOW:HIGH`.

    Args:
        text: text of the option.
        machine: the robot; the type of the named active joint determines the unit.

    Raises:
        click.BadParameter: the text is of another form.
    """
    name, _, numbers = text.partition("=")
    expected = "expected NAME=LOW:HIGH, as q12=0.1:0.5"
    terms: list[float] = []
    try:
        if numbers.strip():
            units = dict(zip(machine.active, coordinate_units(machine), strict=True))
            unit = [units[name.strip()]] if name.strip() in units else []
            terms = [value_of(term, unit) for term in numbers.split(":")]
    except (ValueError, ArithmeticError) as error:
        raise click.BadParameter(f"'{text}': {error}; {expected}", param_hint="--range") from error
    if len(terms) != 2 or not name.strip():
        raise click.BadParameter(f"'{text}': {expected}", param_hint="--range")
    return name.strip(), (terms[0], terms[1])


def named_value(text: str, option: str, machine: Robot) -> tuple[str, float]:
    """A name with a number, from `NAME=VALUE`.

    Args:
        text: text of the option.
        option: name of the option.
        machine: the robot; the type of the named active joint determines the unit.

    Raises:
        click.BadParameter: the text is of another form.
    """
    name, _, number = text.partition("=")
    name = name.strip()
    expected = "expected NAME=VALUE, as q12=0.1"
    if not name or not number.strip():
        raise click.BadParameter(f"'{text}': {expected}", param_hint=option)
    units = dict(zip(machine.active, coordinate_units(machine), strict=True))
    unit = [units[name]] if name in units else []
    try:
        return name, value_of(number, unit)
    except (ValueError, ArithmeticError) as error:
        raise click.BadParameter(f"'{text}': {error}; {expected}", param_hint=option) from error


@contextmanager
def options(*names: str, **others: str) -> Iterator[None]:
    """Make options of the arguments that errors of the library name.

    `range: ...` becomes `--range: ...`.

    Args:
        names: arguments that are options here.
        others: options of another name, by argument.
    """
    renamed = {**dict(zip(names, names, strict=True)), **others}
    try:
        yield
    except InputError as error:
        name, colon, problem = str(error).partition(":")
        if name in renamed:
            raise InputError(f"--{renamed[name]}{colon}{problem}") from error
        raise


def _file_options() -> AbstractContextManager[None]:
    """Make options of the arguments of `load`."""
    return options("model", parameters="set", xacro_args="xacro-arg", search_path="search-path")
