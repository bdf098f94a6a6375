"""Quantities of a design by name, such as `effort.q12.max`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ..errors import InputError
from ..ground.arrays import Array
from ..ground.suggestions import suggestion
from ..robot.parameters import FamilyResult, RobotFamily
from ..robot.robot import Robot

AXES: Final = "xyz"
SUMMARIES: Final[Mapping[str, Callable[[Array], Array]]] = {  # of values (N, P) over P poses
    "min": lambda values: np.asarray(values.min(axis=1)),
    "max": lambda values: np.asarray(values.max(axis=1)),
    "mean": lambda values: np.asarray(values.mean(axis=1)),
    "range": lambda values: np.asarray(np.ptp(values, axis=1)),
}
CALLS: Final = {  # the call of a family that a quantity comes from
    "position": "forward_kinematics",
    "coordinate": "close",
    "singularity": "close",
    "effort": "inverse_dynamics",
    "pin": "reactions",
}


@dataclass(frozen=True)
class Quantity:
    """A quantity of a design.

    Attributes:
        name: its name in tables.
        kind: what it is of: `position`, `coordinate`, `singularity`, `effort` or `pin`.
        index: which one; -1 for the least or largest of all.
        summary: what is taken over several poses; empty for one pose.
    """

    name: str
    kind: str
    index: int
    summary: str = ""

    @property
    def call(self) -> str:
        """The call of a family that gives it."""
        return CALLS[self.kind]

    def at_poses(self, result: FamilyResult) -> Array:
        """Its values (R,) from the result of its call for R rows."""
        if self.kind == "position":
            return result["position"][:, self.index]
        if self.kind == "coordinate":
            return result["s"][:, self.index]
        if self.kind == "effort":
            return result["tau"][:, self.index]
        if self.kind == "pin":
            forces = np.linalg.norm(result["pin_forces"], axis=2)
            return np.asarray(forces[:, self.index])
        distances = result["distances"]
        if self.index < 0:
            return np.asarray(distances.min(axis=1))
        return distances[:, self.index]

    def of_designs(self, result: FamilyResult, poses: int) -> Array:
        """Its values (N,) from the result for N designs at each of their poses."""
        values = self.at_poses(result).reshape(-1, poses)
        if not self.summary:
            return values[:, 0]
        return SUMMARIES[self.summary](values)


def quantities_of(names: Sequence[str], robot: Robot, poses: int) -> list[Quantity]:
    """The quantities of some names.

    Args:
        names: such as `position.x`, `coordinate.q12`, `effort.q12`, `pin.theta_1`, `singularity`,
            `singularity.theta_1`; for several poses with `.min`, `.max`, `.mean` or `.range`.
        robot: the robot.
        poses: number of poses of each design.

    Raises:
        InputError: there is no such quantity, or one is named twice.
    """
    quantities: dict[str, Quantity] = {}
    for name in names:
        if name in quantities:
            raise InputError(f"quantity: '{name}' is named twice")
        quantities[name] = _quantity(name, robot, poses)
    return list(quantities.values())


def _quantity(name: str, robot: Robot, poses: int) -> Quantity:
    body, dot, summary = name.rpartition(".")
    if not dot or summary not in SUMMARIES:
        body, summary = name, ""
    if poses > 1 and not summary:
        listed = ", ".join(f"{name}.{one}" for one in SUMMARIES)
        raise InputError(f"quantity: '{name}' has {poses} values, one a pose; give {listed}")
    kind, _, part = body.partition(".")
    if kind not in CALLS:
        kinds = ", ".join(CALLS)
        hint = suggestion(kind, CALLS)
        raise InputError(f"quantity: there is no '{name}'{hint}; expected one of {kinds}")
    parts = _parts(robot, kind)
    if kind == "singularity" and not part:
        if not parts:
            raise InputError(f"quantity: {robot.name} has no loops, hence no '{name}'")
        return Quantity(name, kind, -1, summary)
    if part not in parts:
        listed = ", ".join(parts) or "none"
        hint = suggestion(part, parts)
        raise InputError(f"quantity: '{name}': there is no '{part}'{hint}; there are {listed}")
    return Quantity(name, kind, parts.index(part), summary)


def _parts(robot: Robot, kind: str) -> tuple[str, ...]:
    """Names of what a kind of quantity is of."""
    if kind == "position":
        return tuple(AXES)
    if kind == "coordinate":
        return robot.coordinates
    if kind == "effort":
        return robot.active
    if kind == "pin":
        return tuple(closure.name for closure in robot.description.closures)
    return tuple(robot.loops)


def results_of(
    family: RobotFamily, calls: Sequence[str], u: Array, parameters: Array, frame: str | None
) -> dict[str, FamilyResult]:
    """Results of some calls, for rows of active coordinates and of parameters."""
    results: dict[str, FamilyResult] = {}
    for call in calls:
        if call == "forward_kinematics":
            result = family.forward_kinematics(u, parameters, frame, derivatives=False)
        else:
            result = getattr(family, call)(u, parameters, derivatives=False)
        results[call] = result
    return results
