"""Check of followers that depend on each other: their equations must have one solution."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...algebra.independence import is_regular
from ...ground.arrays import Array
from ..document import Document
from ..model import Mimic, RobotDescription


def check_circles(document: Document, robot: RobotDescription) -> None:
    """Check that followers that depend on each other have one solution.

    Raises:
        DescriptionError: a joint follows itself, or the joints of a circle are not determined.
    """
    sources = _sources(robot.mimics)
    reached = {name: _reached(sources, name) for name in sources}
    for name, others in reached.items():
        circle = [other for other in sources if other in others and name in reached[other]]
        if not circle or circle[0] != name:  # each circle only once
            continue
        if len(circle) > 1 and is_regular(_matrix(robot.mimics, circle)):
            continue
        way = " -> ".join([*circle, name])
        together = ", ".join(circle)
        raise document.error(
            ("joints", name, "mimic"),
            f"'{name}' follows itself ({way}), and what they follow does not determine {together};"
            " let one of them follow nothing, or change a multiplier",
        )


def _sources(mimics: Mapping[str, Mimic]) -> dict[str, list[str]]:
    """By follower: the followers that it depends on."""
    sources: dict[str, list[str]] = {}
    for name, mimic in mimics.items():
        sources[name] = [source for source in mimic.multipliers if source in mimics]
    return sources


def _reached(sources: Mapping[str, list[str]], start: str) -> set[str]:
    """The followers that one depends on, directly or through others."""
    waiting = list(sources[start])
    reached = set(waiting)
    for name in waiting:  # grows during the iteration
        for other in sources[name]:
            if other not in reached:
                reached.add(other)
                waiting.append(other)
    return reached


def _matrix(mimics: Mapping[str, Mimic], circle: list[str]) -> Array:
    """Coefficients (n, n) of the joints of a circle in q_i - sum_j multiplier_ij q_j = constant."""
    matrix = np.eye(len(circle))
    for row, name in enumerate(circle):
        for column, source in enumerate(circle):
            matrix[row, column] -= mimics[name].multipliers.get(source, 0.0)
    return matrix
