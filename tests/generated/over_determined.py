"""Random loops with more equations than they need, which move all the same."""

from __future__ import annotations

import numpy as np

from hybrid_dynamics_core.description import RobotDescription
from tests.generated.assembly import BASE, Assembly, unit

KINDS = ("axis", "frame", "parallel axis", "parallel frame")


def over_determined(kind: str, seed: int) -> RobotDescription:
    """A four-bar linkage of four hinges in space, active in the first one.

    Its axes meet in one point, which makes it spherical, or are parallel. It is cut at its third
    hinge ('axis'), or through the link behind it ('frame').
    """
    a = Assembly(np.random.default_rng(seed))
    centre = a.rng.normal(size=3)
    axes = [unit(a.rng.normal(size=3)) for _ in range(4)]
    points = [centre + a.rng.normal() * axis for axis in axes]
    if kind.startswith("parallel"):
        axes = [axes[0]] * 4
        points = [a.rng.normal(size=3) for _ in range(4)]
    one = a.hang(BASE, "revolute", axes[0], points[0], name="l1")
    two = a.hang(one, "revolute", axes[1], points[1], name="l2")
    four = a.hang(BASE, "revolute", axes[3], points[3], name="l4")
    if kind.endswith("axis"):
        a.tie(two, four, points[2], "axis", axes[2], name="cut")
    else:
        three = a.hang(four, "revolute", axes[2], points[2], name="l3")
        a.tie(two, three, a.rng.normal(size=3), "frame", name="cut")
    return a.description(("q_l1",), two)
