"""What a robot can do at a state within the limits of its drives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..description.effects import Payload
from ..dynamics.loads import Loads
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arguments import real_number
from ..ground.check_arrays import mapping_of
from ..ground.suggestions import no_such_name
from .axes import rows_of, unit_wrench
from .box_image import BoxImage, UnlimitedError, solutions
from .polytope import Polytope, hull
from .robot_interface import CapableRobot

AT_LIMIT = 1e-6  # share of a range within which a force is at its limit
STILL = 1e-9  # speed over the largest entry of a Jacobian, below which a frame does not move


@dataclass(frozen=True, eq=False)
class Largest:
    """The largest force or mass, and the drives that limit it.

    Attributes:
        value: [N, N m or kg]; infinity without a limit. Minus infinity says that the drives cannot
            even hold the state.
        limited_by: drives at a limit with this value; none where nothing limits.
        efforts: effort by drive with this value [N m, N].
    """

    value: float
    limited_by: tuple[str, ...]
    efforts: Mapping[str, float]


class Capability:
    """Forces, accelerations, speeds and loads at one state within the limits of the drives.

    Axes are those of the base. x, y and z are forces or translations. rx, ry and rz are moments or
    rotations about the frame's origin.
    """

    def __init__(
        self,
        robot: CapableRobot,
        state: ClosedState,
        loads: Loads | None = None,
        frame: str | None = None,
        efforts: Mapping[str, float] | None = None,
        rates: Mapping[str, float] | None = None,
    ) -> None:
        """Capability of a robot at a state.

        Args:
            robot: the robot.
            state: one closed state.
            loads: loads besides the actuators; those of the description if None.
            frame: name of the frame; the end effector if None.
            efforts: other largest efforts [N m, N] by drive.
            rates: other largest rates [rad/s, m/s] by coordinate.

        Raises:
            InputError: a name is unknown, or the state is a batch.
        """
        if state.u.ndim != 1:
            raise InputError("capability is that of one state; expected no batch")
        self._robot = robot
        self._state = state
        self._loads = robot.loads
        if loads is not None:
            self._loads = loads
        self._frame = frame
        self.drives = robot.all_drives
        self._jacobian = robot.jacobian(state, frame)
        self._to_tau = robot.drive_rates(state).T
        self.limits = _limits(robot, state, efforts)
        self.rates = _rates(robot, rates)
        self._still = np.zeros(len(robot.active))

    def forces(self, axes: Sequence[str] = ("x", "y", "z")) -> Polytope:
        """Forces [N] and moments [N m] of the frame on what it touches.

        Those along the other axes are zero.

        Args:
            axes: names out of x, y, z, rx, ry, rz.

        Raises:
            UnlimitedError: a drive without a limit gives any force. It is an InputError.
        """
        wrenches = np.eye(6)[rows_of(axes)]
        return self._polytope(self._forces(wrenches), axes)

    def largest_force(self, direction: ArrayLike) -> Largest:
        """The largest force of the frame on what it touches, along a direction.

        Args:
            direction: (3,) in base axes, or (6,) with a moment; its length does not matter.

        Returns:
            The force [N]; with a moment, the largest multiple of the unit direction.
        """
        unit = unit_wrench(direction)
        return largest(self._forces(unit[None]), self.drives)

    def accelerations(self, axes: Sequence[str] = ("x", "y", "z")) -> Polytope:
        """Accelerations of the frame from rest [m/s^2, rad/s^2].

        Args:
            axes: names out of x, y, z, rx, ry, rz.

        Raises:
            InputError: the state moves.
        """
        if np.any(self._state.du):
            raise InputError("accelerations are those from rest; expected a state without rates")
        mass, _, _ = self._robot.minimal_form(self._state, self._loads)
        image = self._solutions(mass, self._needed())
        rows = self._jacobian[rows_of(axes)]
        of_frame = replace(
            image,
            y0=rows @ image.y0,
            Y=rows @ image.Y,
        )
        return self._polytope(of_frame, axes)

    def speeds(self, axes: Sequence[str] = ("x", "y", "z")) -> Polytope:
        """Velocities of the frame within the rates of the joints [m/s, rad/s].

        Args:
            axes: names out of x, y, z, rx, ry, rz.
        """
        rows = [self._robot.coordinates.index(name) for name in self.rates]
        largest_rates = np.array(list(self.rates.values()))
        rates = np.reshape(self._state.R[rows], (len(rows), len(self._still)))
        jacobian = self._jacobian[rows_of(axes)]
        image = BoxImage(
            y0=np.zeros(len(jacobian)),
            Y=jacobian,
            x0=np.zeros(len(largest_rates)),
            X=rates,
            lower=-largest_rates,
            upper=largest_rates,
        )
        return self._polytope(image, axes, tuple(self.rates))

    def lifted_mass(self, com: ArrayLike = (0.0, 0.0, 0.0)) -> Largest:
        """The largest mass that the drives hold at rest at the frame.

        Args:
            com: its centre of mass (3,) in the frame [m].

        Returns:
            The mass [kg].

        Raises:
            InputError: the state moves.
        """
        state = self._standstill()
        kilogram = Payload(1.0, com)
        frame = self._frame or self._robot.end_effector
        with_load = self._loads.with_payload(kilogram, frame)
        held = self._robot.inverse_dynamics(state, self._still, self._loads)
        loaded = self._robot.inverse_dynamics(state, self._still, with_load)
        weight = loaded - held
        image = self._solutions(weight[:, None], held)
        return largest(image, self.drives)

    def breakout(self, drive: str, retracting: bool = False) -> Largest:
        """The largest force of the frame along its path when one drive moves.

        With a bucket's cylinder, that is the breakout force at the teeth.

        Args:
            drive: name of the drive; the other drives stand still.
            retracting: whether the drive moves back.

        Returns:
            The force [N].

        Raises:
            InputError: there is no such drive, or it does not move the frame.
        """
        if drive not in self.drives:
            raise InputError(no_such_name("drive", drive, self.drives))
        unit = np.zeros(len(self.drives))
        unit[self.drives.index(drive)] = 1.0
        if retracting:
            unit = -unit
        rates = np.linalg.lstsq(self._to_tau.T, unit)[0]
        velocity = self._jacobian[:3] @ rates
        size = np.abs(self._jacobian).max(initial=1e-300)
        if not np.linalg.norm(velocity) > STILL * size:
            raise InputError(f"{drive} does not move the frame here")
        return self.largest_force(velocity)

    def _forces(self, wrenches: Array) -> BoxImage:
        """Forces of the frame on what it touches, as multiples of k unit wrenches (k, 6)."""
        along = self._jacobian.T @ wrenches.T
        return self._solutions(along, self._needed())

    def _solutions(self, per_unit: Array, needed: Array) -> BoxImage:
        """Results y that the drives can give, each within its limits.

        Args:
            per_unit: efforts (n, k) that each unit of y takes.
            needed: efforts (n,) at y = 0.
        """
        lower, upper = bounds_of(self.limits, self.drives)
        return solutions(self._to_tau, per_unit, needed, lower, upper)

    def _needed(self) -> Array:
        """Efforts (n,) that the state takes without acceleration."""
        return self._robot.inverse_dynamics(self._state, self._still, self._loads)

    def _standstill(self) -> ClosedState:
        """The state, which is at rest; otherwise raises InputError."""
        if np.any(self._state.du):
            raise InputError("a lifted mass is held at rest; expected a state without rates")
        return self._state

    def _polytope(
        self,
        image: BoxImage,
        axes: Sequence[str],
        names: tuple[str, ...] | None = None,
    ) -> Polytope:
        """The polytope of an image.

        Args:
            image: results along k axes, and what is limited.
            axes: names of the k axes.
            names: names of what is limited; the drives if None.
        """
        if names is None:
            names = self.drives
        try:
            points, forces = image.vertices()
        except UnlimitedError as error:
            free = [name for name in names if not _is_limited(name, names, image)]
            listed = ", ".join(free) or "a joint"
            example = names[0] if names else "q1"
            raise UnlimitedError(
                f"nothing limits it along {', '.join(axes)}: {listed} has no limit; give one, as"
                f" efforts={{'{example}': 1e4}} or rates, or other axes"
            ) from error
        at_limit = [_at_limit(names, row, image) for row in forces]
        return hull(points, tuple(axes), at_limit)


def capability_at(
    robot: CapableRobot,
    state: ClosedState,
    loads: Loads | None = None,
    frame: str | None = None,
    efforts: Mapping[str, float] | None = None,
    rates: Mapping[str, float] | None = None,
) -> Capability:
    """What the robot can do at a state within the limits of its drives.

    Args:
        robot: the robot.
        state: one closed state.
        loads: loads besides the actuators; `robot.loads` if None.
        frame: name in `frames`; the end effector if None.
        efforts: other largest efforts [N m, N] by drive.
        rates: other largest rates [rad/s, m/s] by coordinate.

    Returns:
        Forces, accelerations, speeds and loads, computed when asked for.

    Raises:
        InputError: a name is unknown, or the state is a batch.
    """
    return Capability(robot, state, loads, frame, efforts, rates)


def largest(image: BoxImage, drives: tuple[str, ...]) -> Largest:
    """The largest y of an image of one dimension.

    Args:
        image: results y (1,) with the efforts of the drives.
        drives: names of the m drives.
    """
    try:
        points, forces = image.vertices()
    except UnlimitedError:
        return Largest(np.inf, (), {})
    if not len(points):
        return Largest(-np.inf, (), {})
    best = int(np.argmax(points[:, 0]))
    value = float(points[best, 0])
    efforts = dict(zip(drives, forces[best].tolist(), strict=True))
    limited_by = _at_limit(drives, forces[best], image)
    return Largest(value, limited_by, efforts)


def bounds_of(
    ranges: Mapping[str, tuple[float, float]], drives: Sequence[str]
) -> tuple[Array, Array]:
    """Least and greatest efforts (m,) of m drives [N m, N], from those by name."""
    chosen = [ranges[name] for name in drives]
    bounds = np.reshape(chosen, (-1, 2))
    return bounds[:, 0], bounds[:, 1]


def _is_limited(name: str, names: Sequence[str], image: BoxImage) -> bool:
    """Whether a drive or joint has limits in both directions."""
    k = list(names).index(name)
    return bool(np.isfinite(image.lower[k]) and np.isfinite(image.upper[k]))


def _at_limit(names: Sequence[str], forces: Array, image: BoxImage) -> tuple[str, ...]:
    """Names of forces (m,) at a limit."""
    width = image.upper - image.lower
    width = np.where(np.isfinite(width), width, 0.0)
    low = forces <= image.lower + AT_LIMIT * width
    high = forces >= image.upper - AT_LIMIT * width
    return tuple(name for name, at in zip(names, low | high, strict=True) if at)


def _limits(
    robot: CapableRobot,
    state: ClosedState,
    efforts: Mapping[str, float] | None,
) -> dict[str, tuple[float, float]]:
    """Least and greatest effort by drive [N m, N]: the caller's where given, else the robot's."""
    limits = dict(robot.effort_ranges)
    for name, (lower, upper) in limits.items():
        joint = robot.description.joints.get(name)
        if joint is None or joint.effort_table is None:
            continue
        place = robot.coordinates.index(name)
        table = joint.effort_table.at(state.s[place], state.ds[place])
        effort = float(table)
        limits[name] = (max(lower, -effort), min(upper, effort))
    for name, value in mapping_of("efforts", efforts).items():
        if name not in limits:
            raise InputError(f"efforts: {no_such_name('drive', name, limits)}")
        _refuse_angle(robot, "efforts", name)
        given = _positive(name, value)
        limits[name] = (-given, given)
    return limits


def _rates(robot: CapableRobot, rates: Mapping[str, float] | None) -> dict[str, float]:
    """Largest rate by coordinate [rad/s, m/s], of those with a limit."""
    limits = dict(robot.rate_ranges)
    for name, value in mapping_of("rates", rates).items():
        if name not in limits:
            raise InputError(f"rates: {no_such_name('coordinate', name, limits)}")
        _refuse_angle(robot, "rates", name)
        limits[name] = _positive(name, value)
    return {name: value for name, value in limits.items() if np.isfinite(value)}


def _refuse_angle(robot: CapableRobot, what: str, name: str) -> None:
    """Raise for an angle of a ball joint: a limit along it would depend on the chart."""
    if name in robot.description.angles_in_rows:
        raise InputError(
            f"{what}: '{name}' is an angle of a ball or free joint, which differs between its"
            " charts, so that a limit along it says nothing; limit other joints"
        )


def _positive(name: str, value: ArrayLike) -> float:
    """A limit, which is zero or more; otherwise raises InputError."""
    number = real_number(name, value)
    if not number >= 0.0:
        raise InputError(f"{name}: the limit is {number:g}; expected zero or more")
    return number
