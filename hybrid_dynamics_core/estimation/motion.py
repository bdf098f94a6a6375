"""Closed states with rates from recorded coordinates, of any independent set."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ..closed_state.state import ClosedState
from ..errors import InputError
from ..ground.arrays import Array
from ..robot.robot import Robot
from .splines import spline_derivatives

LEAST = 12  # samples of a motion
STEPS = 20  # of Newton's method
CLOSE = 1e-10  # [rad, m] largest gap at which it ends
MISSED = 1e-7  # [rad, m] gap above which a sample is closed by itself


class ClosedMotion(NamedTuple):
    """Closed states (a batch of N), with active accelerations (N, n)."""

    state: ClosedState
    ddu: Array


def closed_motion(
    robot: Robot, time: Array, columns: Mapping[str, Array], bandwidth: float
) -> ClosedMotion:
    """The motion of smoothed coordinates.

    Args:
        robot: the robot.
        time: (N,) [s], ascending.
        columns: recorded coordinates (N,) by name [rad, m].
        bandwidth: of the motion [Hz]; what is quicker is smoothed.

    Returns:
        The states with accelerations (N, n) [rad/s^2, m/s^2].

    Raises:
        InputError: the samples are too few, or do not determine the motion.
        StateError: the loops of a sample do not close.
    """
    if len(time) < LEAST:
        raise InputError(f"{len(time)} samples show no motion; expected {LEAST} or more")
    names = _independent(robot, columns)
    table = np.stack([columns[name] for name in names], axis=1)
    s, ds, dds = spline_derivatives(time, table, bandwidth, (0, 1, 2))
    if names == robot.active:
        return ClosedMotion(robot.close(s, ds), dds)
    rows = [robot.coordinates.index(name) for name in names]
    u = _active_of(robot, rows, names, s)
    R = robot.close(u).R[:, rows]
    du = np.linalg.solve(R, ds[..., None])[..., 0]
    state = robot.close(u, du)
    bias = robot.accelerations(state, np.zeros_like(u))[:, rows]
    ddu = np.linalg.solve(state.R[:, rows], (dds - bias)[..., None])
    return ClosedMotion(state, np.asarray(ddu[..., 0], dtype=np.float64))


def _independent(robot: Robot, columns: Mapping[str, Array]) -> tuple[str, ...]:
    """Names of n coordinates that determine the motion.

    They are the active ones if all are recorded, and else the first independent ones.
    """
    n = len(robot.active)
    if all(name in columns for name in robot.active):
        return robot.active
    R = robot.close(robot.reference).R
    chosen: list[str] = []
    for name in sorted(columns, key=robot.coordinates.index):
        rows = [robot.coordinates.index(other) for other in (*chosen, name)]
        sizes = np.linalg.norm(R[rows], axis=1, keepdims=True)
        unit = R[rows] / np.maximum(sizes, 1e-12)
        if np.linalg.matrix_rank(unit, tol=1e-6) == len(rows):
            chosen.append(name)
    if len(chosen) < n:
        given = ", ".join(chosen) or "no coordinate"
        raise InputError(
            f"{given}: {n} independent coordinates determine {robot.name}; expected columns"
            f" {', '.join(robot.active)}, or others that determine the same motion"
        )
    return tuple(chosen[:n])


def _active_of(robot: Robot, rows: list[int], names: tuple[str, ...], values: Array) -> Array:
    """Active coordinates (N, n) at given values of others, by Newton's method.

    Args:
        robot: the robot.
        rows: indices of the n given coordinates.
        names: their names.
        values: (N, n) their values [rad, m].
    """
    first = robot.close_given(dict(zip(names, values[0].tolist(), strict=True)))
    lower, upper = robot.limits.T
    u = np.tile(first.u, (len(values), 1))
    gap = np.full_like(values, np.inf)
    for _ in range(STEPS):
        state = robot.close(u, check=False)
        gap = values - state.s[:, rows]
        if np.abs(gap).max() < CLOSE:
            break
        with np.errstate(all="ignore"):
            step = np.linalg.solve(state.R[:, rows], gap[..., None])[..., 0]
            u = np.clip(u + step, lower, upper)
    missed = np.flatnonzero(~(np.abs(gap).max(axis=1) < MISSED))
    near = first
    for k in missed.tolist():
        given = dict(zip(names, values[k].tolist(), strict=True))
        near = robot.close_given(given, near=near)
        u[k] = near.u
    return u
