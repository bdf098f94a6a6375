"""Random tables of tolerances for any robot."""

from __future__ import annotations

import numpy as np

from hybrid_dynamics_core import InputError, Robot
from hybrid_dynamics_core.description.parameters import parameter_paths
from hybrid_dynamics_core.tolerances import ToleranceAnalysis

GEOMETRY = ("xyz", "rpy", "pin", "between", "parameters")


def random_table(robot: Robot, rng: np.random.Generator, count: int = 4) -> dict[str, float]:
    """Tolerances of some numbers, and plays of some pins, that this robot may have."""
    names: list[str] = []
    for name in parameter_paths(robot.description):
        keys = name.replace("[", ".").split(".")
        if keys[0] != "reference" and (len(keys) == 1 or set(keys) & set(GEOMETRY)):
            names.append(name)
    pins = [f"joints.{joint}.play" for joint in robot.description.joints]
    pins += [f"closures.{closure.name}.play" for closure in robot.description.closures]
    table: dict[str, float] = {}
    for name in (*rng.permutation(names)[:count], *rng.permutation(pins)[:2]):
        try:
            ToleranceAnalysis(robot, {name: 1e-4}).linear(robot.reference)
        except InputError:  # turns an axis out of the plane of its loop, for example
            continue
        table[str(name)] = float(rng.uniform(0.2, 1.0)) * 1e-4
    return table
