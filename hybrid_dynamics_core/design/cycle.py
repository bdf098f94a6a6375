"""What a robot does in its duty cycle at some values of the design's variables."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..description.effects import Payload
from ..dynamics.loads import Loads
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.lazy import lazy
from ..ground.suggestions import no_such_name
from ..programs.live import PARAMETERS
from ..robot.parameters import FamilyResult, RobotFamily
from ..robot.robot import Robot
from .quantity import Quantity, determinant, solved

_BY = (PARAMETERS,)
AXES = ("x", "y", "z")
_STEP = 1e-6  # relative, of a mass: it is a polynomial of low degree


@dataclass(frozen=True, eq=False)
class Duty:
    """One point of a duty cycle.

    Attributes:
        at: coordinates by name [rad or m]; others are at the reference.
        rates: rates by name; others are zero.
        accelerations: accelerations by name; others are zero.
        loads: what acts; None for the loads of the description.
        weight: how much the point counts.
    """

    at: Mapping[str, float]
    rates: Mapping[str, float] = field(default_factory=dict)
    accelerations: Mapping[str, float] = field(default_factory=dict)
    loads: Loads | None = None
    weight: float = 1.0


class Cycle:
    """Results along a duty cycle, each with its derivatives by the variables.

    Attributes:
        weights: weight of each duty point (points,).
    """

    def __init__(
        self,
        family: RobotFamily,
        duty: Sequence[Duty],
        reference: Mapping[str, float],
        robot: Robot,
        parameters: Array,
        driven: RobotFamily | None = None,
    ) -> None:
        """Store the arguments; what is asked for is computed then.

        Args:
            family: the robot with the variables as parameters.
            duty: points of the cycle.
            reference: coordinates where a point names none.
            robot: the robot that the design starts from.
            parameters: values of the variables (k,).
            driven: the same family in active coordinates, where points name others.
        """
        self._family = family
        self._driven = driven or family
        self._duty = tuple(duty)
        self._robot = robot
        self._active = robot.active
        self._parameters = parameters
        names = family.coordinates
        self._u = np.zeros((len(duty), len(names)))
        self._du = np.zeros_like(self._u)
        self._ddu = np.zeros_like(self._u)
        self.weights = np.ones(len(duty))
        for k, point in enumerate(duty):
            self.weights[k] = point.weight
            for j, name in enumerate(names):
                self._u[k, j] = point.at.get(name, reference[name])
                self._du[k, j] = point.rates.get(name, 0.0)
                self._ddu[k, j] = point.accelerations.get(name, 0.0)

    @property
    def closes(self) -> bool:
        """Whether the loops close at every point."""
        return not self._closed.status.any()

    def variable(self, name: str) -> Quantity:
        """A variable."""
        if name not in self._family.names:
            raise InputError(no_such_name("variable", name, self._family.names))
        k = self._family.names.index(name)
        slope = np.zeros(len(self._parameters))
        slope[k] = 1.0
        return Quantity(self._parameters[k], slope)

    def coordinate(self, name: str) -> Quantity:
        """A coordinate at each point (points,) [rad or m]: a stroke, for example."""
        return _result(self._closed, "s")[:, self._index(name)]

    def distance(self) -> Quantity:
        """Distance of each loop to a singularity, as the drives close it (points, loops)."""
        u = self._active_places
        result = self._driven.close(u.value, self._parameters)
        return _along(result, "distances", u)

    def pin_force(self, name: str) -> Quantity:
        """Force in the cut pin of a loop or closure (points,) [N].

        Raises:
            InputError: there is no such pin, or points that name other than the active coordinates
                move.
        """
        pins = [closure.name for closure in self._robot.description.closures]
        if name not in pins:
            raise InputError(no_such_name("pin", name, pins))
        is_active = self._active == self._family.coordinates
        if not is_active and (self._du.any() or self._ddu.any()):
            raise InputError(
                f"forces in the pin {name} are of points at rest, or of points that name the active"
                f" coordinates: {', '.join(self._active)}"
            )
        u = self._active_places
        forces = Quantity(
            np.zeros((len(self._u), 3)), np.zeros((len(self._u), 3, u.slope.shape[-1]))
        )
        for loads, rows in self._rows_by_loads():
            moving = (self._du[rows], self._ddu[rows])
            result = self._driven.reactions(u.value[rows], self._parameters, *moving, loads)
            along = _along(result, "pin_forces", u[rows])[:, pins.index(name)]
            forces.value[rows] = along.value
            forces.slope[rows] = along.slope
        return (forces * forces).over(1).sqrt()

    def lifted(self, name: str) -> Quantity:
        """Mass that the limits of a drive leave room for at the end effector (points,) [kg].

        It is beyond the loads of each point, moves with it, and has its centre in the frame's
        origin. It is negative where the drive is beyond its limits without it.

        Raises:
            InputError: the drive has no limits on both sides.
        """
        effort = self.effort(name)
        lower, upper = self._robot.effort_ranges[name]
        if math.isinf(lower) or math.isinf(upper):
            raise InputError(f"{name} has no limits of its effort on both sides")
        more = self._efforts_with(Payload(1.0))[:, self._active.index(name)]
        slope = more - effort  # of the effort by the mass
        limit = np.where(slope.value > 0.0, upper, lower)
        return (effort - limit) / (-slope)

    def position(self, frame: str | None = None) -> Quantity:
        """Place of a frame (points, 3) [m]; of the end effector if None."""
        result = self._family.forward_kinematics(self._u, self._parameters, frame, _BY)
        return _result(result, "position")

    def jacobian(self, frame: str | None = None) -> Quantity:
        """Jacobian of a frame by the coordinates that the points name (points, 6, n).

        Linear rows come first; base axes. The frame is the end effector if None.
        """
        return _result(self._family.jacobian(self._u, self._parameters, frame, _BY), "jacobian")

    def manipulability(
        self,
        by: Sequence[str] | None = None,
        axes: Sequence[str] = AXES,
        frame: str | None = None,
    ) -> Quantity:
        """How much the place of a frame moves for motions of some coordinates (points,).

        It is sqrt(det(J J^T)) or sqrt(det(J^T J)), whichever is not zero by its shape; Yoshikawa,
        Manipulability of robotic mechanisms (1985).

        Args:
            by: coordinates that move, of those that the points name; all if None.
            axes: directions that count, of x, y and z in base axes.
            frame: the end effector if None.

        Raises:
            InputError: there is no such coordinate or direction.
        """
        names = self._family.coordinates
        columns = [_place("given coordinate", name, names) for name in by or names]
        rows = [_place("direction", axis, AXES) for axis in axes]
        part = self.jacobian(frame)[:, rows][:, :, columns]
        if len(rows) > len(columns):
            part = Quantity(np.swapaxes(part.value, 1, 2), np.swapaxes(part.slope, 1, 2))
        value = part.value @ np.swapaxes(part.value, 1, 2)
        half = np.einsum("nijk,nlj->nilk", part.slope, part.value)
        return determinant(Quantity(value, half + np.swapaxes(half, 1, 2))).sqrt()

    def effort(self, name: str) -> Quantity:
        """Effort of an active joint (points,) [N m or N]."""
        if name not in self._active:
            raise InputError(no_such_name("active joint", name, self._active))
        return self._efforts[:, self._active.index(name)]

    def pressure(self, name: str) -> Quantity:
        """Pressure of a cylinder that holds the effort (points,) [Pa], other chamber empty."""
        if name not in self._robot.cylinders:
            raise InputError(no_such_name("cylinder", name, self._robot.cylinders))
        cylinder = self._robot.cylinders[name]
        push = self.effort(name) * cylinder.sign
        area = np.where(push.value < 0.0, -cylinder.rod_area, cylinder.cap_area)
        return push / area

    def margin(self, name: str) -> Quantity:
        """Distance of a coordinate to its nearer limit (points,) [rad or m], negative beyond."""
        lower, upper = self._robot.description.joints[self._checked(name)].limits
        coordinate = self.coordinate(name)
        if math.isinf(lower) and math.isinf(upper):
            raise InputError(f"{name} has no limits")
        is_lower = coordinate.value - lower < upper - coordinate.value
        sign = np.where(is_lower, 1.0, -1.0)
        return (coordinate - np.where(is_lower, lower, upper)) * sign

    def mass(self) -> Quantity:
        """Mass of all moving links [kg]."""
        slope = np.empty(len(self._parameters))
        for k, value in enumerate(self._parameters):
            step = _STEP * (1.0 + abs(value))
            above = self._parameters.copy()
            below = self._parameters.copy()
            above[k] += step
            below[k] -= step
            rise = self._family.mass(above) - self._family.mass(below)
            slope[k] = rise / (2.0 * step)
        value = self._family.mass(self._parameters)
        return Quantity(value, slope)

    @lazy
    def _closed(self) -> FamilyResult:
        return self._family.close(self._u, self._parameters, _BY)

    @lazy
    def _active_places(self) -> Quantity:
        """Active coordinates (points, n)."""
        if self._active == self._family.coordinates:
            count = len(self._parameters)
            return Quantity(self._u, np.zeros((*self._u.shape, count)))
        places = [self._index(name) for name in self._active]
        return _result(self._closed, "s")[:, places]

    @lazy
    def _efforts(self) -> Quantity:
        """Efforts of the active joints (points, n)."""
        return self._efforts_with(None)

    def _efforts_with(self, payload: Payload | None) -> Quantity:
        """The same with one more body at the end effector."""
        values = np.empty_like(self._u)
        count = len(self._parameters)
        slopes = np.empty((*values.shape, count))
        for loads, rows in self._rows_by_loads():
            if payload is not None:
                loads = (loads or self._robot.loads).with_payload(payload)  # noqa: PLW2901
            result = self._family.inverse_dynamics(
                self._u[rows],
                self._parameters,
                self._du[rows],
                self._ddu[rows],
                loads=loads,
                derivatives=_BY,
            )
            values[rows] = result["tau"]
            slopes[rows] = result.by_parameters["tau"]
        along = Quantity(values, slopes)
        if self._active == self._family.coordinates:
            return along
        places = [self._index(name) for name in self._active]
        rates = _result(self._closed, "R")[:, places]
        value = np.swapaxes(rates.value, 1, 2)
        slope = np.swapaxes(rates.slope, 1, 2)
        return solved(Quantity(value, slope), along)

    def _rows_by_loads(self) -> list[tuple[Loads | None, list[int]]]:
        """The points of each loads."""
        groups: dict[int, tuple[Loads | None, list[int]]] = {}
        for k, point in enumerate(self._duty):
            _, rows = groups.setdefault(id(point.loads), (point.loads, []))
            rows.append(k)
        return list(groups.values())

    def _index(self, name: str) -> int:
        return self._family.all_coordinates.index(self._checked(name))

    def _checked(self, name: str) -> str:
        """The name of a coordinate."""
        names = self._family.all_coordinates
        if name not in names:
            raise InputError(no_such_name("coordinate", name, names))
        return name


def _place(kind: str, name: str, names: Sequence[str]) -> int:
    """Index of a name."""
    if name not in names:
        raise InputError(no_such_name(kind, name, names))
    return list(names).index(name)


def _result(result: FamilyResult, name: str) -> Quantity:
    return Quantity(result.values[name], result.by_parameters[name])


def _along(result: FamilyResult, name: str, u: Quantity) -> Quantity:
    """A result at active coordinates (N, n) that change with the variables."""
    by_u = result.by_u[name]
    moved = np.einsum("n...j,njk->n...k", by_u, u.slope)
    return Quantity(result.values[name], result.by_parameters[name] + moved)
