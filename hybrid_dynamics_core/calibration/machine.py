"""The geometry of a robot as a function of free parameters, and its closed states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..algebra.independence import independent_rows
from ..algebra.transform import IDENTITY, compose
from ..closed_state.state import ClosedState
from ..closure.constraints.equations import LoopEquations
from ..closure.constraints.from_description import loop_equations
from ..description.geometry import Transform, rotation_from_rpy
from ..description.model import Frame, RobotDescription
from ..errors import InputError, StateError
from ..ground.arrays import Array
from ..mechanism.configuration import Configuration, given_configuration
from ..mechanism.joint_transform import joint_transforms, poses_in_base
from ..mechanism.tree import Tree, build_tree, frame_offset
from ..robot.robot import Robot
from .adjustable import AdjustableRobot, FreeParameter
from .loop_choices import LoopChoices, with_general_bars

CLOSED = 1e-10  # largest gap of closed loops, in lengths of the loop or rad
SETTLED = 1e-13  # largest step [m or rad] of an iteration that has converged
MAX_ITERATIONS = 12
RANK = 1e-9  # singular values below this share of the largest count as zero
INDEPENDENT = 1e-3  # part of a coordinate's row that others may not give


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

    def linearised(self, s: Array, charts: Sequence[Array]) -> tuple[Array, Array]:
        """Gaps (N, m) of all equations and their Jacobian (N, m, n_s) at s (N, n_s)."""
        configuration = self.configuration(s, charts)
        count = len(s)
        gaps: list[Array] = []
        rows: list[Array] = []
        for loop in self.loops:
            entries, residual = loop.linearise(configuration)
            for entry, value in zip(entries, residual, strict=True):
                gaps.append(_column(value, count))
                row = np.zeros((count, s.shape[1]))
                for k, coefficient in entry.items():
                    row[:, k] = coefficient
                rows.append(row)
        if not gaps:
            return np.zeros((count, 0)), np.zeros((count, 0, s.shape[1]))
        return np.stack(gaps, axis=1), np.stack(rows, axis=1)

    def configuration(self, s: Array, charts: Sequence[Array]) -> Configuration:
        """The configurations of rows s (N, n_s)."""
        values = {k: s[:, k].copy() for k in range(s.shape[1])}
        return given_configuration(self.tree, values, tuple(charts) or None)


def _column(value: Any, count: int) -> Array:
    """A scalar or (N,) as (N,)."""
    return np.broadcast_to(np.asarray(value, dtype=float), (count,))


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
        configuration = self.geometry.configuration(self.s, self.charts)
        transforms = joint_transforms(self.geometry.tree, configuration)
        return PosedRows(self, tuple(poses_in_base(self.geometry.tree, transforms)))


@dataclass(frozen=True, eq=False)
class PosedRows:
    """Closed states with the poses of all bodies in the base."""

    closed: ClosedRows
    bodies: tuple[Any, ...]

    def frame(self, name: str) -> tuple[Array, Array]:
        """Rotation (N, 3, 3) and origin (N, 3) [m] of a frame in the measuring frame."""
        geometry = self.closed.geometry
        frame = geometry.frames[name]
        index = geometry.tree.body_index(frame.link)
        pose = IDENTITY
        if index >= 0:
            pose = self.bodies[index]
        rotation, origin = compose(pose, frame_offset(frame))
        count = len(self.closed.s)
        matrix = np.stack([_vectors(row, count) for row in rotation], axis=1)
        base = geometry.base
        turned = base.rotation @ matrix
        placed = _vectors(origin, count) @ base.rotation.T + base.translation
        return turned, placed

    def extent(self) -> float:
        """Largest distance of a joint or of the end effector from the base [m]."""
        count = len(self.closed.s)
        sizes = [0.0]
        for _, origin in self.bodies:
            lengths = np.linalg.norm(_vectors(origin, count), axis=1)
            sizes.append(float(lengths.max(initial=0.0)))
        return max(sizes)


def _vectors(vector: Any, count: int) -> Array:
    """Three scalars or (N,) as (N, 3)."""
    return np.stack([_column(component, count) for component in vector], axis=1)


class Machine:
    """A robot with free parameters.

    Attributes:
        adjustable: its descriptions.
        parameters: the free parameters, k of them.
        robot: the robot as it is in the file.
        start: values of the parameters in the file (k,) [rad, m].
    """

    def __init__(self, adjustable: AdjustableRobot, parameters: Sequence[FreeParameter]) -> None:
        self.adjustable = adjustable
        self.parameters = tuple(parameters)
        self.start = np.array([parameter.start for parameter in parameters])
        self.robot = adjustable.robot
        self._nominal = self.robot.description
        self._choices = LoopChoices(adjustable, self.parameters, self._nominal)

    def geometry(self, values: Array) -> Geometry:
        """The geometry for values (k,) of the parameters.

        Raises:
            DescriptionError: a value is impossible.
        """
        description = self.adjustable.described(self.parameters, values.tolist())
        description = self._choices.applied(self._as_nominal(description))
        tree = build_tree(description)
        loops = loop_equations(tree, description, frozenset())
        frames = {**{name: Frame(name) for name in description.links}, **description.frames}
        gains = np.ones(len(tree.coordinates))
        pose = {"xyz": np.zeros(3), "rpy": np.zeros(3)}
        for parameter, value in zip(self.parameters, values, strict=True):
            if parameter.place == "gain":
                gains[tree.coordinates.index(str(parameter.path[0]))] = value
            elif parameter.place == "base":
                key, k = parameter.path
                pose[str(key)][int(k)] = value
        base = Transform(rotation_from_rpy(*pose["rpy"].tolist()), pose["xyz"])
        return Geometry(tree, tuple(loops), frames, base, gains)

    def _as_nominal(self, description: RobotDescription) -> RobotDescription:
        """The description with the choices of the loader: coordinates, charts, assembly modes."""
        nominal = self._nominal
        modes = {closure.name: closure.assembly for closure in nominal.closures}
        closures = tuple(
            replace(closure, assembly=modes[closure.name]) for closure in description.closures
        )
        return replace(
            description,
            closures=closures,
            active=nominal.active,
            idle=nominal.idle,
            active_set=nominal.active_set,
            charts=nominal.charts,
            reference=nominal.reference,
        )

    # -- coordinates

    def given_among(self, names: Sequence[str]) -> tuple[str, ...]:
        """The coordinates, of some, from which the loops are closed: the active ones if possible.

        Raises:
            InputError: the names do not determine the configuration.
        """
        robot = self.robot
        missing = [name for name in robot.active if name not in names]
        if not missing:
            return robot.active
        geometry = self.geometry(self.start)
        reference = robot.close(robot.reference[None]).s
        _, jacobian = geometry.linearised(reference, ())
        motions = _null_space(jacobian[0])
        present = [name for name in robot.coordinates if name in names]
        rows = motions[[robot.coordinates.index(name) for name in present]]
        chosen = independent_rows(rows, range(len(rows)), INDEPENDENT)
        if len(chosen) == len(robot.active):
            return tuple(present[k] for k in chosen)
        listed = ", ".join(missing)
        raise InputError(
            f"there is no column {listed}; expected a column for each of {', '.join(robot.active)}"
        )

    def closed_at(
        self, values: Array, given: Sequence[str], readings: Mapping[str, Array]
    ) -> ClosedRows:
        """The closed states for values (k,) of the parameters.

        Args:
            values: the parameters [rad, m].
            given: the coordinates that are given.
            readings: readings of their encoders (N,) [rad, m].

        Raises:
            StateError: a row does not close.
        """
        robot = self.robot
        if not np.array_equal(values, self.start):
            description = self.adjustable.described(self.parameters, values)
            robot = Robot(with_general_bars(description, self.robot))
        geometry = self.geometry(values)
        coordinates: dict[str, Array] = {}
        for name in given:
            gain = geometry.gains[robot.coordinates.index(name)]
            coordinates[name] = gain * readings[name]
        if tuple(given) == robot.active:
            state = robot.close(np.stack(list(coordinates.values()), axis=1))
        else:
            state = robot.close_given(coordinates)
        return ClosedRows(geometry, np.array(state.s), charts_of(robot, state))

    def open_rows(self, given: Sequence[str], readings: Mapping[str, Array]) -> list[int]:
        """Indices of rows that do not close with the robot of the file."""
        rows: list[int] = []
        count = len(readings[given[0]])
        for row in range(count):
            one = {name: values[row : row + 1] for name, values in readings.items()}
            try:
                self.closed_at(self.start, given, one)
            except StateError:
                rows.append(row)
        return rows


def charts_of(robot: Robot, state: ClosedState) -> tuple[Array, ...]:
    """Charts of the ball and free joints of closed rows, (N,) each."""
    joints = len(robot.description.freely_turning)
    blocks = np.shape(state.signs)[-1] - joints
    signs = np.broadcast_to(state.signs, (len(state.s), blocks + joints))
    return tuple(signs[:, blocks:].T.astype(float))


def _null_space(matrix: Array) -> Array:
    """An orthonormal basis (n, n - rank) of the null space of a matrix (m, n)."""
    _, values, right = np.linalg.svd(matrix)
    largest = float(values.max(initial=0.0))
    rank = int((values > RANK * largest).sum())
    return np.asarray(right[rank:].T)


def closed_near(geometry: Geometry, start: ClosedRows, given: Array, readings: Array) -> ClosedRows:
    """Close the loops of another geometry, from states of a similar one.

    Args:
        geometry: the geometry.
        start: closed states of a similar geometry.
        given: indices of the given coordinates (n,).
        readings: readings of their encoders (N, n) [rad, m].

    Raises:
        OpenLoopError: some rows do not close.
    """
    s = start.s.copy()
    s[:, given] = readings * geometry.gains[given]
    unknowns = np.setdiff1d(np.arange(s.shape[1]), given)
    gaps = np.zeros((len(s), 0))
    for _ in range(MAX_ITERATIONS):
        gaps, jacobian = geometry.linearised(s, start.charts)
        if not np.isfinite(gaps).all():
            break
        step = steps(jacobian[:, :, unknowns], gaps)
        s[:, unknowns] -= step
        if np.abs(step).max(initial=0.0) < SETTLED:
            break
    gaps, _ = geometry.linearised(s, start.charts)
    is_closed = np.abs(gaps).max(axis=1, initial=0.0) < CLOSED
    if not is_closed.all():
        raise OpenLoopError(np.flatnonzero(~is_closed).tolist())
    return ClosedRows(geometry, s, start.charts)


def steps(jacobian: Array, gaps: Array) -> Array:
    """The least-squares steps (N, z) of J (N, m, z) step = gaps (N, m)."""
    if not jacobian.size:
        return np.zeros((len(gaps), jacobian.shape[2]))
    if jacobian.shape[1] == jacobian.shape[2]:
        try:
            return np.asarray(np.linalg.solve(jacobian, gaps[..., None])[..., 0])
        except np.linalg.LinAlgError:
            pass
    inverse = np.linalg.pinv(jacobian, rcond=RANK)
    return np.asarray((inverse @ gaps[..., None])[..., 0])
