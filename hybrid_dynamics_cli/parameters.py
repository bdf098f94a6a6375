"""What the verbs take: robots, vectors of numbers, output options."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

import click
import numpy as np
from click.shell_completion import CompletionItem

from hybrid_dynamics_core import InputError, Robot, UndecidedModeError, load, shipped_robots
from hybrid_dynamics_core.description.expressions import evaluate
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.ground.decimal_commas import POINT_HINT
from hybrid_dynamics_core.ground.suggestions import did_you_mean, suggestion
from hybrid_dynamics_core.ground.wording import counted
from hybrid_dynamics_core.library import load_undecided

Command = TypeVar("Command", bound=Callable[..., Any])


class RobotType(click.ParamType):  # type: ignore[type-arg]
    """A shipped robot's name, or the path of a description file."""

    name = "robot"

    def shell_complete(
        self,
        ctx: click.Context,  # noqa: ARG002
        param: click.Parameter,  # noqa: ARG002
        incomplete: str,
    ) -> list[CompletionItem]:
        """Names of shipped robots, then files."""
        named = [CompletionItem(name) for name in shipped_robots() if name.startswith(incomplete)]
        return named or [CompletionItem(incomplete, type="file")]


class NumberType(click.ParamType):  # type: ignore[type-arg]
    """A number, or a term as descriptions take them: 0.1, pi/2, 30*deg."""

    name = "number"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """The value of a term."""
        if isinstance(value, float):
            return value
        try:
            return evaluate(str(value), {}, known="")
        except (ValueError, ArithmeticError) as error:
            self.fail(f"'{value}': {error}", param, ctx)


NUMBER = NumberType()
PLACES = "0,0.1,30*deg or by name, q12=0.1,q4=pi/2"  # how vectors are written,
EFFORTS = "0,5000,2000,0 or by name, q12=5000"  # and those of efforts
robot_argument = click.argument("robot", type=RobotType(), metavar="ROBOT")
json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON for programs.")


def vector_option(*names: str, form: str = PLACES, **more: Any) -> Callable[[Command], Command]:
    """An option for one value per active joint: `0,0.1,0.15,0`, or `q12=0.1,q4=pi/2` where the others stay."""
    more["help"] = f"{more['help']} As {form}."
    return click.option(*names, metavar="VALUES", shell_complete=_complete_values, **more)


def frame_option(text: str) -> Callable[[Command], Command]:
    """An option for the name of a frame or link."""
    return click.option("--frame", metavar="NAME", shell_complete=_complete_frames, help=text)


