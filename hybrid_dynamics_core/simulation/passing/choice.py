"""Which coordinates a motion is integrated in near singular places."""

from __future__ import annotations

import numpy as np

from ...closed_state.passages.crossing import PassageKind
from ...closed_state.state import ClosedState, ClosureStatus
from ...dynamics.loads import Loads
from ...errors import DescriptionError, InputError, StateError
from ...ground.arrays import Array
from ...robot.robot import Robot
from .across import AcrossPlace
from .coordinates import Coordinates
from .other import OtherCoordinates

ENTER = 0.1  # distance to a singularity at which other coordinates are tried
ACROSS = (0.05, 0.02, 0.01)  # distances at which a change point ahead is searched
LEAVE = 0.2  # distance at which those of the robot are taken again
BETTER = 2.0  # gain of distance by other coordinates for which they are taken
AHEAD = 0.3  # [rad or m] how far ahead a change point is searched, in the fastest coordinate
ROUNDING = 1e-6  # of a level: an event is found just before it


class CoordinateChoice:
    """The coordinates of one simulation through change points.

    Args:
        robot: the robot that is simulated.
        loads: loads besides the actuators; those of the description if None.
        singular: distance to a singularity at which the motion ends, or passes a change point.
    """

    def __init__(
        self,
        robot: Robot,
        loads: Loads | None,
        singular: float,
    ) -> None:
        self._robot = robot
        self._loads = loads
        self._singular = singular
        self._others: dict[tuple[str, ...], Robot | None] = {}
        self._levels: list[float] = []  # at which nothing was found, on the present approach

    def level(self, coordinates: Coordinates) -> float:
        """Distance to a singularity at which the choice has to be made again."""
        if isinstance(coordinates, AcrossPlace):
            return -1.0
        levels = [level for level in ACROSS if level not in self._levels]
        if not isinstance(coordinates, OtherCoordinates) and ENTER not in self._levels:
            levels.append(ENTER)
        return max([*levels, self._singular])

    def following(self, coordinates: Coordinates) -> Coordinates | None:
        """The coordinates after an accepted step; None if they stay."""
        state = coordinates.anchor
        if isinstance(coordinates, AcrossPlace):
            return self._beyond(coordinates, state)
        distance = float(state.singularity)
        if distance > LEAVE:
            self._levels.clear()
        changed: Coordinates | None = None
        if isinstance(coordinates, OtherCoordinates):
            changed = self._back(coordinates, state)
        elif self._is_due(ENTER, distance):
            changed = self._other(state)
        for level in ACROSS:
            if changed is None and self._is_due(level, distance):
                changed = self._across(coordinates, state)
        return changed

    def _is_due(
        self,
        level: float,
        distance: float,
    ) -> bool:
        """Whether a level is reached for the first time on this approach; it is noted."""
        if level in self._levels or distance > level * (1.0 + ROUNDING):
            return False
        self._levels.append(level)
        return True

    def _beyond(
        self,
        across: AcrossPlace,
        state: ClosedState,
    ) -> Coordinates | None:
        if across.is_inside(state.u):
            return None
        across.base.move_to(across.leave(state))
        self._levels = [ENTER, *ACROSS]  # it goes away from the place
        return across.base

    def _back(
        self,
        other: OtherCoordinates,
        state: ClosedState,
    ) -> Coordinates | None:
        """The coordinates of the robot, where they are regular again."""
        simulated = other.simulated_state(state)
        if simulated.status is not ClosureStatus.OK or simulated.singularity < LEAVE:
            return None
        closed = self._robot.singular_places.state_of(simulated.s, simulated.ds)
        return Coordinates(self._robot, closed, self._loads)

    def _other(self, state: ClosedState) -> Coordinates | None:
        """Other coordinates, where they are better than those of the robot."""
        names = self._robot.better_coordinates(state)
        robot = None if names is None else self._robot_in(names, state)
        closed = None if robot is None else self._state_in(robot, state)
        if robot is None or closed is None:
            return None
        if float(closed.singularity) < BETTER * float(state.singularity):
            return None
        self._levels.clear()
        return OtherCoordinates(self._robot, robot, closed, self._loads)

    def _state_in(
        self,
        robot: Robot,
        state: ClosedState,
    ) -> ClosedState | None:
        """A state in the coordinates of another robot; None if it is singular there too."""
        s, ds = self._ordered(robot, state.s), self._ordered(robot, state.ds)
        try:
            return robot.singular_places.state_of(s, ds)
        except StateError:
            return None

    def _ordered(
        self,
        robot: Robot,
        values: Array,
    ) -> Array:
        """Values of all coordinates (n_s,), in the order of another robot."""
        return values[[self._robot.coordinates.index(name) for name in robot.coordinates]]

    def _robot_in(
        self,
        names: tuple[str, ...],
        state: ClosedState,
    ) -> Robot | None:
        """The mechanism with other active coordinates; None if they do not determine it."""
        if names not in self._others:
            try:
                self._others[names] = self._robot.with_active(names, state)
            except DescriptionError:
                self._others[names] = None
        return self._others[names]

    def _across(
        self,
        coordinates: Coordinates,
        state: ClosedState,
    ) -> Coordinates | None:
        """The way across a change point ahead; None if there is none."""
        fastest = float(np.abs(state.ds).max())
        if not fastest:
            return None
        way = state.du * (AHEAD / fastest)
        crossing = coordinates.robot.singular_places.crossing_ahead(state, way)
        if crossing is None or crossing.kind is not PassageKind.CHANGE_POINT:
            return None
        across = AcrossPlace(coordinates, crossing)
        return across if across.is_inside(state.u) else None


def require_fixed_charts(robot: Robot) -> None:
    """Raise InputError for robots whose angles change their chart on the way."""
    if robot.middle_turns:
        raise InputError(
            "through_change_points: this robot has ball or free joints, whose angles change their"
            " chart on the way; expected a robot without them"
        )
