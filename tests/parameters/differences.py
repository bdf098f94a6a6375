"""A family of robots against robots that are built again, and against differences."""

from __future__ import annotations

import numpy as np

from hybrid_dynamics_core import InputError, Robot
from hybrid_dynamics_core.closure.closed_motion import ClosedMotion
from hybrid_dynamics_core.description.parameters import parameter_paths
from hybrid_dynamics_core.robot.parameters import FamilyResult, RobotFamily

STEP = 1e-5  # of central differences [m, rad, kg]
GEOMETRY = ("xyz", "rpy", "offset", "pin", "between", "parameters", "rows", "mass", "com")


def free_at_random(robot: Robot, rng: np.random.Generator, count: int = 3) -> RobotFamily | None:
    """A family in some numbers of the description that may be free; None if none of them may."""
    names = []
    for name in parameter_paths(robot.description):
        parts = name.replace("[", ".").split(".")
        if parts[0] != "reference" and (len(parts) == 1 or set(parts) & set(GEOMETRY)):
            names.append(name)
    chosen = []
    for name in rng.permutation(names)[: 2 * count]:
        try:
            robot.free(name)
        except InputError:
            continue
        chosen.append(name)
    return robot.free(*chosen[:count]) if chosen else None


def closed(robot: Robot, u: np.ndarray, guess: np.ndarray) -> tuple[np.ndarray, ...]:
    """All coordinates, R and the distances of the loops, computed on floats."""
    model = robot._model.program_model
    motion = ClosedMotion(model.tree, model.plan, list(u), model.plan.signs, list(guess))
    distances = np.array(motion.distances(), dtype=float)
    arrays = [np.array(motion.configuration.q), np.array(motion.velocity_map())]
    return (*(array.astype(float) for array in arrays), robot.loop_distances(distances))


def around(family: RobotFamily) -> np.ndarray:
    """Parameters (2 k, k) a step above and below each value."""
    steps = STEP * np.eye(len(family.names))
    return np.concatenate([family.values + steps, family.values - steps])


def slope(values: np.ndarray) -> np.ndarray:
    """Central differences (..., k) of results (2 k, ...) at `around`."""
    above, below = np.split(values, 2)
    return np.moveaxis((above - below) / (2.0 * STEP), 0, -1)


def assert_slopes(result: FamilyResult, nearby: FamilyResult) -> None:
    """The derivatives by the parameters are the central differences, up to their error."""
    for name, derivative in result.by_parameters.items():
        expected = slope(nearby[name])
        size = 1.0 + np.abs(expected).max(initial=0.0)
        assert np.allclose(derivative, expected, rtol=0.0, atol=1e-6 * size), name
