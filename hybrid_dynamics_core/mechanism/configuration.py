"""Joint values as the closure gives them: cosine and sine of revolute joints, lengths of others."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from ..algebra.scalar import Scalar, Scalars, atan2, cos, rint, sin
from .tree import Tree

TURN = 2.0 * math.pi  # [rad]


class Configuration:
    """Values of the coordinates s, filled in the order of the plan.

    Attributes:
        q: angle [rad] or displacement [m] of each coordinate, None where it is not set.
        c: cosine of each revolute coordinate.
        s: sine of each revolute coordinate.
        charts: chart of each ball or free joint, +1 or -1; +1 each if empty.
    """

    def __init__(self, size: int, charts: Scalars = ()) -> None:
        self.q: list[Scalar] = [None] * size
        self.c: list[Scalar] = [None] * size
        self.s: list[Scalar] = [None] * size
        self.charts = charts

    def copy(self) -> Configuration:
        """An independent copy."""
        other = Configuration(0, self.charts)
        other.q = list(self.q)
        other.c = list(self.c)
        other.s = list(self.s)
        return other

    def with_zeros(self, coordinates: Iterable[int]) -> Configuration:
        """A copy with some coordinates at zero."""
        other = self.copy()
        for k in coordinates:
            other.q[k] = 0.0
            other.c[k] = 1.0
            other.s[k] = 0.0
        return other

    def set_value(self, k: int, q: Scalar, *, revolute: bool) -> None:
        """Set a coordinate from its angle [rad] or displacement [m]."""
        if revolute:
            self.set_angle(k, q)
        else:
            self.set_length(k, q)

    def set_angle(self, k: int, q: Scalar) -> None:
        """Set a revolute coordinate from its angle [rad]."""
        self.q[k] = q
        self.c[k] = cos(q)
        self.s[k] = sin(q)

    def set_length(self, k: int, q: Scalar) -> None:
        """Set a prismatic coordinate [m]."""
        self.q[k] = q

    def set_direction(self, k: int, c: Scalar, s: Scalar, near: Scalar) -> None:
        """Set a revolute coordinate from its cosine and sine.

        Args:
            k: the coordinate.
            c: its cosine.
            s: its sine.
            near: the angle is the one within half a turn of this [rad].
        """
        self.c[k] = c
        self.s[k] = s
        self.q[k] = with_turns(atan2(s, c), near)


def with_turns(angle: Scalar, near: Scalar) -> Scalar:
    """The angle plus the whole turns that bring it within half a turn of `near` [rad]."""
    turns = rint((near - angle) * (1.0 / TURN))
    return angle + turns * TURN


def given_configuration(
    tree: Tree, values: Mapping[int, Scalar], charts: Scalars | None = None
) -> Configuration:
    """A configuration with some coordinates set, over any scalar type.

    Args:
        tree: the spanning tree.
        values: values by coordinate [rad or m].
        charts: charts of ball and free joints, +1 or -1; those of the reference if None.
    """
    configuration = Configuration(len(tree.coordinates), tree.charts if charts is None else charts)
    for body in tree.bodies:
        k = body.coordinate
        if k in values:
            configuration.set_value(k, values[k], revolute=body.type == "revolute")
    return configuration


def configuration_at(
    tree: Tree, s: Iterable[float], charts: Iterable[float] | None = None
) -> Configuration:
    """The configuration of floats with all coordinates s (n_s,) set."""
    values = {k: float(q) for k, q in enumerate(s)}
    if charts is not None:
        charts = tuple(map(float, charts))
    return given_configuration(tree, values, charts)
