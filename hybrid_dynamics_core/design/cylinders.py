"""Cylinders of a design: bores for the forces of a duty cycle."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from ..closed_state.state import ClosedState
from ..dynamics.loads import Loads
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.suggestions import no_such_name
from ..robot.robot import Robot

# ISO 3320, bores of cylinders [m]
BORES = tuple(
    0.001 * bore
    for bore in (25, 32, 40, 50, 63, 80, 90, 100, 110, 125, 140, 160, 180, 200, 220, 250, 280, 320)
)


@dataclass(frozen=True)
class Bore:
    """The bore of a cylinder for a duty cycle.

    Attributes:
        needed: least bore [m], with the rod's diameter in its present proportion.
        bore: the next one of a series [m].
        rod: diameter of the rod [m], in the same proportion.
        push: largest force [N] that one cylinder pushes with.
        pull: largest force [N] that it pulls with.
        pressure: largest pressure with the bore of the series [Pa].
    """

    needed: float
    bore: float
    rod: float
    push: float
    pull: float
    pressure: float


def size_bores(
    robot: Robot,
    duty: Iterable[tuple[ClosedState, Loads | None]],
    pressure: Mapping[str, float],
    series: Iterable[float] = BORES,
) -> Mapping[str, Bore]:
    """The bores with which cylinders hold a duty cycle, such as a lifting chart, at rest.

    Args:
        robot: the robot with cylinders.
        duty: closed states with their loads; None for the loads of the description.
        pressure: pressure that each cylinder may take [Pa], by joint.
        series: bores to choose from [m].

    Returns:
        The bores by joint.

    Raises:
        InputError: a joint has no cylinder, or the series ends below the bore that is needed.
    """
    forces: dict[str, list[float]] = {name: [] for name in pressure}
    for name in pressure:
        if name not in robot.cylinders:
            raise InputError(no_such_name("cylinder", name, robot.cylinders))
    for state, loads in duty:
        tau = robot.inverse_dynamics(state, np.zeros(len(robot.active)), loads or robot.loads)
        along = robot.drive_forces(state, tau)
        for name, values in forces.items():
            push = robot.cylinders[name].sign * along[name]
            values.append(float(push))
    sized = {
        name: _sized(robot, name, np.array(f), pressure[name], series) for name, f in forces.items()
    }
    return MappingProxyType(sized)


def _sized(
    robot: Robot, name: str, forces: Array, pressure: float, series: Iterable[float]
) -> Bore:
    cylinder = robot.cylinders[name]
    share = cylinder.rod / cylinder.bore
    ring = 1.0 - share * share  # area around the rod over that of the bore
    push = float(max(forces.max(initial=0.0), 0.0)) / cylinder.count
    pull = float(max((-forces).max(initial=0.0), 0.0)) / cylinder.count
    area = max(push, pull / ring) / pressure
    needed = float(np.sqrt(4.0 * area / np.pi))
    bore = min((bore for bore in series if bore >= needed), default=None)
    if bore is None:
        raise InputError(f"{name} needs a bore of {needed:.3g} m, above all of the series")
    chosen = np.pi / 4.0 * bore * bore
    largest = max(push, pull / ring) / chosen
    return Bore(needed, bore, share * bore, push, pull, float(largest))
