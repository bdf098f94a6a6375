"""The closure of the forging robot by hand, as a user of another engine would write it.

Angles come from triangles. Lengths have the names of Chu et al. (2020), Table 1. The order of s is
q1 q12 q22 q4 | q2 q3 q11 q21 q31 q32 q41 q42.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

L1, L11, L2, L21, B2, B3, C2 = 0.7, 0.4, 0.7, 0.4, 0.3, 0.2, 0.2
ARM, FORE = L2 - B2, L2 - C2  # shoulder to the pin of cylinder 1; pivot of cylinder 2 to the elbow
COORDINATES = ("q1", "q12", "q22", "q4", "q2", "q3", "q11", "q21", "q31", "q32", "q41", "q42")


class Triangle(NamedTuple):
    """An angle that a cylinder sets, and the cylinder's own, with derivatives by its length.

    Attributes:
        angle: that the cylinder sets [rad].
        tilt: of the cylinder [rad].
        angle1, tilt1: first derivatives [rad/m].
        angle2, tilt2: second derivatives [rad/m^2].
    """

    angle: float
    tilt: float
    angle1: float
    tilt1: float
    angle2: float
    tilt2: float


def crank(base: float, arm: float, length: float) -> Triangle:
    """A triangle of base, arm and cylinder [m].

    The angle runs from the base's extension to the arm, counterclockwise.
    length^2 = base^2 + arm^2 + 2 base arm cos(angle); tilt = atan2(arm sin, base + arm cos).
    """
    c = (length * length - base * base - arm * arm) / (2.0 * base * arm)
    s = math.sqrt(1.0 - c * c)
    k = base * arm
    angle1 = -length / (k * s)
    angle2 = -(1.0 + k * c * angle1 * angle1) / (k * s)
    along = arm * (arm + base * c) / (length * length)  # d tilt / d angle
    curvature = -arm * base * s - 2.0 * length * along / angle1
    bend = curvature / (length * length)  # d2 tilt / d angle2
    tilt1 = along * angle1
    tilt2 = bend * angle1 * angle1 + along * angle2
    angle = math.acos(c)
    tilt = math.atan2(arm * s, base + arm * c)
    return Triangle(angle, tilt, angle1, tilt1, angle2, tilt2)


def positions(u: Sequence[float], t1: Triangle, t2: Triangle) -> list[float]:
    """s from the actuators and both triangles."""
    q1, q12, q22, q4 = u
    q2, q3 = t1.angle, t2.angle - math.pi
    return [
        q1,
        q12,
        q22,
        q4,
        q2,
        q3,
        t1.tilt,
        t2.tilt,
        q2,
        math.pi / 2 - q2,
        q2 + q3 + math.pi / 2,
        -q2 - q3,
    ]


def linear(v: Sequence[float], t1: Triangle, t2: Triangle) -> list[float]:
    """R v: all rates from those of the actuators."""
    v1, v12, v22, v4 = v
    w2, w3 = t1.angle1 * v12, t2.angle1 * v22
    return [v1, v12, v22, v4, w2, w3, t1.tilt1 * v12, t2.tilt1 * v22, w2, -w2, w2 + w3, -w2 - w3]


def quadratic(v: Sequence[float], t1: Triangle, t2: Triangle) -> list[float]:
    """R' v: all accelerations with the actuators' zero."""
    _, v12, v22, _ = v
    b2, b3 = t1.angle2 * v12 * v12, t2.angle2 * v22 * v22
    return [
        0.0,
        0.0,
        0.0,
        0.0,
        b2,
        b3,
        t1.tilt2 * v12 * v12,
        t2.tilt2 * v22 * v22,
        b2,
        -b2,
        b2 + b3,
        -b2 - b3,
    ]


def projected(f: list[float], t1: Triangle, t2: Triangle) -> list[float]:
    """R^T f: from forces along s to those of the actuators."""
    upper = f[4] + f[8] - f[9] + f[10] - f[11]  # what turns with q2
    fore = f[5] + f[10] - f[11]  # and with q3
    return [
        f[0],
        f[1] + t1.angle1 * upper + t1.tilt1 * f[6],
        f[2] + t2.angle1 * fore + t2.tilt1 * f[7],
        f[3],
    ]


def triangles(u: Sequence[float]) -> tuple[Triangle, Triangle]:
    """The triangles of both cylinders."""
    return crank(L1, ARM, L11 + u[1]), crank(FORE, B3, L21 + u[2])
