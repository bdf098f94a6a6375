"""What sensors of a closed mechanism read, and exact slopes of it along u, u' and u''.

An accelerometer reads the specific force: its acceleration less that of gravity.
"""

from __future__ import annotations

from collections.abc import Callable

from ..algebra.linear import Rows
from ..algebra.scalar import Scalar, atan2
from ..algebra.vector import Vector, add, matvec, transposed_matvec
from ..closure.closed_motion import ClosedMotion
from ..description.model import Frame
from ..dynamics.spanning import TreeDynamics, acceleration_map
from ..kernels.differentiate import jacobian
from ..kernels.trace import Results
from ..mechanism.tree import frame_offset
from .closure import closed_motion
from .model import AT_ACCELERATION, Inputs, Model, Program

Reading = Callable[[Model, Inputs, ClosedMotion], list[Scalar]]


def angular_rate(mount: Frame) -> Program:
    """Program for the angular velocity (3,) [rad/s] of a mount, in its axes."""

    def read(
        model: Model,
        x: Inputs,
        motion: ClosedMotion,
    ) -> list[Scalar]:
        rate, _ = _mounted(model, x, motion, mount)
        return list(rate)

    return _with_slopes(read)


def specific_force(mount: Frame) -> Program:
    """Program for the specific force (3,) [m/s^2] at a mount, in its axes."""

    def read(
        model: Model,
        x: Inputs,
        motion: ClosedMotion,
    ) -> list[Scalar]:
        _, force = _mounted(model, x, motion, mount)
        return list(force)

    return _with_slopes(read)


def inclination(mount: Frame) -> Program:
    """Program for the angle [rad] of the x axis of a mount above horizontal, about its z axis."""

    def read(
        model: Model,
        x: Inputs,
        motion: ClosedMotion,
    ) -> list[Scalar]:
        tree = TreeDynamics(model.tree, motion.configuration)
        rotation, _ = frame_offset(mount)
        body = model.tree.body_index(mount.link)
        down = tree.in_link_axes(_gravity(x))[body]
        along_x, along_y, _ = transposed_matvec(rotation, down)
        return [atan2(-along_x, -along_y)]

    return _with_slopes(read)


def position(index: int) -> Program:
    """Program for one of all coordinates [rad, m]."""

    def read(
        model: Model,
        x: Inputs,
        motion: ClosedMotion,
    ) -> list[Scalar]:
        del model, x
        return [motion.configuration.q[index]]

    return _with_slopes(read)


def rate(index: int) -> Program:
    """Program for the rate of one of all coordinates [rad/s, m/s]."""

    def read(
        model: Model,
        x: Inputs,
        motion: ClosedMotion,
    ) -> list[Scalar]:
        del model
        return [motion.rates(x.du)[index]]

    return _with_slopes(read)


def _mounted(
    model: Model,
    x: Inputs,
    motion: ClosedMotion,
    mount: Frame,
) -> tuple[Vector, Vector]:
    """Angular velocity and specific force of a mount, in its axes."""
    ds = motion.rates(x.du)
    dds = motion.accelerations(list(x.ddu), ds)
    tree = TreeDynamics(model.tree, motion.configuration)
    body = model.tree.body_index(mount.link)
    omega, alpha, at_origin = tree.motions(_gravity(x), ds, dds)[body]
    rotation, place = frame_offset(mount)
    force = add(at_origin, matvec(acceleration_map(omega, alpha), place))
    return transposed_matvec(rotation, omega), transposed_matvec(rotation, force)


def _gravity(x: Inputs) -> Vector:
    along_x, along_y, along_z = x.gravity
    return along_x, along_y, along_z


def _with_slopes(read: Reading) -> Program:
    """A program for readings and their slopes, on symbols only."""

    def run(
        model: Model,
        x: Inputs,
    ) -> Results:
        motion, checks, _ = closed_motion(model, x)
        readings = read(model, x, motion)
        slopes: Rows = jacobian(readings, [*x.u, *x.du, *x.ddu])
        return Results({"readings": readings, "slopes": slopes}, checks)

    return Program(AT_ACCELERATION, run)
