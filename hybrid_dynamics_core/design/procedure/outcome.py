"""What a designed robot does in its duty cycle: loops, drives, and what sizes them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...errors import InputError
from ...robot.robot import Robot
from ...sizing import (
    Catalogue,
    CatalogueCylinder,
    Demand,
    DutyCycle,
    Margins,
    Sizing,
    closed_duty,
    demand_of,
    size_drive,
)


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a robot does in its duty cycle.

    Attributes:
        robot: the robot.
        rows: rows of the cycle.
        distances: least distance of each loop to a singularity, 0 to 1, by its name.
        demands: what each drive has to do, by its name.
        sizings: drives of catalogues, by the name of a drive.
    """

    robot: Robot
    rows: int
    distances: Mapping[str, float]
    demands: Mapping[str, Demand]
    sizings: Mapping[str, Sizing]


def outcome_of(
    robot: Robot,
    duty: DutyCycle,
    catalogues: Sequence[Catalogue] = (),
    margins: Margins | None = None,
) -> Outcome:
    """Run a duty cycle, and size the drives.

    Args:
        robot: the robot.
        duty: its duty cycle.
        catalogues: of cylinders for drives that slide, of motors for those that turn.
        margins: what is needed beyond the duty cycle; `Margins()` if None.

    Raises:
        InputError: there are two catalogues of one kind.
        StateError: the robot does not reach a row of the cycle.
    """
    by_kind = _by_kind(catalogues)
    state, _ = closed_duty(robot, duty)
    least = np.min(state.distances, axis=0, initial=1.0)
    distances = dict(zip(robot.loops, least.tolist(), strict=True))
    demands: dict[str, Demand] = {}
    sizings: dict[str, Sizing] = {}
    for drive in robot.drives:
        demands[drive] = demand_of(robot, duty, drive)
        kind = robot.joint_types[drive]
        if kind in by_kind:
            sizings[drive] = size_drive(robot, duty, by_kind[kind], drive, margins)
    return Outcome(robot, len(duty.values), distances, demands, sizings)


def _by_kind(catalogues: Sequence[Catalogue]) -> dict[str, Catalogue]:
    """Catalogues by the type of joints that they drive."""
    by_kind: dict[str, Catalogue] = {}
    for catalogue in catalogues:
        is_of_cylinders = isinstance(catalogue.rows[0], CatalogueCylinder)
        kind = "prismatic" if is_of_cylinders else "revolute"
        if kind in by_kind:
            raise InputError(f"{catalogue.source}: is a second catalogue of this kind of drives")
        by_kind[kind] = catalogue
    return by_kind
