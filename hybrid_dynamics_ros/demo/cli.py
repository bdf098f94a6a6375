"""Command line of the demo."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from .errors import DemoError, InterruptedDemoError
from .play.domain import private_domain

_ABOUT: Final = (
    "Play the recorded trajectory of Chu et al. (2020) into the running node, as real messages"
    " between processes.\n"
    "Show the full state and the efforts as they come; leave a rosbag2 recording of the results and"
    " a figure."
)
_EXAMPLES: Final = """examples:
  python -m hybrid_dynamics_ros.demo                       in real time, about 15 s
  python -m hybrid_dynamics_ros.demo --rate 5 --no-live    five times as fast, the summary alone
  python -m hybrid_dynamics_ros.demo --output elsewhere    files in another folder

exit code: 0 if every message came and the efforts agree with the model, 1 if not, 130 after \
Ctrl-C"""
INTERRUPTED: Final = 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the demo.

    Args:
        arguments: arguments of the command; None: those of the process.

    Returns:
        The exit code of the process.
    """
    options = _parser().parse_args(arguments)
    try:
        with private_domain(options.domain):
            # Late: rclpy starts Python anew when it is first imported, and --help needs none of it.
            from .run import run  # noqa: PLC0415

            good = run(options.output, options.rate, not options.no_live, sys.stdout)
    except (InterruptedDemoError, KeyboardInterrupt):
        return _fail("Stopped.", INTERRUPTED)
    except ModuleNotFoundError as error:
        return _fail(
            f"The demo needs the module {error.name}. 'make demo' installs all that it needs.", 1
        )
    except (DemoError, OSError) as error:
        return _fail(str(error), 1)
    return 0 if good else 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m hybrid_dynamics_ros.demo",
        description=_ABOUT,
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--rate", type=_rate, default=1.0, help="how much faster than recorded (default 1)"
    )
    parser.add_argument(
        "--output",
        type=Path,
        default=Path("demo_output"),
        help="folder for the files (default demo_output)",
    )
    parser.add_argument(
        "--no-live", "--quiet", action="store_true", help="show nothing but the summary at the end"
    )
    parser.add_argument(
        "--domain", type=_domain, help="ROS domain to use (default: any that is free)"
    )
    return parser


def _rate(text: str) -> float:
    value = float(text)
    if not (math.isfinite(value) and value > 0.0):
        raise argparse.ArgumentTypeError(f"{text} is not a finite number above 0")
    return value


def _domain(text: str) -> int:
    value = int(text)
    if not 0 <= value <= 232:
        raise argparse.ArgumentTypeError(f"{text} is not a domain, 0 to 232")
    return value


def _fail(text: str, code: int) -> int:
    sys.stderr.write(text + "\n")
    return code
