"""Options for reading robot files, shared by every verb with a robot."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, TypeVar

import click

from hybrid_dynamics_core.errors import InputError
from hybrid_dynamics_core.ground.file_options import RobotFile, file_options

Command = TypeVar("Command", bound=Callable[..., Any])

_KEY: Final = "hybrid_dynamics_cli.robot_options"  # key in `meta` of click's context
_PARAMETERS: Final = "--set"
_XACRO_ARGS: Final = "--xacro-arg"
_SEARCH_PATH: Final = "--search-path"
_MODEL: Final = "--model"


def named_pairs(option: str, texts: tuple[str, ...], sign: str, example: str) -> dict[str, str]:
    """The values by name from texts such as `NAME=VALUE`.

    Args:
        option: name of the option, for messages.
        texts: texts of the option.
        sign: separator of name and value.
        example: an example, for messages.

    Raises:
        click.BadParameter: a text has another form, or a name occurs twice.
    """
    pairs: dict[str, str] = {}
    for text in texts:
        name, between, value = text.partition(sign)
        name = name.strip()
        if not between or not name:
            problem = f"'{text}': expected NAME{sign}VALUE, as {example}"
            raise click.BadParameter(problem, param_hint=option)
        if name in pairs:
            raise click.BadParameter(f"'{name}' is given twice", param_hint=option)
        pairs[name] = value.strip()
    return pairs


def _keep(context: click.Context, option: click.Parameter, texts: tuple[str, ...]) -> None:
    """Store the texts of an option until the name of the robot is parsed, which comes later."""
    if texts:
        context.meta.setdefault(_KEY, {})[option.opts[0]] = texts


def _option(name: str, metavar: str, text: str) -> Callable[[Command], Command]:
    """An option that may be repeated, stored until the name of the robot is parsed."""
    return click.option(
        name,
        metavar=metavar,
        multiple=True,
        is_eager=True,
        expose_value=False,
        callback=_keep,
        help=text,
    )


def with_robot_options(argument: Callable[[Command], Command]) -> Callable[[Command], Command]:
    """An argument or option for a robot, with the options for reading its file."""
    options = (
        _option(
            _PARAMETERS,
            "NAME=VALUE",
            "Value of a parameter of the robot's file, as L1=40*cm; any number of times.",
        ),
        _option(_XACRO_ARGS, "NAME:=VALUE", "Argument of a xacro file; any number of times."),
        _option(
            _SEARCH_PATH,
            "FOLDER",
            "Where the packages of a file are looked for; any number of times.",
        ),
        _option(_MODEL, "NAME", "The robot in an SDFormat file of several."),
    )

    def decorate(command: Command) -> Command:
        for option in reversed(options):
            command = option(command)
        return argument(command)

    return decorate


def with_options(name: str, context: click.Context | None) -> str:
    """The name of the robot, with its options.

    Raises:
        click.BadParameter: an option has another form.
    """
    given = {} if context is None else context.meta.get(_KEY, {})
    if not given:
        return name
    parameters = named_pairs(_PARAMETERS, given.get(_PARAMETERS, ()), "=", "L1=40*cm")
    arguments = named_pairs(_XACRO_ARGS, given.get(_XACRO_ARGS, ()), ":=", "prefix:=left_")
    folders = given.get(_SEARCH_PATH, ())
    model = given.get(_MODEL, ("",))
    if len(model) > 1:
        raise click.BadParameter("is given twice", param_hint=_MODEL)
    try:
        return RobotFile(name, file_options(parameters, arguments, folders, model[0]))
    except InputError as error:
        raise click.BadParameter(str(error), ctx=context) from error


def require_robot(context: click.Context, _: click.Parameter, name: str | None) -> str | None:
    """Refuse options for reading a robot file without a robot.

    Raises:
        click.UsageError: options are given without a robot.
    """
    given = context.meta.get(_KEY)
    if name is None and given:
        options = ", ".join(given)
        raise click.UsageError(f"{options}: name the robot too, with --robot")
    return name
