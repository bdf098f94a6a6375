"""A generated robot ready for tests.

Its active joints determine the others. An independent oracle comes with it.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.description import RobotDescription
from tests.generated.assembly import Assembly
from tests.generated.space import Space

INDEPENDENT = 0.12  # share of a column that must remain beside the columns chosen before it
WELL = 0.02  # smallest singular value of the passive Jacobian at the reference [m or rad]


class Case:
    """A robot with its oracle; `n` is its number of active joints."""

    def __init__(self, label: str, description: RobotDescription) -> None:
        self.label = label
        self.description = description

    def __repr__(self) -> str:
        return self.label

    @cached_property
    def robot(self) -> Robot:
        """The library's robot."""
        return Robot(self.description)

    @cached_property
    def space(self) -> Space:
        """The oracle, in the robot's order of coordinates."""
        return Space(self.description, self.robot.coordinates)

    @cached_property
    def n(self) -> int:
        """Number of active joints."""
        return len(self.description.active)

    @cached_property
    def start(self) -> np.ndarray:
        """All coordinates at the reference (n_s,), closed by construction."""
        return np.array([self.description.reference[name] for name in self.robot.coordinates])

    def somewhere(self, seed: int, size: float = 0.6, floor: float = 0.5) -> np.ndarray:
        """A closed configuration (n_s,) reached smoothly from the reference, by the oracle.

        size: length of the straight way of the active joints; it ends early where the margin of the
        passive Jacobian has fallen to the share `floor` of what it is at the reference.
        """
        rng = np.random.default_rng(seed)
        way = rng.normal(size=self.n)
        way *= size * rng.uniform() / max(float(np.linalg.norm(way)), 1e-9)
        active = range(self.n)
        least = floor * self.space.margin(self.start, active)
        # no coordinate goes as far as half a turn
        _, s = self.space.follow(self.start, active, way, least, far=2.5)
        return s

    def rates(self, seed: int) -> np.ndarray:
        """Active rates or accelerations (n,)."""
        return np.random.default_rng(seed + 7).uniform(-1.0, 1.0, size=self.n)


def complete(a: Assembly, tool: str, label: str, choices: int) -> Case | None:
    """Choose active joints at random among the sets that determine the others well.

    None if there is none. choices: seed of the choice.
    """
    rng = np.random.default_rng(choices)
    names = list(a.joints)
    space = Space(a.description(tuple(names), tool), names)
    s = np.array([a.reference[name] for name in names])
    if a.closures and space.gap(s) > 1e-12:
        raise AssertionError("loops close by construction")
    jacobian = space.equations(s)[1]
    preferred = [name for name in names if name in a.preferred]
    others = [name for name in names if name not in preferred]
    order = [names.index(str(name)) for name in rng.permutation(others)]
    if preferred:
        order += [names.index(str(name)) for name in rng.permutation(preferred)]
    passive = independent_columns(jacobian, order)
    if len(passive) != a.rank or np.linalg.matrix_rank(jacobian, tol=1e-6) != a.rank:
        return None
    active = [k for k in range(len(names)) if k not in passive]
    if not active or space.margin(s, active) < WELL:
        return None
    chosen = tuple(str(n) for n in rng.permutation([names[k] for k in active]))
    return Case(label, a.description(chosen, tool))


def independent_columns(jacobian: np.ndarray, order: list[int]) -> list[int]:
    """Columns in order, each chosen if enough of it remains beside those before (Gram-Schmidt)."""
    chosen: list[int] = []
    basis = np.zeros((len(jacobian), 0))
    for k in order:
        column = jacobian[:, k]
        remainder = column - basis @ (basis.T @ column)
        remainder -= basis @ (basis.T @ remainder)
        size = np.linalg.norm(remainder)
        if size > INDEPENDENT * max(np.linalg.norm(column), 0.3):
            chosen.append(k)
            basis = np.column_stack([basis, remainder / size])
    return chosen
