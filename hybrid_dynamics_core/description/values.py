"""Numbers of a document: expressions become values, checked to be finite; vectors, axes, limits and poses of them."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

from ..ground.arrays import Array, frozen
from ..ground.suggestions import did_you_mean
from ..ground.wording import singular_or_plural
from .document import Document, Path_
from .expressions import evaluate
from .geometry import IDENTITY, Transform, rotation_from_rpy, rotation_to_axis, unit_axis

TURN = 1.01 * math.tau  # [rad] a printed turn is 6.28 or 6.3
ENDLESS = 1e4  # [rad] limits beyond this mean that there are none
PRINTED_PI = 1e-5  # relative: multiples of pi as programs print them
_FLOAT_LIMIT = 1e12  # beyond this an SI value of a robot is a slip


def _seems_degrees(told: float | str, angle: float) -> bool:
    """Whether an angle [rad] of more than a turn is no multiple of a quarter turn and written without pi or deg."""
    if not TURN < abs(angle) < ENDLESS or (
        isinstance(told, str) and re.search(r"\b(pi|deg)\b", told)
    ):
        return False
    quarters = angle / (math.pi / 2.0)
    return abs(quarters - round(quarters)) > PRINTED_PI * abs(quarters)


def _in_degrees(told: float | str) -> str:
    """How an angle that a file has is written, where it is in degrees."""
    if not isinstance(told, str):
        return f"{told:g}*deg" if told else "0"
    if re.search(r"\b(pi|deg)\b", told):
        return told
    return f"{told.strip()}*deg" if re.fullmatch(r"\s*[-+]?[\w.]+\s*", told) else f"({told})*deg"


class Numbers:
    """Reads values at paths of a document; what an expression may name depends on the place."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.parameters: dict[str, float] = {}
        for name, value in (document.data.get("parameters") or {}).items():
            self.parameters[name] = self.number(value, ("parameters", name))

    def number(
        self, value: float | str, path: Path_, names: Mapping[str, float] | None = None
    ) -> float:
        """A finite number from a number or an expression over `names` (those of the place if None)."""
        number = self.extended(value, path, names)
        if not math.isfinite(number) or abs(number) > _FLOAT_LIMIT:
            raise self.document.error(path, f"is {value}; expected a finite number in SI units")
        return number

    def extended(
        self, value: float | str, path: Path_, names: Mapping[str, float] | None = None
    ) -> float:
        """The same, where infinity has a meaning."""
        names = self.document.scope(path, self.parameters) if names is None else names
        try:
            return evaluate(value, names) if isinstance(value, str) else float(value)
        except (ValueError, OverflowError) as error:
            raise self.document.error(path, str(error)) from error

    def angle(self, value: float | str, path: Path_) -> float:
        """A number [rad]; doubted where degrees seem to be meant."""
        number = self.number(value, path)
        self.doubt_degrees([value], [number], path)
        return number

    def doubt_degrees(
        self, told: Sequence[float | str], angles: Sequence[float], path: Path_
    ) -> None:
        """Note angles [rad] of more than a turn that are written without pi: many a file has degrees there."""
        slips = [
            (text, angle)
            for text, angle in zip(told, angles, strict=False)
            if _seems_degrees(text, angle)
        ]
        if slips:
            turns = (
                max(0.0, *angles) - min(0.0, *angles) if len(angles) > 1 else abs(angles[0])
            ) / math.tau
            values = " to ".join(f"{angle:g}" for angle in angles)
            written = ", ".join(map(_in_degrees, told))
            hint = did_you_mean(f"[{written}]" if len(told) > 1 else written)
            self.document.doubt(
                path,
                f"{values} rad {singular_or_plural(len(angles), 'is', 'are')} {turns:.3g} turns{hint}",
            )

    def length(self, value: float | str, path: Path_) -> float:
        """A number above zero."""
        number = self.number(value, path)
        if number <= 0.0:
            raise self.document.error(path, f"is {number:g} m; a dimension is positive")
        return number

    def vector(self, values: list[Any], path: Path_) -> Array:
        """An array of the numbers of a list."""
        return frozen([self.number(v, (*path, k)) for k, v in enumerate(values)])

    def axis(self, entry: str | list[Any], path: Path_) -> Array:
        """A unit vector (3,)."""
        try:
            return unit_axis(
                entry if isinstance(entry, str) else [float(v) for v in self.vector(entry, path)]
            )
        except ValueError as error:
            raise self.document.error(path, str(error)) from error

    def limits(self, entry: list[Any] | None, path: Path_) -> tuple[float, float]:
        """(lower, upper), infinite where nothing or .inf is given."""
        if entry is None:
            return -math.inf, math.inf
        lower, upper = (self.extended(v, (*path, k)) for k, v in enumerate(entry))
        if not lower < upper:
            raise self.document.error(
                path, f"the lower limit {lower:g} is not below the upper limit {upper:g}"
            )
        return lower, upper

    def pose(self, entry: Mapping[str, Any] | list[Any], path: Path_) -> Transform:
        """A pose from {xyz, rpy}, or from a list of such steps, each taken in the frame that the one before reached."""
        if isinstance(entry, list):
            steps = [self.pose(step, (*path, k)) for k, step in enumerate(entry)]
            pose = steps[0]
            for step in steps[1:]:
                pose = pose @ step
            return pose
        xyz = self.vector(entry.get("xyz", [0, 0, 0]), (*path, "xyz"))
        told = entry.get("rpy", [0, 0, 0])
        roll, pitch, yaw = (self.angle(value, (*path, "rpy", k)) for k, value in enumerate(told))
        return Transform(rotation_from_rpy(roll, pitch, yaw), xyz)

    def place(self, entry: Mapping[str, Any] | list[Any], path: Path_) -> Transform:
        """A place on a link: [x, y, z], a pose, or a point with the direction of its z axis (`axis`)."""
        if isinstance(entry, list) and not isinstance(entry[0], Mapping):
            return Transform(IDENTITY, self.vector(entry, path))
        if isinstance(entry, list) or "axis" not in entry:
            return self.pose(entry, path)
        axis = self.axis(entry["axis"], (*path, "axis"))
        return Transform(
            rotation_to_axis(axis), self.vector(entry.get("xyz", [0, 0, 0]), (*path, "xyz"))
        )
