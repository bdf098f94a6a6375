"""Which coordinates a set of sensors determines, at rest and in motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..closed_state.state import ClosedState, ClosureStatus
from ..errors import InputError
from ..ground.arrays import Array
from ..robot.robot import Robot
from .motion_model import ORDERS, MotionModel
from .sensors import Sensor

POSES = 3  # at which the rank is taken, the first one included
NEARBY = 0.05  # share of a range by which they differ; for coordinates without limits [rad, m]
INSTANTS = 7  # of the readings that are laid together
RANK = 1e-8  # singular values below this share of the largest count as zero
SHARE = 1e-5  # of a coordinate in the motions that nothing shows, up to which it is determined


class ObservabilityError(InputError):
    """A set of sensors does not determine the state.

    Attributes:
        undetermined: names of active coordinates that the sensors do not determine.
    """

    def __init__(
        self,
        message: str,
        undetermined: tuple[str, ...],
    ) -> None:
        super().__init__(message)
        self.undetermined = undetermined


@dataclass(frozen=True)
class Observability:
    """What a set of sensors determines.

    Constant errors count as given, since sensors state how large they are.

    Attributes:
        at_rest: active coordinates that readings at rest determine.
        in_motion: active coordinates that readings of a motion determine.
        undetermined: the other active coordinates.
        rank: number of independent directions of [u; u'] that a motion shows, at most 2 n.
        size: 2 n.
    """

    at_rest: tuple[str, ...]
    in_motion: tuple[str, ...]
    undetermined: tuple[str, ...]
    rank: int
    size: int

    def require(self) -> None:
        """Raise ObservabilityError if a coordinate is not determined."""
        if not self.undetermined:
            return
        names = ", ".join(self.undetermined)
        raise ObservabilityError(
            f"the sensors do not determine {names}: rank {self.rank} of {self.size}. Add a sensor"
            " that these coordinates change, as an encoder or a stroke sensor; gyros show rates"
            " alone, and accelerometers no turning about the vertical",
            self.undetermined,
        )


def observability(
    robot: Robot,
    sensors: Sequence[Sensor],
    model: MotionModel,
    u: Array | None = None,
) -> Observability:
    """Which active coordinates a set of sensors determines near a pose.

    Args:
        robot: the robot.
        sensors: its sensors.
        model: how it may move.
        u: active coordinates (n,) [rad, m]; the reference if None.
    """
    n = model.n
    rng = np.random.default_rng(1)
    at_rest = np.zeros(n, dtype=bool)
    in_motion = np.zeros(n, dtype=bool)
    rank = 0
    for state in _poses(robot, u, rng):
        still = np.zeros(ORDERS * n)
        still[:n] = state.u
        shown, _ = _determined(sensors, model, state, still)
        at_rest |= shown
        speeds = model.time * model.accelerations * rng.uniform(-1.0, 1.0, n)
        accelerations = model.accelerations * rng.uniform(-1.0, 1.0, n)
        moving = np.concatenate([state.u, speeds, accelerations])
        shown, directions = _determined(sensors, model, state, moving)
        in_motion |= shown
        rank = max(rank, directions)
    names = np.array(robot.active)
    in_motion |= at_rest
    return Observability(
        tuple(names[at_rest].tolist()),
        tuple(names[in_motion].tolist()),
        tuple(names[~in_motion].tolist()),
        rank,
        2 * n,
    )


def _poses(
    robot: Robot,
    u: Array | None,
    rng: np.random.Generator,
) -> list[ClosedState]:
    """Closed states near a pose: a rank is smaller at a few special ones."""
    start = robot.close(robot.reference if u is None else u)
    low, high = robot.limits.T
    size = np.where(np.isfinite(high - low), high - low, 1.0)
    states = [start]
    for _ in range(POSES - 1):
        near = start.u + NEARBY * size * rng.uniform(-1.0, 1.0, len(size))
        state = robot.close(np.clip(near, low, high), check=False, near=start)
        if state.status is ClosureStatus.OK:
            states.append(state)
    return states


def _determined(
    sensors: Sequence[Sensor],
    model: MotionModel,
    start: ClosedState,
    motion: Array,
) -> tuple[np.ndarray, int]:
    """Whether readings of a motion determine each coordinate (n,), and the rank of [u; u']."""
    n = model.n
    rows: list[Array] = []
    near = start
    robot = sensors[0].robot
    for time in np.linspace(0.0, model.time / 4.0, INSTANTS).tolist():
        transition = model.transition(time)
        u, du, ddu = (transition @ motion).reshape(ORDERS, n)
        state = robot.close(u, du, check=False, near=near)
        if state.status is not ClosureStatus.OK:
            break
        near = state
        for sensor in sensors:
            _, slopes = sensor.observe(state, ddu)
            rows.append(slopes @ transition / sensor.quality.noise)
    scales = np.tile(model.accelerations, ORDERS)
    table = np.concatenate(rows) * scales
    sizes = np.linalg.norm(table, axis=1)
    table = table[sizes > 0.0] / sizes[sizes > 0.0][:, None]
    if not len(table):
        return np.zeros(n, dtype=bool), 0
    _, singular, directions = np.linalg.svd(table)
    rank = int((singular > RANK * singular[0]).sum())
    unseen = directions[rank:]
    shares = np.linalg.norm(unseen[:, :n], axis=0)
    of_state = np.linalg.matrix_rank(unseen[:, : 2 * n], tol=SHARE) if len(unseen) else 0
    return shares < SHARE, 2 * n - int(of_state)
