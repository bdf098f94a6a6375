"""What one sample says about the robot."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from hybrid_dynamics_core import ClosedState, Loads, Pose, Robot

from ..messages.joint_samples import ActiveMotion, FloatArray
from .filter.filter import StampEvent


@dataclass(eq=False)
class MotionResult:
    """All that one sample says about the robot. Coordinates are in the order of ``robot.coordinates``.

    Never changed: arrays are read-only.

    Attributes:
        robot, loads: what the result was computed with.
        stamp_ns: stamp of the sample [ns].
        active: motion of the active joints, for which all was computed; rates and accelerations as
        far as known.
        position: all coordinates, active then passive, (n_s,) [rad or m].
        velocity: rates of all coordinates, (n_s,) [rad/s or m/s]; None until they are known.
        efforts: what the active joints must give, (n,) [N m or N]; None until the filter has its
        samples.
        residual: largest error of the loop equations, in lengths of the loop or [rad].
        distances: of each loop to its nearest singularity, (loops,).
        branch: assembly mode of each loop by name.
        event: what the stamp meant to the filter; None where it was not asked.
        make_state: makes `state` of what was computed for the arrays above.
    """

    robot: Robot
    loads: Loads
    stamp_ns: int
    active: ActiveMotion
    position: FloatArray
    velocity: FloatArray | None
    efforts: FloatArray | None
    residual: float
    distances: FloatArray
    branch: Mapping[str, str]
    event: StampEvent | None
    make_state: Callable[[], ClosedState] = field(repr=False)

    @property
    def moving(self) -> bool:
        """Whether rates are known; if not, those of ``state`` are zero and say nothing."""
        return self.active.velocity is not None

    @cached_property
    def state(self) -> ClosedState:
        """The loops, closed; the arrays above are its own, to the last bit."""
        return self.make_state()

    @property
    def nearest(self) -> tuple[float, str]:
        """Distance to the nearest singularity, and the loop it is of; 1 and "" for a robot without loops."""
        distances = self.distances.tolist()
        if not distances:
            return 1.0, ""
        least = min(distances)
        return least, self.robot.loops[distances.index(least)]

    @cached_property
    def pose(self) -> Pose:
        """End effector in the base frame."""
        return self.robot.forward_kinematics(self.state)
