"""How the command ends: the one table of exit codes."""

from __future__ import annotations

from typing import Final

DONE: Final = 0
FAILED: Final = 1
MISUSED: Final = 2  # click's own
LOST: Final = 3

MEANINGS: Final = {
    DONE: "done",
    FAILED: "no answer: a wrong robot, value or file, an open loop, or out of reach",
    MISUSED: "the command line is not understood: a verb, an option, or a value",
    LOST: "done, but a part of the recording could not be read (bag)",
}


def exit_table() -> str:
    """The table as it stands under `--help`."""
    return "\n".join(f"  {code}  {meaning}" for code, meaning in MEANINGS.items())
