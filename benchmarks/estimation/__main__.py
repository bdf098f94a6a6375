"""Accuracy of weighing, of forces at the tool, and of joint states from IMUs.

python -m benchmarks.estimation [--lifts N] [--forces N] [--states N] [--bounds]
    [--seed S] [--publish]
"""

from __future__ import annotations

import argparse
from pathlib import Path

from benchmarks import publish

from .bounds import CONFIDENT, ERRORS, force_bounds, mass_bound
from .forces import force_table, pushed
from .lifts import FULL_SCALE
from .states import outcomes, states_table
from .weighing import weighed, weighing_table

LIFTS = 200
ROOT = Path(__file__).resolve().parents[2]


def main() -> None:
    """Simulate machines, print the tables, and put them into the docs if asked."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.estimation", description=__doc__)
    parser.add_argument("--lifts", type=int, help="number of machines that weigh; 200 if alone")
    parser.add_argument("--forces", type=int, help="number of machines that feel a force")
    parser.add_argument("--states", type=int, help="number of cycles whose states are estimated")
    parser.add_argument("--bounds", action="store_true", help="what no method can be better than")
    parser.add_argument("--seed", type=int, default=0, help="seed of the first one")
    parser.add_argument("--publish", action="store_true", help="put the tables into the docs")
    arguments = parser.parse_args()
    lifts = arguments.lifts
    if arguments.bounds:
        for errors, links in ERRORS.items():
            mass = mass_bound(arguments.seed, links)
            width = 2.0 * CONFIDENT * mass
            share = 100.0 * width / FULL_SCALE
            print(
                f"masses of links with {errors}: {mass:.1f} kg, {width:.1f} kg ({share:.2f} %) wide"
            )
        lines = force_bounds(arguments.seed)
        _show("bounds", "tool_force.md", lines, arguments.publish)
    elif lifts is None and arguments.forces is None and arguments.states is None:
        lifts = LIFTS
    if lifts:
        lines = weighing_table(weighed(lifts, arguments.seed))
        _show("weighing", "weighing.md", lines, arguments.publish)
    if arguments.forces:
        lines = force_table(pushed(arguments.forces, arguments.seed))
        _show("forces", "tool_force.md", lines, arguments.publish)
    if arguments.states:
        lines = states_table(outcomes(arguments.states, arguments.seed))
        _show("states", "estimation.md", lines, arguments.publish)


def _show(name: str, page: str, lines: list[str], is_published: bool) -> None:
    """Print a table, and put it into a page if asked."""
    print("\n".join(lines))
    if is_published:
        publish.put(ROOT / "docs" / page, name, lines)


if __name__ == "__main__":
    main()
