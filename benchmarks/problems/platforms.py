"""Platforms on legs: all poses at given lengths of the legs, certified."""

from __future__ import annotations

import statistics
import time
from typing import NamedTuple

from benchmarks.table import time_text
from hybrid_dynamics_core import load

from .catalogue import ROBOTS

ROUNDS = 5


class Platform(NamedTuple):
    """A platform of `robots/`, and how many real poses are known."""

    name: str
    title: str
    known: int
    source: str


PLATFORMS = (
    Platform("three_legs", "3-RPR, planar", 6, "roots of an equation by hand"),
    Platform("dietmaier", "Gough platform of Dietmaier", 40, "published"),
)


def lines() -> list[str]:
    """One line a platform: poses found, whether that is proved to be all, and the CPU time."""
    table = [
        "| platform | poses known | found | proved to be all | time |",
        "|---|---:|---:|---|---:|",
    ]
    for platform in PLATFORMS:
        robot = load(ROBOTS / f"{platform.name}.yaml")
        modes = robot.assembly_modes(robot.reference)  # compiles
        seconds = []
        for _ in range(ROUNDS):
            begin = time.process_time()
            modes = robot.assembly_modes(robot.reference)
            seconds.append(time.process_time() - begin)
        proved = {True: "yes", False: "no"}[modes.complete]
        spent = time_text(statistics.median(seconds))
        known = f"{platform.known}, {platform.source}"
        table.append(f"| {platform.title} | {known} | {len(modes)} | {proved} | {spent} |")
    return table
