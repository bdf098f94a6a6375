"""The exit codes of the command."""

from __future__ import annotations

from typing import Final

import click

from hybrid_dynamics_core.errors import InputError

from .file_routing import taken_by

DONE: Final = 0
FAILED: Final = 1
MISUSED: Final = 2  # exit code of click for wrong options
LOST: Final = 3

MEANINGS: Final = {
    DONE: "done",
    FAILED: (
        "the call is right, and the answer is no: a fault inside a file, a loop\n"
        "     that does not close, a place out of reach"
    ),
    MISUSED: (
        "the call is wrong: a verb, an option, a name or a value; a file that is\n"
        "     not there, is of another kind, or is not to be replaced"
    ),
    LOST: "done, but a part of the recording could not be read (bag)",
}


class Misused(click.ClickException):
    """A wrong call, with a message in place of click's usage lines."""

    exit_code = MISUSED


def click_error(error: Exception) -> click.ClickException:
    """The click exception for an error of the library.

    The message also names the verb that accepts the file. The exit code is MISUSED for an
    InputError, and FAILED for all others.
    """
    text = f"{error}{taken_by(error)}"
    if isinstance(error, InputError):
        return Misused(text)
    return click.ClickException(text)


def exit_table() -> str:
    """The table of exit codes for `--help`."""
    return "\n".join(f"  {code}  {meaning}" for code, meaning in MEANINGS.items())
