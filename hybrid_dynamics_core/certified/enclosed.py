"""Configurations in intervals, and their parts as arrays."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from ..algebra.vector import Vector
from ..mechanism.configuration import Configuration
from ..mechanism.tree import Tree
from .complex_ball import Ball
from .interval import Interval, enclosing
from .rounding import bound

SOLVED = 1e-12  # [rad or m] uncertainty of coordinates that other blocks have solved


def enclosed(
    tree: Tree,
    configuration: Configuration,
    given: Sequence[int],
) -> Configuration:
    """The configuration in intervals: given values are points, solved ones have an uncertainty."""
    result = Configuration(len(configuration.q), configuration.charts)
    for k, value in enumerate(configuration.q):
        if value is None:
            continue
        uncertainty = SOLVED
        if k in given:
            uncertainty = 0.0
        interval = Interval(float(value) - uncertainty, float(value) + uncertainty)
        result.set_value(k, interval, revolute=tree.is_revolute(k))
    return result


def joined(scalars: Iterable[Interval | float]) -> Interval:
    """Scalars as one interval of arrays."""
    parts = [enclosing(x) for x in scalars]
    return Interval(
        [float(x.lower) for x in parts],
        [float(x.upper) for x in parts],
    )


def stacked(vectors: Sequence[Interval]) -> Interval:
    """Vectors as the rows of one interval."""
    return Interval(
        [x.lower for x in vectors],
        [x.upper for x in vectors],
    )


def in_plane(vectors: Sequence[Vector]) -> Ball:
    """Vectors (2,) of the plane as complex numbers (1, n)."""
    x = joined(vector[0] for vector in vectors)
    y = joined(vector[1] for vector in vectors)
    middle = x.middle + 1j * y.middle
    return Ball(
        middle[None],
        bound(x.radius + y.radius)[None],
    )


def on_axis(values: Sequence[Interval | float]) -> Ball:
    """Real scalars as complex numbers (1, n)."""
    x = joined(values)
    return Ball(
        x.middle[None].astype(complex),
        np.asarray(x.radius)[None],
    )
