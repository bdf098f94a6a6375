"""A lifting chart: the mass that drives hold at rest, over the places of a frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from ..description.effects import Payload
from ..dynamics.loads import Loads
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arrays import finite_vectors
from ..ground.suggestions import no_such_name
from ..kinematics.closed_kinematics import ClosedKinematics
from ..kinematics.workspace import SampleStatus, margins_at
from .box_image import solutions
from .capability import Machine, largest, limits_of

CELLS = 36  # states along each of the two joints


class LiftingMachine(Machine, ClosedKinematics, Protocol):
    """What a lifting chart takes of a robot."""


@dataclass(frozen=True, eq=False)
class LiftingChart:
    """Lifted masses over two joints, in a grid of c by c states.

    Attributes:
        joints: names of the two joints that move.
        u: (c, c, n) active coordinates [rad, m].
        radius: (c, c) horizontal distance of the frame from the base's z axis [m]; NaN where the
            robot cannot be.
        height: (c, c) of the frame above the base's origin [m].
        mass: (c, c) the largest mass that the drives hold at rest [kg]; 0 where they do not hold
            the robot itself.
        limited_by: (c, c) index in `drives` of a drive at its limit; -1 without.
        drives: names of the drives.
        share: share of the lifted mass that counts.
        frame: name of the frame; None for the end effector.
    """

    joints: tuple[str, str]
    u: Array
    radius: Array
    height: Array
    mass: Array
    limited_by: np.ndarray
    drives: tuple[str, ...]
    share: float
    frame: str | None = None


def lifting_chart(
    machine: LiftingMachine,
    joints: tuple[str, str] | None = None,
    u: ArrayLike | None = None,
    frame: str | None = None,
    loads: Loads | None = None,
    share: float = 1.0,
) -> LiftingChart:
    """The lifting chart of a robot: its load hangs at a frame, at rest.

    Args:
        machine: the robot.
        joints: the two active joints that move; None: those that move the frame most up and out.
        u: (n,) where the other active joints stay; the reference if None.
        frame: name of the frame that carries the load; the end effector if None.
        loads: loads besides the actuators and this one; `robot.loads` if None.
        share: share of the lifted mass that counts, as 0.87 for excavators by ISO 10567.

    Raises:
        InputError: a name is unknown, or the robot is nowhere within its limits.
    """
    if not 0.0 < share <= 1.0:
        raise InputError(f"share is {share:g}; expected more than 0, up to 1")
    base = machine.reference if u is None else finite_vectors("u", u, machine.active, -1)
    pair = joints or moving_joints(machine, base, frame)
    points = _grid(machine, pair, base)
    flat = points.reshape(-1, len(base))
    # with the sampler of workspaces: closed, and all joints within limits and strokes
    valid = margins_at(machine, flat).status == SampleStatus.OK
    if not valid.any():
        raise InputError(
            f"{machine.name} is nowhere within its limits while {pair[0]} and {pair[1]} move; let"
            " the others stay elsewhere"
        )
    radius, height, mass = (np.full(len(flat), np.nan) for _ in range(3))
    drive = np.full(len(flat), -1)
    place, lifted, which = _lifted(machine, flat[valid], frame, loads)
    radius[valid] = np.hypot(place[:, 0], place[:, 1])
    height[valid] = place[:, 2]
    mass[valid] = share * lifted
    drive[valid] = which
    shape = points.shape[:2]
    return LiftingChart(
        joints=pair,
        u=points,
        radius=radius.reshape(shape),
        height=height.reshape(shape),
        mass=mass.reshape(shape),
        limited_by=drive.reshape(shape),
        drives=machine.all_drives,
        share=share,
        frame=frame,
    )


def moving_joints(machine: LiftingMachine, u: Array, frame: str | None) -> tuple[str, str]:
    """The two active joints that move a frame most up and out, over their ranges."""
    state = machine.close(u)
    place = machine.forward_kinematics(state, frame).position
    out = np.array([place[0], place[1], 0.0])
    size = float(np.linalg.norm(out))
    out = out / size if size > 0.0 else np.array([1.0, 0.0, 0.0])
    jacobian = machine.jacobian(state, frame)[:3]
    plane = np.stack([out, [0.0, 0.0, 1.0]]) @ jacobian
    ranges = np.nan_to_num(np.ptp(machine.limits, axis=1), posinf=1.0)
    travel = np.linalg.norm(plane, axis=0) * ranges
    order = np.argsort(-travel)
    if len(order) < 2 or travel[order[1]] < 1e-9:
        raise InputError("a lifting chart takes two joints that move the frame up and out")
    first, second = sorted(order[:2].tolist())
    return machine.active[first], machine.active[second]


def _grid(machine: LiftingMachine, pair: tuple[str, str], base: Array) -> Array:
    """(c, c, n) active coordinates."""
    for name in pair:
        if name not in machine.active:
            raise InputError(f"over: {no_such_name('active joint', name, machine.active)}")
    if pair[0] == pair[1]:
        raise InputError(f"over: expected two different joints, got {pair[0]} twice")
    lines: list[Array] = []
    for name in pair:
        k = machine.active.index(name)
        lower, upper = machine.limits[k].tolist()
        if not np.isfinite(upper - lower):
            lower, upper = base[k] - np.pi, base[k] + np.pi
        inset = 1e-6 * (upper - lower)
        lines.append(np.linspace(lower + inset, upper - inset, CELLS))
    points = np.tile(base, (CELLS, CELLS, 1))
    points[..., machine.active.index(pair[0])] = lines[0][:, None]
    points[..., machine.active.index(pair[1])] = lines[1][None]
    return points


def _lifted(
    machine: LiftingMachine, u: Array, frame: str | None, loads: Loads | None
) -> tuple[Array, Array, np.ndarray]:
    """Places (N, 3) of the frame, lifted masses (N,), and the drives (N,) that limit them."""
    state = machine.close(u)
    still = np.zeros_like(u)
    given = machine.loads if loads is None else loads
    held = machine.inverse_dynamics(state, still, given)
    hanging = given.with_payload(Payload(1.0), frame or machine.end_effector)
    more = machine.inverse_dynamics(state, still, hanging) - held
    rates = machine.drive_rates(state)
    lower, upper = limits_of(machine)
    masses: list[float] = []
    drives: list[int] = []
    for rate, one, needed in zip(rates, more, held, strict=True):
        answer = largest(solutions(rate.T, one[:, None], needed, lower, upper), machine.all_drives)
        masses.append(max(answer.value, 0.0))
        names = answer.limited_by
        drives.append(machine.all_drives.index(names[0]) if names else -1)
    place = machine.forward_kinematics(state, frame).position
    return place, np.array(masses), np.array(drives)
