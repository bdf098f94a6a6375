"""Options for reading a robot file: parameters, xacro arguments, search path, model."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from ..errors import InputError
from .check_arguments import real_number

PathText = str | os.PathLike[str]
Parameter = float | str  # a number in SI units, or an expression


@dataclass(frozen=True)
class FileOptions:
    """Options for reading a file.

    Attributes:
        parameters: values that replace those of the file's parameters.
        xacro_args: arguments of a xacro file.
        search_path: folders of packages, searched after those around the file.
        model: name of the robot in a file of several.
    """

    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    xacro_args: Mapping[str, str] = field(default_factory=dict)
    search_path: tuple[str, ...] = ()
    model: str = ""

    def __bool__(self) -> bool:
        """Whether anything is given."""
        return bool(self.parameters or self.xacro_args or self.search_path or self.model)


NO_OPTIONS = FileOptions()


class RobotFile(str):
    """Name of a shipped robot or path of a file, with options for reading it.

    It is a `str`, and may be used wherever such a name is.

    Attributes:
        options: options for reading the file.
    """

    __slots__ = ("options",)
    options: FileOptions

    def __new__(cls, name: str, options: FileOptions) -> RobotFile:
        """Make a name with options."""
        file = super().__new__(cls, name)
        file.options = options
        return file

    def __getnewargs__(self) -> tuple[str, FileOptions]:  # type: ignore[override]
        """Arguments for copies and pickles."""
        return str(self), self.options


def options_of(name: str) -> FileOptions:
    """The options of a name; empty for a plain `str`."""
    return name.options if isinstance(name, RobotFile) else NO_OPTIONS


def file_options(
    parameters: Mapping[str, Parameter] | None = None,
    xacro_args: Mapping[str, object] | None = None,
    search_path: PathText | Iterable[PathText] = (),
    model: str = "",
) -> FileOptions:
    """Check the options of a call.

    Args:
        parameters: values by name: numbers in SI units, or expressions.
        xacro_args: texts by name; numbers and booleans are converted to xacro's form.
        search_path: a folder, or several.
        model: name of the robot in a file of several; empty if the file has one.

    Raises:
        InputError: an option has a wrong type.
    """
    values: dict[str, Parameter] = {}
    for name, value in _items("parameters", parameters):
        values[name] = _parameter(name, value)
    texts = {name: _xacro_text(value) for name, value in _items("xacro_args", xacro_args)}
    if isinstance(search_path, (str, os.PathLike)):
        search_path = (search_path,)
    folders = tuple(os.fspath(folder) for folder in search_path)
    for folder in folders:
        if not os.path.isdir(folder):  # noqa: PTH112 - a text that stays one
            raise InputError(f"search_path: there is no folder '{folder}'")
    if not isinstance(model, str):
        raise InputError(f"model: is {model!r}; expected the name of a model in the file")
    return FileOptions(values, texts, folders, model)


def _items(argument: str, given: object) -> Iterable[tuple[str, object]]:
    if given is None:
        return ()
    if not isinstance(given, Mapping) or not all(isinstance(name, str) for name in given):
        raise InputError(f"{argument}: is {given!r}; expected values by name")
    return given.items()


def _parameter(name: str, value: object) -> Parameter:
    """A number or an expression; numbers of NumPy become Python's."""
    if isinstance(value, str):
        return value
    return real_number(f"parameters: {name}", value)


def _xacro_text(value: object) -> str:
    """The text of a value in xacro."""
    if isinstance(value, bool):
        return str(value).lower()
    return str(value)
