"""The smallest drive of a catalogue that meets a duty cycle."""

from __future__ import annotations

from dataclasses import dataclass

from ..description.actuators import HydraulicCylinder
from ..errors import InputError
from ..robot.robot import Robot
from .catalogue import Catalogue, CatalogueMotor
from .checks import Candidate, Margins
from .cylinders import cylinder_checks
from .demand import Demand, demand_of
from .duty import DutyCycle
from .motors import motor_checks


@dataclass(frozen=True, eq=False)
class Sizing:
    """The drives of a catalogue in a duty cycle.

    Attributes:
        demand: what the drive has to do.
        margins: what is needed beyond that.
        candidates: all drives of the catalogue, the smallest first.
    """

    demand: Demand
    margins: Margins
    candidates: tuple[Candidate, ...]

    @property
    def chosen(self) -> Candidate | None:
        """The smallest one that fits; None if none does."""
        return next((one for one in self.candidates if one.fits), None)


def size_drive(
    robot: Robot,
    duty: DutyCycle,
    catalogue: Catalogue,
    drive: str,
    margins: Margins | None = None,
) -> Sizing:
    """The smallest drive of a catalogue that meets a duty cycle.

    The masses of the robot stay those of its description. The inertia of a motor counts.

    Args:
        robot: the robot.
        duty: its duty cycle.
        catalogue: cylinders or motors.
        drive: name of one of `robot.drives`.
        margins: what is needed beyond the duty cycle; `Margins()` if None.

    Raises:
        InputError: there is no such drive, or cylinders are to drive a joint that turns.
        StateError: the robot does not reach a row of the cycle.
    """
    margins = margins or Margins()
    demand = demand_of(robot, duty, drive)
    candidates: list[Candidate] = []
    for row in catalogue.rows:
        if isinstance(row, CatalogueMotor):
            candidates.append(motor_checks(row, demand, margins))
            continue
        if demand.kind == "revolute":
            raise InputError(f"{catalogue.source}: has cylinders, and {drive} is a revolute joint")
        mounted = robot.cylinders.get(drive) or HydraulicCylinder(drive, row.bore, row.rod)
        candidates.append(cylinder_checks(row, demand, mounted, margins))
    return Sizing(demand, margins, tuple(candidates))
