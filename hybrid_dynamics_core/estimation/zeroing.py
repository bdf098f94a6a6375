"""What a model is off by: what is known before, or what a run of the empty tool shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..dynamics.load_pattern import INERTIAL
from ..dynamics.loads import Loads
from ..ground.arrays import Array
from ..robot.robot import Robot
from .equations import Blocks, Modelling, standstill_columns
from .fit import System, fitted
from .misfit import check_fit
from .run import MeasuredRun
from .tolerances import Tolerances
from .unknowns import (
    Unknowns,
    friction_deviations,
    link_deviations,
    parameters_of,
    share_deviations,
)

SHARES = (0.25, 0.5, 0.75)  # of the limits, where usual efforts are taken


@dataclass(frozen=True, eq=False)
class Deviation:
    """Errors of a model, along columns [links, friction, offsets, scales, shares] of k drives.

    Attributes:
        values: (p,) expected errors.
        factor: (p, q) square root of their covariance.
    """

    values: Array
    factor: Array


def deviation_before(
    robot: Robot, drives: tuple[str, ...], loads: Loads, limits: Tolerances
) -> Deviation:
    """The errors that tolerances allow, without any measurement."""
    parameters = parameters_of(robot, drives)
    values = parameters.values(robot.description, loads.effects)
    usual = usual_efforts(robot, drives, loads)
    # viscous friction that is not listed stays zero: nothing says how fast the drives are
    sizes = np.stack([usual, np.full_like(usual, np.inf)], axis=1)
    parts = (
        link_deviations(parameters, values, limits.links),
        friction_deviations(robot, parameters, sizes, drives, limits),
        limits.offset * usual,
        np.full_like(usual, limits.scale),
        share_deviations(robot, drives, limits),
    )
    deviations = np.concatenate(parts)
    return Deviation(np.zeros_like(deviations), np.diag(deviations))


def usual_efforts(robot: Robot, drives: tuple[str, ...], loads: Loads) -> Array:
    """Mean efforts (k,) that hold the robot at rest, at some places within its limits [N m, N]."""
    lower, upper = np.clip(robot.limits, -np.pi, np.pi).T
    places = [robot.reference, *(lower + share * (upper - lower) for share in SHARES)]
    state = robot.close(np.stack(places), check=False)
    closed = np.flatnonzero(np.asarray(state.status) == 0)
    if not len(closed):
        return np.zeros(len(drives))
    held = state.rows(closed)
    tau = robot.inverse_dynamics(held, np.zeros_like(held.u), loads)
    forces = robot.drive_forces(held, tau)
    squares = [float(np.mean(forces[name] ** 2)) for name in drives]
    return np.asarray(np.sqrt(squares))


def deviation_of(empty: MeasuredRun, loads: Loads, limits: Tolerances) -> Deviation:
    """The errors that a run of the empty tool shows, with what it leaves open.

    Args:
        empty: the run.
        loads: loads besides the actuators.
        limits: tolerances before it.

    Raises:
        SensorError: chambers are exchanged, or a unit is wrong.
    """
    modelling = Modelling(empty, loads, empty.robot.end_effector, limits)
    equations = modelling.equations(empty, loaded=False)
    blocks = equations.blocks(empty.time)
    unknowns = modelling.unknowns([empty], np.zeros(INERTIAL))
    check_fit([empty], [equations], [blocks], unknowns)
    efforts = np.sqrt(np.mean(empty.efforts**2, axis=0))
    holding = modelling.holding_friction(unknowns, efforts)
    fit = fitted(_system(blocks, unknowns, holding, limits))
    shares = fit.values[len(unknowns.names) - len(empty.drives) : len(unknowns.names)]
    if shares.any():
        blocks = modelling.with_shares(blocks, empty, shares)
        fit = fitted(_system(blocks, unknowns, holding, limits))
    shared = slice(INERTIAL, len(unknowns.names))
    covariance = fit.covariance[shared, shared]
    sizes, axes = np.linalg.eigh(covariance)
    factor = axes * np.sqrt(np.maximum(sizes, 0.0))
    return Deviation(fit.values[shared], factor)


def _system(blocks: Blocks, unknowns: Unknowns, holding: Array, limits: Tolerances) -> System:
    """The system of an empty run, with a friction for each stretch in which a drive rests.

    Args:
        blocks: blocks of the run.
        unknowns: the unknowns.
        holding: (k,) largest friction of each drive at rest [N m, N].
        limits: tolerances.
    """
    columns, rests = standstill_columns(blocks, holding)
    deviation = np.concatenate([unknowns.deviation, rests])
    size = np.sqrt(np.mean(blocks.target**2, axis=0)) + 1e-6
    samples = float(np.median(blocks.samples))
    return System(
        matrix=np.concatenate([blocks.matrix, columns], axis=2),
        target=blocks.target,
        mean=np.zeros_like(deviation),
        deviation=deviation,
        floor=limits.noise * size / np.sqrt(samples),
        run=np.zeros(len(blocks.target)),
    )
