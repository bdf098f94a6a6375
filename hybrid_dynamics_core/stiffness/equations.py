"""Equations between joints and deformations: closures, followers, drives and springs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..description.elasticity import Elasticity
from ..description.model import Closure
from ..errors import InputError
from ..ground.arrays import Array
from .attachments import Key
from .drive_springs import drive_compliance
from .held import HELD, Held, held_by
from .places import Places
from .posed_tree import PosedTree
from .robot_interface import ElasticRobot


@dataclass(frozen=True, eq=False)
class Equation:
    """A gap that is zero, or the deformation of a spring.

    Attributes:
        name: name of its element.
        row: (n_s + k,) gap per unit of each joint and of each deformation of a virtual joint.
        deformation: gap per unit of a spring of unit stiffness; 0 for a rigid one.
    """

    name: str
    row: Array
    deformation: float


class HeldClosure(NamedTuple):
    """A closure, and the directions that it holds.

    Attributes:
        closure: the closure.
        held: the directions, in the axes of its pin.
    """

    closure: Closure
    held: Held


def held_closures(posed: PosedTree, elasticity: Elasticity) -> tuple[HeldClosure, ...]:
    """All closures of a robot.

    Args:
        posed: its tree at a state.
        elasticity: what of it is elastic.
    """
    closures: list[HeldClosure] = []
    for closure in posed.description.closures:
        bearing = elasticity.pins.get(closure.name)
        held = held_by(HELD[closure.kind], bearing, posed.length)
        closures.append(HeldClosure(closure, held))
    return tuple(closures)


def equations_of(
    robot: ElasticRobot,
    posed: PosedTree,
    elasticity: Elasticity,
    places: Places,
    closures: Sequence[HeldClosure],
) -> list[Equation]:
    """All equations of a robot with locked drives, those of its closures first.

    Args:
        robot: the robot.
        posed: its tree at a state.
        elasticity: what of it is elastic.
        places: twists of places on its links.
        closures: all closures.

    Raises:
        InputError: a spring cannot be counted.
    """
    equations: list[Equation] = []
    for one in closures:
        equations += _of_closure(posed, one, places)
    drives = _Drives(robot, posed, elasticity, _size(places))
    equations += drives.followers()
    equations += drives.locked()
    equations += drives.springs()
    return equations


def _size(places: Places) -> int:
    """Number of coordinates."""
    first = next(iter(places.values()))
    return int(first.shape[1])


def _of_closure(posed: PosedTree, one: HeldClosure, places: Places) -> list[Equation]:
    closure, held = one
    a = posed.tree.body_index(closure.link_a)
    b = posed.tree.body_index(closure.link_b)
    key: Key = ("closure", closure.name)
    between = places[a, key] - places[b, key]
    gaps = posed.pin_pose(closure).displacements(between)
    equations: list[Equation] = []
    for row, deformation in zip(held.rows @ gaps, held.deformations, strict=True):
        equation = Equation(f"pins.{closure.name}", row, float(deformation))
        equations.append(equation)
    return equations


class _Drives:
    """Equations along joints."""

    def __init__(
        self,
        robot: ElasticRobot,
        posed: PosedTree,
        elasticity: Elasticity,
        size: int,
    ) -> None:
        self.robot = robot
        self.posed = posed
        self.elasticity = elasticity
        self.size = size

    def followers(self) -> list[Equation]:
        """Joints that follow others."""
        equations: list[Equation] = []
        for name, mimic in self.posed.description.mimics.items():
            factors = {name: 1.0}
            for source, multiplier in mimic.multipliers.items():
                factors[source] = factors.get(source, 0.0) - multiplier
            equations.append(self._of_drive(name, factors))
        return equations

    def locked(self) -> list[Equation]:
        """Drives, which are locked behind their springs."""
        transmissions = self.posed.description.transmissions
        equations: list[Equation] = []
        for name in self.robot.all_drives:
            factors: Mapping[str, float] = {name: 1.0}
            if name in transmissions:
                factors = transmissions[name].multipliers
            equations.append(self._of_drive(name, factors))
        return equations

    def springs(self) -> list[Equation]:
        """Springs of the description, which act along joints."""
        turning = self.posed.description.angles_in_rows
        equations: list[Equation] = []
        for name, effect in self.posed.description.effects.items():
            if not effect.stiffness:
                continue
            if effect.stiffness < 0.0 or name in turning:
                raise InputError(
                    f"joint '{name}' has a spring that cannot be counted: its stiffness is"
                    " negative, or it is on a ball or free joint"
                )
            row = self._row({name: 1.0})
            deformation = math.sqrt(1.0 / effect.stiffness)
            equations.append(Equation(f"springs.{name}", row, deformation))
        return equations

    def _of_drive(self, name: str, factors: Mapping[str, float]) -> Equation:
        """An equation along joints, with the deformation of a drive."""
        row = self._row(factors)
        drive = self.elasticity.drive(name)
        if drive is None:
            return Equation(f"drives.{name}", row, 0.0)
        joint = self.posed.description.joints.get(name)
        position = 0.0
        turns = False
        if joint is not None:
            position = self._position(name)
            turns = joint.type == "revolute"
        cylinder = self.posed.description.actuators.get(name)
        compliance = drive_compliance(name, drive, position, cylinder, turns=turns)
        return Equation(f"drives.{name}", row, math.sqrt(compliance))

    def _position(self, joint: str) -> float:
        k = self.robot.coordinates.index(joint)
        return float(self.posed.s[k])

    def _row(self, factors: Mapping[str, float]) -> Array:
        row = np.zeros(self.size)
        for joint, factor in factors.items():
            k = self.robot.coordinates.index(joint)
            row[k] = factor
        return row
