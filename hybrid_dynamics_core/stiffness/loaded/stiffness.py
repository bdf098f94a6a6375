"""Stiffness of a frame of a robot that bears loads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from ...errors import SingularityError
from ...ground.arrays import Array
from ..equilibrium import Equilibrium
from ..load_columns import Acting
from ..modes import allowed_deformations
from .curvature import carrying, change_of_closure, change_of_wrench

HELD: Final = 1e-9  # stiffness over that of all joints, below which a load does not hold a motion
LOADS: Final = "loads"


@dataclass(frozen=True, eq=False)
class LoadedStiffness:
    """Stiffness of a frame about a state that a robot has under loads, with drives locked.

    Attributes:
        compliance: displacement (6, 6) of the frame per further wrench on it, base axes. It is
            symmetric under forces, and in general not under moments, which have no potential.
        shares: the part (6, 6) of each element; that of the loads is `loads`. Their sum is the
            compliance.
        critical_factor: by which all loads may grow until a direction has no stiffness left;
            infinity if none ever loses it.
    """

    compliance: Array
    shares: Mapping[str, Array]
    critical_factor: float


def loaded_compliance(
    solved: Equilibrium,
    acting: list[Acting],
    column: Array,
    frame: Array,
) -> LoadedStiffness:
    """Stiffness of a frame, with what loads and the forces that they cause add to it.

    Args:
        solved: equilibrium of the robot.
        acting: its loads.
        column: (n_s + n_e,) their generalised forces.
        frame: (6, n_s + n_e) displacement of the frame.

    Raises:
        SingularityError: the loads are beyond the critical ones.
    """
    change = _change(solved, acting, column)
    shapes = allowed_deformations(solved)
    basis = np.vstack([solved.joint_displacements(shapes), shapes])
    reduced = basis.T @ change @ basis - _followed(solved, change, basis)
    unit = basis.T @ frame.T
    moved = np.linalg.solve(_stable(reduced), unit)
    compliance = unit.T @ moved
    deformed = shapes @ moved
    rows: dict[str, list[int]] = {}
    for k, name in enumerate(solved.structure.springs):
        rows.setdefault(name, []).append(k)
    shares = {name: deformed[part].T @ deformed[part] for name, part in rows.items()}
    shares[LOADS] = moved.T @ reduced.T @ moved
    return LoadedStiffness(compliance, shares, _critical_factor(reduced))


def _change(solved: Equilibrium, acting: list[Acting], column: Array) -> Array:
    """Stiffness (n, n) by the loads over joints and deformations, n = n_s + n_e."""
    structure = solved.structure
    carried = carrying(structure.order)
    change = np.zeros((structure.size, structure.size))
    for one in acting:
        change -= change_of_wrench(carried, one)
    multipliers = solved.multipliers(column[:, None])[:, 0]
    first = 0
    for closure in structure.closures:
        last = first + len(closure.held.deformations)
        change += change_of_closure(structure, carried, closure, multipliers[first:last])
        first = last
    return change


def _followed(solved: Equilibrium, change: Array, basis: Array) -> Array:
    """What is left out of the stiffness (k, k) since idle joints follow.

    Raises:
        SingularityError: an idle joint tips over.
    """
    free = np.zeros((len(basis), solved.free.shape[1]))
    free[: len(solved.free)] = solved.free
    size = len(solved.scale)
    of_joints = change[:size, :size] * np.outer(solved.scale, solved.scale)
    least = HELD * float(np.abs(of_joints).max(initial=0.0))
    idle = free.T @ change @ free
    values, vectors = np.linalg.eigh(0.5 * (idle + idle.T))
    if (values < -least).any():
        raise SingularityError(
            "a joint without a drive or spring tips over under these loads", loop="", distance=0.0
        )
    held = free @ vectors[:, values > least]
    stiffness = held.T @ change @ held
    pushed = held.T @ change @ basis
    followed: Array = basis.T @ change @ held @ np.linalg.solve(stiffness, pushed)
    return followed


def _stable(reduced: Array) -> Array:
    """Stiffness (k, k) over deformations: 1 of each spring, and that by the loads."""
    stiffness: Array = np.eye(len(reduced)) + reduced
    if np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T)).min(initial=1.0) <= 0.0:
        raise SingularityError(
            "the springs do not hold these loads: they are"
            f" {1.0 / _critical_factor(reduced):.3g} times the critical ones, at which the robot"
            " tips or buckles",
            loop="",
            distance=0.0,
        )
    return stiffness


def _critical_factor(reduced: Array) -> float:
    """Least factor of the loads at which a direction has no stiffness."""
    symmetric = 0.5 * (reduced + reduced.T)
    lowest = float(np.linalg.eigvalsh(symmetric).min(initial=0.0))
    if lowest >= 0.0:
        return float("inf")
    return -1.0 / lowest
