"""Draw a robot from the command line: python -m hybrid_dynamics_core.drawing ROBOT OUT."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import get_args

from ..errors import HybridDynamicsError
from ..library import load, shipped_robots
from . import draw, draw_modes
from .options import Names


def main(arguments: Sequence[str] | None = None) -> None:
    """Draw; a wrong robot or file ends with one message and the exit status 1."""
    parser = argparse.ArgumentParser(
        prog="python -m hybrid_dynamics_core.drawing", description="Draw a robot."
    )
    parser.add_argument("robot", help=f"description file, or one of {', '.join(shipped_robots())}")
    parser.add_argument("out", help="file to write, .svg or .png")
    parser.add_argument(
        "--names",
        choices=get_args(Names),
        help="whose names are shown (active; with --modes: none)",
    )
    parser.add_argument(
        "--modes", action="store_true", help="all assembly modes of the reference, side by side"
    )
    parser.add_argument(
        "--skeleton",
        action="store_true",
        help="bars and plates between joints in place of the robot's visuals",
    )
    options = parser.parse_args(arguments)
    try:
        robot = load(options.robot)
        if options.modes:
            draw_modes(robot, path=options.out, names=options.names or "none")
        else:
            draw(
                robot,
                path=options.out,
                names=options.names or "active",
                skeleton=options.skeleton,
            )
    except (HybridDynamicsError, OSError) as error:
        parser.exit(1, f"{error}\n")


if __name__ == "__main__":
    main()
