"""What one sample, or many rows of samples, say about the robot."""

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
from .filter.filter import StampEvent

OneOrRows = Any  # of one sample a number, of N rows an array (N,)


@dataclass(eq=False)
class MotionResult:
    """All that one sample says about the robot, or N rows of samples of which the same is known.

    Coordinates are in the order of ``robot.coordinates``. Those of a floating base are in the first
    chart in `position` and `velocity`, and in that of `state` in `active` and `efforts`. Arrays are
    read-only; of N rows each has a leading N.

    Attributes:
        robot, loads: what the result was computed with.
        stamp_ns: stamp of the sample [ns]; of rows (N,).
        active: motion of the active joints, rates and accelerations as far as they are known.
        position: all coordinates, active then passive, (n_s,) [rad or m].
        velocity: rates of all coordinates, (n_s,) [rad/s or m/s]; None until they are known.
        efforts: what the active joints must give, (n,) [N m or N]; None until accelerations are
            known.
        residual: largest error of the loop equations, in lengths of the loop or [rad]; of rows
            (N,).
        distances: of each loop to its nearest singularity, (loops,).
        branch: assembly mode of each loop by name, the same for all rows.
        event: what the stamp meant to the filter; None where it was not asked, and of rows.
        extras: joints beside those of the robot, of rows one for each, or None.
        measured_forces: of the drives (d,) [N], from pressures; NaN where there are none, and None
            where there are none of any drive; of rows (N, d), NaN there.
        base_wrench: what has to act on a floating base from outside (6,): force, then moment about
            its origin, in its axes [N, N m]; None where it is not known; of rows (N, 6).
        make_state: makes `state` of what was computed for the arrays above.
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

    @cached_property
    def state(self) -> ClosedState:
        """The loops, closed; the arrays above are its parts, to the last bit.

        Where velocities are not known its rates are zero and say nothing.
        """
        return self.make_state()

    @property
    def nearest(self) -> tuple[OneOrRows, str]:
        """Distance to the nearest singularity, and its loop; 1 and "" without loops.

        Of rows it is the loop of the first.
        """
        if self.distances.ndim == 2:
            return self._nearest_of_rows()
        distances = self.distances.tolist()  # in plain floats, as every input asks for it
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
        """What each drive must give [N m or N]; None before efforts are known.

        None also where the drives, as they stand, cannot give the efforts; of rows: of one of them.
        """
        if self.efforts is None:
            return None
        try:
            return self.robot.drive_forces(self.state, self.efforts)
        except SingularityError:
            return None

    @cached_property
    def pose(self) -> Pose:
        """End effector in the base frame."""
        return self.robot.forward_kinematics(self.state)

    def rows(self, which: NDArray[np.intp]) -> MotionResult:
        """Some of the N rows, in the order of `which`; the result itself where those are all."""
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
            extras=None if self.extras is None else [self.extras[k] for k in which.tolist()],
        )

    def goes_with(self, other: MotionResult) -> bool:
        """Whether both can be rows of one result."""
        return self._given == other._given and self.branch == other.branch

    @property
    def _given(self) -> tuple[bool, bool, bool]:
        """Whether velocity, acceleration and efforts are there."""
        acceleration = self.active.acceleration
        return self.velocity is not None, acceleration is not None, self.efforts is not None

    @staticmethod
    def joined(results: Sequence[MotionResult]) -> MotionResult:
        """Results of single samples that go together, as rows."""
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
