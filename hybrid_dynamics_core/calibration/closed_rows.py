"""Closed states of one geometry, a row each, on arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..algebra.transform import IDENTITY, compose
from ..closure.constraints.equations import LoopEquations
from ..description.geometry import Transform
from ..description.model import Frame
from ..ground.arrays import Array
from ..mechanism.configuration import Configuration, given_configuration
from ..mechanism.joint_transform import joint_transforms, poses_in_base
from ..mechanism.tree import Tree, frame_offset

CLOSED = 1e-10  # largest gap of closed loops, in lengths of the loop or rad
SETTLED = 1e-13  # largest step [m or rad] of an iteration that has converged
MAX_ITERATIONS = 12
RANK = 1e-9  # singular values below this share of the largest count as zero

Charts = Sequence[Array]  # charts of ball and free joints, (N,) each


class OpenLoopError(ArithmeticError):
    """Loops do not close for some values of the parameters.

    Attributes:
        rows: the rows that stay open.
    """

    def __init__(self, rows: list[int]) -> None:
        self.rows = rows
        super().__init__(f"the loops of {len(rows)} rows do not close")


@dataclass(frozen=True, eq=False)
class Geometry:
    """A robot with some values of its parameters.

    Attributes:
        tree: its spanning tree.
        loops: equations of its loops.
        frames: frames by name.
        base: pose of the base in the measuring frame.
        gains: gain of each encoder (n_s,).
    """

    tree: Tree
    loops: tuple[LoopEquations, ...]
    frames: Mapping[str, Frame]
    base: Transform
    gains: Array

    def linearised(self, s: Array, charts: Charts) -> tuple[Array, Array]:
        """Gaps (N, m) of all equations and their Jacobian (N, m, n_s) at s (N, n_s)."""
        count, size = s.shape
        configuration = self.configuration(s, charts)
        gaps: list[Array] = [np.zeros((0, count))]
        rows: list[Array] = [np.zeros((0, count, size))]
        for loop in self.loops:
            entries, residual = loop.linearise(configuration)
            for entry, value in zip(entries, residual, strict=True):
                gap = _column(value, count)
                row = np.zeros((count, size))
                for k, coefficient in entry.items():
                    row[:, k] = coefficient
                gaps.append(gap[None])
                rows.append(row[None])
        all_gaps = np.concatenate(gaps)
        all_rows = np.concatenate(rows)
        return all_gaps.T, np.moveaxis(all_rows, 0, 1)

    def configuration(self, s: Array, charts: Charts) -> Configuration:
        """The configurations of rows s (N, n_s)."""
        values = dict(enumerate(s.T.copy()))
        if not charts:
            return given_configuration(self.tree, values)
        return given_configuration(self.tree, values, tuple(charts))


def _column(value: Any, count: int) -> Array:
    """A scalar or (N,) as (N,)."""
    array = np.asarray(value, dtype=float)
    return np.broadcast_to(array, (count,))


@dataclass(frozen=True, eq=False)
class ClosedRows:
    """Closed states, a row each.

    Attributes:
        geometry: the robot.
        s: all coordinates (N, n_s) [rad, m].
        charts: charts of ball and free joints, (N,) each.
    """

    geometry: Geometry
    s: Array
    charts: tuple[Array, ...]

    def poses(self) -> PosedRows:
        """Poses of all bodies."""
        tree = self.geometry.tree
        configuration = self.geometry.configuration(self.s, self.charts)
        transforms = joint_transforms(tree, configuration)
        bodies = poses_in_base(tree, transforms)
        return PosedRows(self, tuple(bodies))


@dataclass(frozen=True, eq=False)
class PosedRows:
    """Closed states with the poses of all bodies in the base."""

    closed: ClosedRows
    bodies: tuple[Any, ...]

    @property
    def count(self) -> int:
        """Number of rows."""
        return len(self.closed.s)

    def frame(self, name: str) -> tuple[Array, Array]:
        """Rotation (N, 3, 3) and origin (N, 3) [m] of a frame in the measuring frame."""
        rotation, origin = self._in_base(name)
        rows = [self._vectors(row) for row in rotation]
        matrix = np.stack(rows, axis=1)
        base = self.closed.geometry.base
        turned = base.rotation @ matrix
        placed = self._vectors(origin) @ base.rotation.T
        return turned, placed + base.translation

    def extent(self) -> float:
        """Largest distance of a joint or frame from the base [m]; 1 if all are at its origin."""
        origins = [origin for _, origin in self.bodies]
        origins += [self._in_base(name)[1] for name in self.closed.geometry.frames]
        largest = 0.0
        for origin in origins:
            lengths = np.linalg.norm(self._vectors(origin), axis=1)
            largest = max(largest, float(lengths.max()))
        return largest or 1.0

    def _in_base(self, name: str) -> Any:
        """Rotation and origin of a frame in the base frame."""
        geometry = self.closed.geometry
        frame = geometry.frames[name]
        index = geometry.tree.body_index(frame.link)
        pose = IDENTITY
        if index >= 0:
            pose = self.bodies[index]
        return compose(pose, frame_offset(frame))

    def _vectors(self, vector: Any) -> Array:
        """Three scalars or (N,) as (N, 3)."""
        columns = [_column(component, self.count) for component in vector]
        return np.stack(columns, axis=1)


def closed_near(geometry: Geometry, start: ClosedRows, given: Array, values: Array) -> ClosedRows:
    """Close the loops of another geometry, from states of a similar one.

    Args:
        geometry: the geometry.
        start: closed states of a similar geometry.
        given: indices of the given coordinates (n,).
        values: their values (N, n) [rad, m].

    Raises:
        OpenLoopError: some rows do not close.
    """
    charts = start.charts
    s = start.s.copy()
    s[:, given] = values
    unknowns = others(given, s)
    for _ in range(MAX_ITERATIONS):
        gaps, jacobian = geometry.linearised(s, charts)
        if not np.isfinite(gaps).all():
            break
        step = _steps(jacobian[:, :, unknowns], gaps)
        s[:, unknowns] -= step
        largest = np.abs(step).max(initial=0.0)
        if largest < SETTLED:
            break
    gaps, _ = geometry.linearised(s, charts)
    sizes = np.abs(gaps).max(axis=1, initial=0.0)
    is_open = ~(sizes < CLOSED)
    if is_open.any():
        raise OpenLoopError(np.flatnonzero(is_open).tolist())
    return ClosedRows(geometry, s, charts)


def others(given: Array, s: Array) -> Array:
    """Indices of the coordinates, of rows s (N, n_s), that are not given."""
    everything = np.arange(s.shape[1])
    return np.setdiff1d(everything, given)


def _steps(jacobian: Array, gaps: Array) -> Array:
    """The least-squares steps (N, z) of J (N, m, z) step = gaps (N, m)."""
    _, equations, unknowns = jacobian.shape
    if equations == unknowns:
        try:
            steps: Array = np.linalg.solve(jacobian, gaps[..., None]).astype(float)
            return steps[..., 0]
        except np.linalg.LinAlgError:
            pass  # some row is singular: the shortest step there
    return applied(inverse_of(jacobian), gaps)


def inverse_of(jacobian: Array) -> Array:
    """The pseudo-inverses (N, z, m) of (N, m, z)."""
    inverse = np.linalg.pinv(jacobian, rcond=RANK)
    return np.asarray(inverse, dtype=float)


def applied(matrices: Array, vectors: Array) -> Array:
    """Products (N, m) of matrices (N, m, z) and vectors (N, z)."""
    products: Array = matrices @ vectors[..., None]
    return products[..., 0]
