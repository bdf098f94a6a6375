"""python -m hybrid_dynamics_core.export ROBOT [FILE]: a shipped robot or a description file as URDF, to FILE or out."""

from __future__ import annotations

import sys
from pathlib import Path

from hybrid_dynamics_core.errors import HybridDynamicsError
from hybrid_dynamics_core.export.urdf import to_urdf
from hybrid_dynamics_core.library import load


def main(arguments: list[str]) -> int:
    """Write the URDF; returns the exit code of the process."""
    if len(arguments) not in (1, 2):
        sys.stderr.write(f"{__doc__}\n")
        return 2
    try:
        text = to_urdf(load(arguments[0]).description)
        if len(arguments) == 2:
            Path(arguments[1]).write_text(text, encoding="utf-8")
        else:
            sys.stdout.write(text)
    except (HybridDynamicsError, OSError) as error:
        sys.stderr.write(f"{error}\n")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
