"""Joint values as the closure gives them: cosine and sine of revolute joints, displacement of prismatic ones."""

from __future__ import annotations

import math

from ..algebra.scalar import Scalar, atan2, cos, sin


class Configuration:
    """Values of the coordinates s, filled in the order of the plan.

    `q[k]` angle [rad] or displacement [m]; `c[k]`, `s[k]` cosine and sine where the joint is
    revolute.
    """

    def __init__(self, size: int) -> None:
        self.q: list[Scalar] = [None] * size
        self.c: list[Scalar] = [None] * size
        self.s: list[Scalar] = [None] * size

    def copy(self) -> Configuration:
        """The same values, to be changed on their own."""
        other = Configuration(0)
        other.q, other.c, other.s = list(self.q), list(self.c), list(self.s)
        return other

    def set_angle(self, k: int, q: Scalar) -> None:
        """A revolute coordinate given as an angle [rad]."""
        self.q[k], self.c[k], self.s[k] = q, cos(q), sin(q)

    def set_length(self, k: int, q: Scalar) -> None:
        """A prismatic coordinate [m]."""
        self.q[k] = q

    def set_direction(self, k: int, c: Scalar, s: Scalar, near: float) -> None:
        """A revolute coordinate given by cosine and sine; the angle is the one within pi of `near` [rad]."""
        self.c[k], self.s[k] = c, s
        cn, sn = math.cos(near), math.sin(near)
        self.q[k] = near + atan2(s * cn - c * sn, c * cn + s * sn) if near else atan2(s, c)
