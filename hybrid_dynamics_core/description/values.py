"""Reader of values of a document: checked numbers, vectors, axes, limits and poses."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import reduce
from operator import matmul
from typing import Any, TypeVar

import numpy as np

from ..algebra.live import kept, plain
from ..ground.arrays import Array, frozen
from ..ground.suggestions import did_you_mean
from ..ground.wording import singular_or_plural
from .document import Data, Document, KeyPath
from .expressions import evaluate
from .geometry import (
    IDENTITY,
    Transform,
    nearest_rotation,
    rotation_about,
    rotation_from_quaternion,
    rotation_from_rpy,
    rotation_with_z_axis,
    unit_axis,
)
from .value_units import units_at

ENDLESS = 1e4  # [rad] limits beyond this count as no limits
_ONE_TURN = 1.01 * math.tau  # [rad] a printed turn is 6.28 or 6.3
_PI_SLACK = 1e-5  # relative error of printed multiples of pi
_LARGEST = 1e12  # an SI value of a robot beyond this is an error
_ZERO_VECTOR = [0, 0, 0]
_ROUNDED = 1e-6  # error of unit vectors above which a rotation counts as rounded, with a note
_PRINTED = 1e-2  # error of unit vectors above which a matrix is no rotation

_ANGLE_UNIT = re.compile(r"\b(pi|deg|rad|rpm)\b")
_SINGLE_TERM = re.compile(r"\s*[-+]?[\w.]+\s*")

T = TypeVar("T")
Scalar = float | str  # a number, or an expression
Entry = Data | list[Any]


class ValueReader:
    """Reads values at paths of a document; the path decides which names expressions may use."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.parameters: dict[str, float] = {}
        for name, value in document.entries("parameters").items():
            if name == "pi":
                problem = "is the number 3.14159... in every expression; choose another name"
                raise document.error(("parameters", name), problem)
            self.parameters[name] = self.number(value, ("parameters", name))

    def number(self, value: Scalar, path: KeyPath) -> float:
        """A finite number from a number or an expression."""
        number = self.number_or_infinity(value, path)
        if not math.isfinite(number) or abs(number) > _LARGEST:
            what = "not finite" if not math.isfinite(number) else "too large"
            problem = f"is {value}, which is {what}; expected a finite number in SI units"
            raise self.document.error(path, problem)
        return number

    def number_or_infinity(self, value: Scalar, path: KeyPath) -> float:
        """A number that may be infinite."""
        names = self.document.scope(path, self.parameters)
        units = units_at(self.document, path)
        try:
            number = number_from(value, names, units)
        except (ValueError, OverflowError) as error:
            raise self.document.error(path, str(error)) from error
        if math.isnan(number):
            raise self.document.error(path, f"is {value}, which is not finite; expected a number")
        return number

    def length(self, value: Scalar, path: KeyPath) -> float:
        """A number [m] above zero."""
        number = self.number(value, path)
        if number <= 0.0:
            raise self.document.error(path, f"is {number:g} m; a dimension is positive")
        return number

    def angle(self, value: Scalar, path: KeyPath) -> float:
        """A number [rad], with a warning if it seems to be in degrees."""
        number = self.number(value, path)
        self.warn_of_degrees([value], [number], path)
        return number

    def vector(self, values: Sequence[Scalar], path: KeyPath) -> Array:
        """An array of the numbers of a list."""
        return frozen(read_each(self.number, values, path))

    def axis(self, entry: str | list[Any], path: KeyPath) -> Array:
        """A unit vector (3,) from a letter such as '-z', or from a list."""
        direction = entry
        if not isinstance(direction, str):
            direction = self.vector(direction, path).tolist()
        try:
            return unit_axis(direction)
        except ValueError as error:
            raise self.document.error(path, str(error)) from error

    def limits(self, entry: Sequence[Scalar] | None, path: KeyPath) -> tuple[float, float]:
        """(lower, upper), infinite if left out or .inf."""
        if entry is None:
            return -math.inf, math.inf
        lower, upper = read_each(self.number_or_infinity, entry, path)
        if not lower < upper:
            raise self.document.error(
                path, f"the lower limit {lower:g} is not below the upper limit {upper:g}"
            )
        return lower, upper

    def pose(self, entry: Entry, path: KeyPath) -> Transform:
        """A pose from {xyz, rpy}, or from a list of such steps.

        Each step is relative to the frame after the step before. `quat`, `matrix` or `axis_angle`
        may replace `rpy`.
        """
        if isinstance(entry, list):
            return reduce(matmul, read_each(self.pose, entry, path))
        translation = self._translation(entry, path)
        return Transform(self.rotation(entry, path), translation)

    def rotation(self, entry: Data, path: KeyPath) -> Array:
        """The rotation matrix (3, 3) of a pose, in whichever form it is written."""
        readers: dict[str, Callable[[Any, KeyPath], Array]] = {
            "rpy": self._from_rpy,
            "quat": self._from_quaternion,
            "quat_xyzw": self._from_quaternion,
            "matrix": self._from_matrix,
            "axis_angle": self._from_axis_angle,
            "axis": self._with_z_axis,  # for an end of a closure
        }
        forms = [form for form in readers if form in entry]
        if len(forms) > 1:
            given = " and ".join(forms)
            raise self.document.error(path, f"gives {given}; expected one rotation, in one form")
        if not forms:
            return IDENTITY
        form = forms[0]
        return readers[form](entry[form], (*path, form))

    def _from_rpy(self, angles: list[Scalar], path: KeyPath) -> Array:
        roll, pitch, yaw = read_each(self.angle, angles, path)
        return rotation_from_rpy(roll, pitch, yaw)

    def _from_quaternion(self, components: list[Scalar], path: KeyPath) -> Array:
        """The rotation of a quaternion x, y, z, w of any length above zero."""
        x, y, z, w = self.vector(components, path)
        length = math.hypot(x, y, z, w)
        if length == 0.0:
            problem = "has no length; expected [x, y, z, w], as [0, 0, 0, 1] for no rotation"
            raise self.document.error(path, problem)
        if abs(length - 1.0) > _ROUNDED:
            self.document.note(path, f"the quaternion has the length {length:.9g}; taken: 1")
        unit = np.array([w, x, y, z]) / length
        return rotation_from_quaternion(unit)

    def _from_matrix(self, rows: list[list[Scalar]], path: KeyPath) -> Array:
        """A rotation matrix; a rounded one is replaced by the nearest rotation."""
        matrix = np.array(read_each(self.vector, rows, path))
        apart = float(np.abs(matrix @ matrix.T - IDENTITY).max())
        if apart > _PRINTED:
            problem = f"its rows are off unit length and right angles by {apart:.3g}"
            raise self.document.error(path, f"is no rotation: {problem}")
        if np.linalg.det(plain(matrix)) < 0.0:
            problem = "is a reflection, not a rotation (determinant -1); turn one of its axes round"
            raise self.document.error(path, problem)
        if apart > _ROUNDED:
            remark = f"rows are off unit length and right angles by {apart:.3g}"
            self.document.note(path, f"{remark}; the nearest rotation is taken")
        return nearest_rotation(matrix)

    def _from_axis_angle(self, entry: Data, path: KeyPath) -> Array:
        axis = self.axis(entry["axis"], (*path, "axis"))
        angle = self.angle(entry["angle"], (*path, "angle"))
        return rotation_about(axis, angle)

    def attachment(self, entry: Entry, path: KeyPath) -> Transform:
        """The end of a closure on a link: [x, y, z], a pose, or a point with an axis.

        The axis is the direction of z.
        """
        if isinstance(entry, list):
            if isinstance(entry[0], Mapping):
                return self.pose(entry, path)
            return Transform(IDENTITY, self.vector(entry, path))
        return self.pose(entry, path)

    def _with_z_axis(self, entry: str | list[Any], path: KeyPath) -> Array:
        return rotation_with_z_axis(self.axis(entry, path))

    def _translation(self, entry: Data, path: KeyPath) -> Array:
        """The vector (3,) [m] of `xyz`."""
        xyz = entry.get("xyz", _ZERO_VECTOR)
        return self.vector(xyz, (*path, "xyz"))

    def warn_of_degrees(
        self, written: Sequence[Scalar], angles: Sequence[float], path: KeyPath
    ) -> None:
        """Warn of angles [rad] above one turn that are written without pi.

        Args:
            written: the angles as texts of the file.
            angles: their values [rad].
            path: path of the entry.
        """
        pairs = zip(written, angles, strict=False)
        if not any(_seems_degrees(text, angle) for text, angle in pairs):
            return
        span = max(0.0, *angles) - min(0.0, *angles)
        turns = span / math.tau
        values = " to ".join(f"{angle:g}" for angle in angles)
        corrected = ", ".join(map(_in_degrees, written))
        if len(written) > 1:
            corrected = f"[{corrected}]"
        verb = singular_or_plural(len(angles), "is", "are")
        hint = did_you_mean(corrected)
        self.document.warn(path, f"{values} rad {verb} {turns:.3g} turns{hint}")


