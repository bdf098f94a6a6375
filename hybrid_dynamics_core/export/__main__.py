"""The export as a command: `python -m hybrid_dynamics_core.export ROBOT [FILE] [--overwrite]`."""

from __future__ import annotations

import sys
from pathlib import Path

from ..errors import HybridDynamicsError
from ..formats.output_files import write_files
from ..formats.urdf.writer import to_urdf
from ..library import load

_USAGE = """\
python -m hybrid_dynamics_core.export ROBOT [FILE] [--overwrite]: a robot as URDF, to FILE or out.

A file that is there already is replaced with --overwrite only, and never the one that the robot is
read from.
"""


def main(arguments: list[str]) -> int:
    """Write the URDF; returns the exit code of the process."""
    overwrite = "--overwrite" in arguments
    arguments = [argument for argument in arguments if argument != "--overwrite"]
    if len(arguments) not in (1, 2):
        sys.stderr.write(f"{_USAGE}\n")
        return 2
    try:
        description = load(arguments[0]).description
        if len(arguments) == 2:
            place = Path(arguments[1])
            text = to_urdf(description, place.parent)
            write_files({place: text}, description, overwrite)
        else:
            sys.stdout.write(to_urdf(description))
    except (HybridDynamicsError, OSError) as error:
        sys.stderr.write(f"{error}\n")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