def _complete_frames(ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    robot = _robot_so_far(ctx)
    return [] if robot is None else [name for name in robot.frames if name.startswith(incomplete)]


def _complete_values(ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[str]:
    """Active joints by name, behind those that are there already."""
    robot, (there, comma, begun) = _robot_so_far(ctx), incomplete.rpartition(",")
    told = {part.partition("=")[0].strip() for part in there.split(",")}
    names = [] if robot is None else [name for name in robot.active if name not in told]
    return [f"{there}{comma}{name}=" for name in names if name.startswith(begun)]


def _robot_so_far(ctx: click.Context) -> Robot | None:
    """The robot that a line being typed names; click leaves it among the arguments while a value is missing."""
    try:
        return load(
            ctx.params.get("robot") or next(word for word in ctx.args if not word.startswith("-"))
        )
    except Exception:  # noqa: BLE001 - a shell that completes wants no errors
        return None


def loaded(robot: str) -> Robot:
    """The robot; a file that cannot be read is told as what it is."""
    with _readable(robot):
        try:
            return load(robot)
        except UndecidedModeError as error:
            raise click.ClickException(
                f"{error}\n`hybrid-dynamics branches {robot}` shows where they are"
            ) from error


def loaded_undecided(robot: str) -> tuple[Robot, list[str]]:
    """The robot even where its file leaves assembly modes open, and what is open, told for people."""
    with _readable(robot):
        machine, undecided = load_undecided(robot)
    return machine, [str(error) for error in undecided]


@contextmanager
def _readable(robot: str) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise click.ClickException(f"{robot}: {error.strerror or error}") from error


def vector(name: str, text: str | None, names: Sequence[str], default: Array) -> Array:
    """Values (n,) from the text of an option; those that are not named are taken from `default`.

    Raises InputError for other names and another number of values, BadParameter for what is no
    term.
    """
    values = np.array(default, dtype=float)
    if text is None or not text.strip():
        return values
    parts = [part.strip() for part in text.split(",")]
    named = ["=" in part for part in parts]
    if any(named) and not all(named):
        raise click.BadParameter(_mixed(text, parts, named.index(False)), param_hint=name)
    told: dict[int, float] = {}
    for k, part in enumerate(parts):
        key, _, term = part.rpartition("=")
        key = key.strip()
        if key and key not in names:
            commas = _commas(text)
            if commas:
                raise click.BadParameter(f"'{part}'{commas}", param_hint=name)
            raise InputError(
                f"{name}: '{key}' is not an active joint{suggestion(key, names)}; they are"
                f" {', '.join(names)}"
            )
        try:
            told[names.index(key) if key else k] = evaluate(term, {}, known="")
        except (ValueError, ArithmeticError) as error:
            joint = f" of {names[k]}" if not key and k < len(names) else ""
            raise click.BadParameter(
                f"'{part}'{joint}: {error}{_commas(text)}", param_hint=name
            ) from error
    if not any(named) and len(parts) != len(names):
        given = counted(len(parts), "value")
        raise InputError(
            f"{name}: {given}; expected {len(names)}, for {', '.join(names)}{_commas(text)}"
        )
    values[list(told)] = list(told.values())
    return values


def _mixed(text: str, parts: Sequence[str], k: int) -> str:
    """What is wrong where some values have names and the k-th has none."""
    bare, before = parts[k], parts[max(k - 1, 0)]
    if bare.isdigit() and re.search(r"=\s*[-+]?\d+$", before):
        return f"'{text}'{POINT_HINT}{did_you_mean(f'{before}.{bare}')}"
    alone = (
        f"; where a word such as '{bare}' is taken, it stands alone" if bare.isidentifier() else ""
    )
    return f"either all values by name, or none: '{text}'{alone}"


def _commas(text: str) -> str:
    """That values are parted by commas, where blanks or semicolons part them; of no other text."""
    parts = [part for part in re.split(r"[\s,;]+", text.strip()) if part]
    if len(parts) == 1 + text.count(","):
        return ""
    try:
        for part in parts:
            evaluate(part.rpartition("=")[2], {}, known="")
    except (ValueError, ArithmeticError):
        return ""
    named = sum("=" in part for part in parts)
    told = f": {','.join(parts)}" if named in (0, len(parts)) else ""
    return f"; values are parted by commas{told}"


def pair(text: str) -> tuple[str, tuple[float, float]]:
    """A name with two numbers, from `NAME=LOW:HIGH`."""
    name, _, numbers = text.partition("=")
    expected = "expected NAME=LOW:HIGH, as q12=0.1:0.5"
    try:
        terms = (
            [evaluate(term, {}, known="") for term in numbers.split(":")] if numbers.strip() else []
        )
    except (ValueError, ArithmeticError) as error:
        raise click.BadParameter(f"'{text}': {error}; {expected}", param_hint="--range") from error
    if len(terms) != 2 or not name.strip():
        raise click.BadParameter(f"'{text}': {expected}", param_hint="--range")
    return name.strip(), (terms[0], terms[1])


@contextmanager
def options(*names: str) -> Iterator[None]:
    """Errors of the library name its arguments; here they are options: `range: ...` is told as `--range: ...`."""
    try:
        yield
    except InputError as error:
        if str(error).partition(":")[0] in names:
            raise InputError(f"--{error}") from error
        raise