def read_each(read: Callable[[Any, KeyPath], T], values: Iterable[Any], path: KeyPath) -> list[T]:
    """The values of a list, each read at its own path."""
    return [read(value, (*path, k)) for k, value in enumerate(values)]


def number_from(value: Scalar, names: Mapping[str, float], units: Sequence[str] = ()) -> float:
    """The value of a number, or of an expression over names.

    Args:
        value: the number or the expression.
        names: names allowed in the expression.
        units: the allowed units; empty if any unit is allowed.

    Raises:
        ValueError, OverflowError: the expression has no value.
    """
    if isinstance(value, str):
        return evaluate(value, names, units=units)
    return kept(value)


def _seems_degrees(written: Scalar, angle: float) -> bool:
    """Whether an angle [rad] is above one turn, no multiple of pi/2, and written without pi."""
    if not _ONE_TURN < abs(angle) < ENDLESS:
        return False
    if isinstance(written, str) and _ANGLE_UNIT.search(written):
        return False
    quarters = angle / (math.pi / 2.0)
    return abs(quarters - round(quarters)) > _PI_SLACK * abs(quarters)


def _in_degrees(written: Scalar) -> str:
    """The text for an angle if its number is in degrees."""
    if not isinstance(written, str):
        return f"{written:g}*deg" if written else "0"
    if _ANGLE_UNIT.search(written):
        return written
    if _SINGLE_TERM.fullmatch(written):
        return f"{written.strip()}*deg"
    return f"({written})*deg"
