"""What is measured beside the given coordinates, as predicted by a model.

Each quantity has some components a row. Its difference is model minus measurement, in m or rad.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from ..algebra.rotations import quaternion, rotation_matrix
from ..ground.arrays import Array
from .closed_rows import PosedRows

TURN = 2.0 * np.pi  # [rad]
HALF_TURN = 1e-6  # sine of an angle near half a turn below which its axis is lost in rounding
SMALL = 1e-12  # sine of an angle below which its axis does not matter


@dataclass(frozen=True)
class Quantity(ABC):
    """A measured quantity.

    Attributes:
        name: what it is, for reports.
        columns: columns of the data, in order.
        unit: `m` or `rad`.
    """

    name: str
    columns: tuple[str, ...]
    unit: str

    @property
    def size(self) -> int:
        """Number of components of the difference."""
        return len(self.columns)

    @property
    def noise(self) -> str:
        """The name of the group that has one standard deviation."""
        return self.unit

    @abstractmethod
    def difference(self, posed: PosedRows, measured: Array) -> Array:
        """Model minus measurement (N, size); NaN where the measurement is missing.

        Args:
            posed: closed states, N rows.
            measured: the columns (N, columns).
        """

    def predicted(self, posed: PosedRows) -> Array:
        """The columns (N, columns) that the model predicts."""
        shape = (posed.count, len(self.columns))
        return self.difference(posed, np.zeros(shape))


@dataclass(frozen=True)
class Point(Quantity):
    """Coordinates of the origin of a frame."""

    frame: str
    axes: tuple[int, ...]

    def difference(self, posed: PosedRows, measured: Array) -> Array:
        """Differences along the measured axes [m]."""
        _, origin = posed.frame(self.frame)
        predicted = origin[:, self.axes]
        return np.asarray(predicted - measured)


@dataclass(frozen=True)
class Orientation(Quantity):
    """The orientation of a frame, as a quaternion x, y, z, w."""

    frame: str

    @property
    def size(self) -> int:
        """A rotation vector."""
        return 3

    def predicted(self, posed: PosedRows) -> Array:
        """The quaternions (N, 4)."""
        rotation, _ = posed.frame(self.frame)
        return quaternion(rotation)

    def difference(self, posed: PosedRows, measured: Array) -> Array:
        """The rotation vector from the measured to the predicted orientation (N, 3) [rad]."""
        rotation, _ = posed.frame(self.frame)
        norms = np.linalg.norm(measured, axis=1)
        unit = measured / norms[:, None]
        x, y, z, w = unit.T
        rows = np.array(rotation_matrix((x, y, z, w)))
        transposed = np.transpose(rows, (2, 1, 0))
        return rotation_vectors(rotation @ transposed)


@dataclass(frozen=True)
class Coordinate(Quantity):
    """A coordinate with an encoder of its own."""

    index: int

    @property
    def noise(self) -> str:
        """Encoders of one unit are alike, and others than what measures the tool."""
        return f"encoders [{self.unit}]"

    def difference(self, posed: PosedRows, measured: Array) -> Array:
        """Difference of the coordinate; angles within half a turn."""
        closed = posed.closed
        gain = closed.geometry.gains[self.index]
        predicted = closed.s[:, [self.index]]
        difference: Array = predicted - gain * measured
        if self.unit == "rad":
            difference -= TURN * np.rint(difference / TURN)
        return difference


@dataclass(frozen=True)
class Distance(Quantity):
    """The distance between the origins of two frames."""

    first: str
    second: str

    def difference(self, posed: PosedRows, measured: Array) -> Array:
        """Difference of the distance [m]."""
        _, one = posed.frame(self.first)
        _, other = posed.frame(self.second)
        length = np.linalg.norm(one - other, axis=1)
        return np.asarray(length[:, None] - measured)


@dataclass(frozen=True)
class Inclination(Quantity):
    """The angle of an axis of a frame above the horizontal."""

    frame: str
    axis: int
    up: tuple[float, float, float]

    def difference(self, posed: PosedRows, measured: Array) -> Array:
        """Difference of the angle [rad]."""
        rotation, _ = posed.frame(self.frame)
        direction = rotation[:, :, self.axis]
        up = np.array(self.up)
        along = direction @ up
        sideways = np.cross(direction, up)
        across = np.linalg.norm(sideways, axis=1)
        angle = np.arctan2(along, across)
        return np.asarray(angle[:, None] - measured)


def rotation_vectors(rotation: Array) -> Array:
    """Rotation vectors (N, 3) [rad] of rotations (N, 3, 3)."""
    skew = rotation - np.swapaxes(rotation, 1, 2)
    x = skew[:, 2, 1]
    y = skew[:, 0, 2]
    z = skew[:, 1, 0]
    axis = 0.5 * np.stack([x, y, z], axis=1)
    sine = np.linalg.norm(axis, axis=1)
    trace = np.trace(rotation, axis1=1, axis2=2)
    cosine = 0.5 * (trace - 1.0)
    angle = np.arctan2(sine, cosine)
    is_turned = sine > SMALL
    ratio = angle / np.maximum(sine, SMALL)
    factor = np.where(is_turned, ratio, 1.0)
    vectors: Array = factor[:, None] * axis
    for row in np.flatnonzero((sine < HALF_TURN) & (cosine < 0.0)):
        vectors[row] = angle[row] * _half_turn_axis(rotation[row], axis[row])
    return vectors


def _half_turn_axis(rotation: Array, along: Array) -> Array:
    """The axis (3,) of a rotation by nearly half a turn, on the side of a vector (3,)."""
    products = 0.5 * (rotation + rotation.T) + np.eye(3)
    column = products[:, np.argmax(np.diag(products))]
    axis: Array = column / np.linalg.norm(column)
    if axis @ along < 0.0:
        return -axis
    return axis
