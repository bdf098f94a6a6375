"""Rows of measurements as given coordinates and measured quantities of a robot."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..errors import InputError, StateError
from ..formats.tables import Table
from ..ground.arrays import Array
from ..ground.suggestions import suggestion
from ..ground.units import coordinate_unit
from .closed_rows import ClosedRows, PosedRows
from .free_robot import FreeRobot
from .quantities import Coordinate, Distance, Inclination, Orientation, Point, Quantity

TOOL = "tool"  # name of the end effector in columns
WEIGHT = "weight"  # column with the weight of each row
AXES = ("x", "y", "z")
QUATERNION = ("qx", "qy", "qz", "qw")
IGNORED = (WEIGHT, "time", "t", "row", "pose", "index", "id")
ENDLESS_TURNS = 4.0 * np.pi  # [rad] readings beyond this are rather degrees
THOUSAND = (200.0, 5000.0)  # ratio of readings in mm to lengths in m, roughly
STEEPEST = 2.0  # [rad] inclinations beyond this are rather degrees
LEAST_MOTION = 0.02  # of the columns of a point: share of the motion below which one has none
UNIT_QUATERNION = 0.05  # largest deviation of a quaternion's norm from 1
MAX_LISTED = 5


@dataclass(frozen=True, eq=False)
class Observations:
    """Measured rows of a robot.

    Attributes:
        table: the table that they come from.
        given: names of the coordinates from which the loops are closed.
        readings: readings of their encoders (N, n) [rad, m].
        quantities: what else is measured.
        measured: columns (N, columns) of each quantity.
        values: parameters (k,) with which they are closed [rad, m].
        closed: closed states.
        unused: columns that are not used.
    """

    table: Table
    given: tuple[str, ...]
    readings: Array
    quantities: tuple[Quantity, ...]
    measured: tuple[Array, ...]
    values: Array
    closed: ClosedRows
    unused: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.readings)

    def differences(self, posed: PosedRows) -> Array:
        """Model minus measurement (N, c) of all quantities; NaN where nothing was measured."""
        pairs = zip(self.quantities, self.measured, strict=True)
        parts = [quantity.difference(posed, measured) for quantity, measured in pairs]
        return np.concatenate(parts, axis=1)

    def owners(self) -> list[int]:
        """Index of the quantity of each component of the differences."""
        indices: list[int] = []
        for k, quantity in enumerate(self.quantities):
            indices += [k] * quantity.size
        return indices


class OpenRowsError(InputError):
    """Some rows do not close with the robot of the file.

    Attributes:
        rows: their indices.
    """

    def __init__(self, message: str, rows: list[int]) -> None:
        self.rows = rows
        super().__init__(message)


def observe(free_robot: FreeRobot, table: Table, values: Array | None = None) -> Observations:
    """The observations of a table.

    Args:
        free_robot: the robot and its parameters.
        table: the measurements.
        values: parameters (k,) with which the rows are closed; None for those of the file.

    Raises:
        OpenRowsError: some rows do not close.
        InputError: columns are missing or wrong.
    """
    if values is None:
        values = free_robot.start
    columns = _Columns(free_robot, table)
    quantities = columns.quantities()
    given = free_robot.given_among(columns.coordinates)
    for name in columns.coordinates:
        if name not in given:
            quantities.append(_coordinate(free_robot, name))
    if not quantities:
        expected = "tool.x, tool.y, tool.z, or further coordinates than the active ones"
        raise InputError(
            f"{table.source}: nothing is measured; expected columns such as {expected}"
        )
    columns.require_sizes(given)
    readings = np.stack([table.columns[name] for name in given], axis=1)
    closed = _closed(free_robot, table, given, values)
    measured: list[Array] = []
    for quantity in quantities:
        parts = [table.columns[name] for name in quantity.columns]
        measured.append(np.stack(parts, axis=1))
    result = Observations(
        table=table,
        given=given,
        readings=readings,
        quantities=tuple(quantities),
        measured=tuple(measured),
        values=values,
        closed=closed,
        unused=tuple(columns.unused),
    )
    _require_metres(result)
    _require_radians(result)
    return result


class _Columns:
    """Sorts the columns of a table by what they are."""

    def __init__(self, free_robot: FreeRobot, table: Table) -> None:
        self.free_robot = free_robot
        self.table = table
        self.coordinates = [name for name in free_robot.robot.coordinates if name in table.columns]
        self.unused: list[str] = []

    def quantities(self) -> list[Quantity]:
        """Points, orientations, distances and inclinations."""
        components: dict[str, list[str]] = {}
        quantities: list[Quantity] = []
        for name in self.table.columns:
            if name in self.coordinates:
                continue
            frame, _, component = name.rpartition(".")
            other = self.distance(name) or self.inclination(name)
            if other is not None:
                quantities.append(other)
            elif component in (*AXES, *QUATERNION) and self.is_frame(frame):
                components.setdefault(frame, []).append(component)
            else:
                self.leave(name)
        for frame, present in components.items():
            quantities += self.of_frame(frame, present)
        return quantities

    def of_frame(self, frame: str, present: list[str]) -> Iterator[Quantity]:
        """Point and orientation of a frame."""
        name = self.free_robot.robot.end_effector if frame == TOOL else frame
        axes = tuple(k for k, axis in enumerate(AXES) if axis in present)
        if axes:
            columns = tuple(f"{frame}.{AXES[k]}" for k in axes)
            yield Point(frame, columns, "m", name, axes)
        turns = [part for part in QUATERNION if part in present]
        if not turns:
            return
        columns = tuple(f"{frame}.{part}" for part in QUATERNION)
        missing = [column for column in columns if column not in self.table.columns]
        if missing:
            text = f"there is no column {missing[0]}; an orientation needs {', '.join(columns)}"
            raise InputError(f"{self.table.source}: {text}")
        self.require_unit_quaternions(columns)
        yield Orientation(f"{frame} orientation", columns, "rad", name)

    def require_unit_quaternions(self, columns: tuple[str, ...]) -> None:
        """Raise for a quaternion whose norm is not 1."""
        parts = np.stack([self.table.columns[column] for column in columns], axis=1)
        norms = np.linalg.norm(parts, axis=1)
        wrong = np.flatnonzero(np.abs(norms - 1.0) > UNIT_QUATERNION)
        if len(wrong):
            row = int(wrong[0])
            names = ", ".join(columns)
            text = f"{names} have the norm {norms[row]:.4g}; expected a unit quaternion"
            raise InputError(f"{self.table.row(row)}: {text}")

    def is_frame(self, frame: str) -> bool:
        """Whether a name is that of a frame."""
        return frame == TOOL or frame in self.free_robot.robot.frames

    def frame_name(self, frame: str) -> str:
        """The frame of a name in columns."""
        return self.free_robot.robot.end_effector if frame == TOOL else frame

    def distance(self, name: str) -> Quantity | None:
        """The distance of a column `distance.A.B`; None if it is none."""
        if not name.startswith("distance."):
            return None
        parts = name.split(".")[1:]
        for k in range(1, len(parts)):
            one, other = ".".join(parts[:k]), ".".join(parts[k:])
            if self.is_frame(one) and self.is_frame(other):
                frames = self.frame_name(one), self.frame_name(other)
                return Distance(name, (name,), "m", *frames)
        text = f"column {name}: expected distance.A.B with two frames or links"
        existing = ", ".join((TOOL, *self.free_robot.robot.frames))
        raise InputError(f"{self.table.source}: {text}; there are: {existing}")

    def inclination(self, name: str) -> Quantity | None:
        """The inclination of a column `inclination.FRAME.x`; None if it is none."""
        if not name.startswith("inclination."):
            return None
        frame, _, axis = name.removeprefix("inclination.").rpartition(".")
        if axis not in AXES or not self.is_frame(frame):
            text = f"column {name}: expected inclination.FRAME.x with a frame or link and x, y or z"
            raise InputError(f"{self.table.source}: {text}")
        gravity = np.array(self.free_robot.robot.description.gravity)
        size = float(np.linalg.norm(gravity))
        up = (0.0, 0.0, 1.0)
        if size > 0.0:
            x, y, z = (-gravity / size).tolist()
            up = (x, y, z)
        return Inclination(name, (name,), "rad", self.frame_name(frame), AXES.index(axis), up)

    def leave(self, name: str) -> None:
        """Leave a column out; raise if it is rather a misspelt one."""
        if name in IGNORED:
            return
        robot = self.free_robot.robot
        expected = [*robot.coordinates]
        expected += [f"{TOOL}.{part}" for part in (*AXES, *QUATERNION)]
        missing = [one for one in expected if one not in self.table.columns]
        hint = suggestion(name, missing)
        if hint:
            raise InputError(f"{self.table.source}: column {name} is not known{hint}")
        self.unused.append(name)

    def require_sizes(self, given: tuple[str, ...]) -> None:
        """Raise for given coordinates that are missing in a row, or rather in degrees."""
        for name in given:
            values = self.table.columns[name]
            missing = np.flatnonzero(~np.isfinite(values))
            if len(missing):
                place = self.table.row(int(missing[0]))
                raise InputError(f"{place}: {name} is missing; each row needs {', '.join(given)}")
            unit = coordinate_unit(self.free_robot.robot.joint_types[name])
            largest = float(np.abs(values).max())
            if unit == "rad" and largest > ENDLESS_TURNS and name not in self.table.units:
                text = f"{name} goes to {largest:.4g} rad; if it is in degrees, write {name} [deg]"
                raise InputError(f"{self.table.source}: {text} in the header")


def _coordinate(free_robot: FreeRobot, name: str) -> Quantity:
    """A coordinate that is measured beside the given ones."""
    robot = free_robot.robot
    unit = coordinate_unit(robot.joint_types[name])
    return Coordinate(name, (name,), unit, robot.coordinates.index(name))


def _closed(
    free_robot: FreeRobot, table: Table, given: tuple[str, ...], values: Array
) -> ClosedRows:
    """The closed rows; raises OpenRowsError that names a row and what may be wrong."""
    readings = {name: table.columns[name] for name in given}
    try:
        return free_robot.closed_at(values, given, readings)
    except StateError as error:
        place = table.source
        text = str(error)
        if error.index is not None:
            place = table.row(error.index)
            text = text.partition(": ")[2]
        message = f"{place}: {text}{_length_hint(free_robot, table, given)}"
        rows = free_robot.open_rows(given, readings)
        raise OpenRowsError(message, rows) from error


def _length_hint(free_robot: FreeRobot, table: Table, given: tuple[str, ...]) -> str:
    """A hint on slides whose readings are rather in mm."""
    robot = free_robot.robot
    for name in given:
        if robot.joint_types[name] != "prismatic" or name in table.units:
            continue
        largest = float(np.abs(table.columns[name]).max())
        limits = np.abs(robot.limits[np.isfinite(robot.limits)])
        if largest > THOUSAND[0] * max(0.05, 0.01 * float(limits.max(initial=1.0))):
            return f"; if {name} is in mm, write {name} [mm] in the header"
    return ""


def _require_metres(observations: Observations) -> None:
    """Raise for points and distances that are rather in mm."""
    posed = observations.closed.poses()
    for quantity, measured in zip(observations.quantities, observations.measured, strict=True):
        if quantity.unit != "m":
            continue
        size = float(np.nanmax(np.abs(measured), initial=0.0))
        predicted = quantity.difference(posed, np.zeros_like(measured))
        expected = float(np.abs(predicted).max(initial=0.0))
        low, high = THOUSAND
        if expected > 0.0 and low < size / expected < high:
            column = quantity.columns[0]
            text = f"{column} goes to {size:.4g} m, where the robot has {expected:.4g} m"
            unit = f"if it is in mm, write {column} [mm] in the header"
            raise InputError(f"{observations.table.source}: {text}; {unit}")
        _require_metres_of_each(observations.table, quantity, measured, predicted)


def _require_metres_of_each(
    table: Table, quantity: Quantity, measured: Array, predicted: Array
) -> None:
    """Raise for one column of a point that is rather in mm; a shifted frame does not matter."""
    expected = _middle_half(predicted)
    least = LEAST_MOTION * float(expected.max())
    low, high = THOUSAND
    for k, size in enumerate(_middle_half(measured)):
        if expected[k] > least and low < size / expected[k] < high:
            column = quantity.columns[k]
            text = f"{column} varies by {size:.4g} m, where the robot has {expected[k]:.4g} m"
            unit = f"if it is in mm, write {column} [mm] in the header"
            raise InputError(f"{table.source}: {text}; {unit}")


def _middle_half(values: Array) -> Array:
    """The range of the middle half of each column."""
    quarters = []
    for column in values.T:
        present = column[np.isfinite(column)]
        low, high = np.quantile(present, (0.25, 0.75)) if len(present) else (0.0, 0.0)
        quarters.append(high - low)
    return np.array(quarters)


def _require_radians(observations: Observations) -> None:
    """Raise for inclinations and further angles that are rather in degrees."""
    for quantity, measured in zip(observations.quantities, observations.measured, strict=True):
        if isinstance(quantity, Inclination):
            most = STEEPEST
        elif isinstance(quantity, Coordinate) and quantity.unit == "rad":
            most = ENDLESS_TURNS
        else:
            continue
        (column,) = quantity.columns
        size = float(np.nanmax(np.abs(measured), initial=0.0))
        if size > most and column not in observations.table.units:
            text = f"{column} goes to {size:.4g} rad; if it is in degrees, write {column} [deg]"
            raise InputError(f"{observations.table.source}: {text} in the header")
