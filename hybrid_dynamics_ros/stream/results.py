"""Results of one sample, or of rows of samples."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import ClosedState, Loads, Pose, Robot
from hybrid_dynamics_core.errors import SingularityError

from ..messages.joint_samples import FloatArray, OrderedMotion
from .estimates.payload import PayloadInput, Windows
from .estimates.tool_force import Residue, ToolForceInput
from .filter.filter import StampEvent

OneOrRows = Any  # a number for one sample, an array (N,) for rows


@dataclass(eq=False)
class MotionResult:
    """The result of one sample, or of N rows with the same known quantities.

    Coordinates are in the order of `robot.coordinates`. Those of ball and free joints are in the
    first chart in `position` and `velocity`, and in the chart of `state` in `active` and `efforts`.
    Arrays are read-only, with a leading N for rows.

    Attributes:
        robot, loads: robot and loads of the computation.
        stamp_ns: stamp of the sample [ns], (N,) for rows.
        active: motion of the active joints, as far as known.
        position: all coordinates, active then passive, (n_s,) [rad or m].
        velocity: rates of all coordinates, (n_s,) [rad/s or m/s]; None if unknown.
        efforts: efforts of the active joints (n,) [N m or N]; None if accelerations are unknown.
        residual: largest error of the loop equations, in lengths of the loop or [rad]; (N,) for
            rows.
        distances: distance of each loop to its nearest singularity, (loops,).
        branch: assembly mode of each loop by name, the same for all rows.
        event: event of the stamp; None if the filter was not used, and for rows.
        extras: joints that the robot does not have, or None; one entry for each row.
        measured_forces: forces of the drives (d,) [N] from pressures, NaN where unknown; None if
            all are unknown; (N, d) for rows.
        base_wrench: external wrench on a floating base (6,): force, then moment about its origin,
            in its axes [N, N m]; None if unknown; (N, 6) for rows.
        residue: what a momentum observer gives; None without measured forces or rates.
        windows: the newest motion, for weighing; None without measured forces or rates.
        make_state: builds `state` from the arrays above.
    """

    robot: Robot
    loads: Loads
    stamp_ns: OneOrRows
    active: OrderedMotion
    position: FloatArray
    velocity: FloatArray | None
    efforts: FloatArray | None
    residual: OneOrRows
    distances: FloatArray
    branch: Mapping[str, str]
    event: StampEvent | None
    make_state: Callable[[], ClosedState] = field(repr=False)
    extras: Any = None
    measured_forces: FloatArray | None = None
    base_wrench: FloatArray | None = None
    residue: Residue | None = None
    windows: Windows | None = None

    @cached_property
    def state(self) -> ClosedState:
        """The closed state, equal to the arrays above bit by bit but for other charts.

        If velocities are unknown, its rates are zero and meaningless.
        """
        return self.make_state()

    @property
    def nearest(self) -> tuple[OneOrRows, str]:
        """Distance to the nearest singularity and its loop; 1 and "" without loops.

        For rows it is the loop of the first.
        """
        if self.distances.ndim == 2:
            return self._nearest_of_rows()
        distances = self.distances.tolist()  # plain floats are faster, and every input needs it
        if not distances:
            return 1.0, ""
        least = min(distances)
        return least, self.robot.loops[distances.index(least)]

    def _nearest_of_rows(self) -> tuple[FloatArray, str]:
        if not self.robot.loops:
            return np.ones(len(self.distances)), ""
        return self.distances.min(axis=-1), self.robot.loops[int(np.argmin(self.distances[0]))]

    @cached_property
    def drive_forces(self) -> Mapping[str, OneOrRows] | None:
        """Force or torque of each drive [N m or N]; None if efforts are unknown.

        It is also None if the drives cannot give the efforts, for rows in any of them.
        """
        if self.efforts is None:
            return None
        try:
            return self.robot.drive_forces(self.state, self.efforts)
        except SingularityError:
            return None

    def observe(self, tool: ToolForceInput, scale: PayloadInput, in_file_modes: bool) -> None:
        """Let the inputs of estimates take the result, if it has forces and rates.

        Args:
            tool: momentum observer.
            scale: newest motion, for weighing.
            in_file_modes: whether the assembly modes are those of the robot file.
        """
        forces = self.measured_forces
        if forces is None or self.velocity is None:
            return
        state = self.state
        if self.position.ndim == 1:
            state = ClosedState.joined([state])
        stamps = np.atleast_1d(np.asarray(self.stamp_ns, dtype=np.int64))
        efforts = np.atleast_2d(forces)
        self.residue = tool.take(stamps, state, efforts, self.loads)
        given = (stamps, state.u, efforts, self.loads)
        self.windows = scale.take(*given, in_file_modes=in_file_modes)

    @cached_property
    def pose(self) -> Pose:
        """Pose of the end effector in the base frame."""
        return self.robot.forward_kinematics(self.state)

    def rows(self, which: NDArray[np.intp]) -> MotionResult:
        """Some of the N rows, in the order of `which`; the result itself for all rows."""
        if len(which) == len(self.position):
            return self
        active = self.active
        return replace(
            self,
            stamp_ns=self.stamp_ns[which],
            active=OrderedMotion(
                active.position[which],
                _rows_of(active.velocity, which),
                _rows_of(active.acceleration, which),
            ),
            position=self.position[which],
            velocity=_rows_of(self.velocity, which),
            efforts=_rows_of(self.efforts, which),
            residual=self.residual[which],
            distances=self.distances[which],
            make_state=lambda: self.state.rows(which),
            measured_forces=_rows_of(self.measured_forces, which),
            base_wrench=_rows_of(self.base_wrench, which),
            residue=None if self.residue is None else self.residue.rows(which),
            windows=None if self.windows is None else self.windows.rows(which),
            extras=None if self.extras is None else [self.extras[k] for k in which.tolist()],
        )

    def goes_with(self, other: MotionResult) -> bool:
        """Whether two results can be merged as rows."""
        return self._given == other._given and self.branch == other.branch

    @property
    def _given(self) -> tuple[bool, bool, bool]:
        """Whether velocity, acceleration and efforts are known."""
        acceleration = self.active.acceleration
        return self.velocity is not None, acceleration is not None, self.efforts is not None

    @staticmethod
    def joined(results: Sequence[MotionResult]) -> MotionResult:
        """Merge compatible results of single samples as rows."""
        extras = [result.extras for result in results]
        return replace(
            results[0],
            stamp_ns=np.array([result.stamp_ns for result in results], dtype=np.int64),
            active=OrderedMotion(
                np.array([result.active.position for result in results]),
                _stacked([result.active.velocity for result in results]),
                _stacked([result.active.acceleration for result in results]),
            ),
            position=np.array([result.position for result in results]),
            velocity=_stacked([result.velocity for result in results]),
            efforts=_stacked([result.efforts for result in results]),
            residual=np.array([result.residual for result in results]),
            distances=np.array([result.distances for result in results]),
            event=None,
            extras=extras if any(extras) else None,
            base_wrench=_stacked([result.base_wrench for result in results]),
            make_state=lambda: ClosedState.joined([result.state for result in results]),
        )


def _rows_of(values: FloatArray | None, which: NDArray[np.intp]) -> FloatArray | None:
    return None if values is None else values[which]


def _stacked(values: Sequence[FloatArray | None]) -> FloatArray | None:
    return None if values[0] is None else np.array(values)
