"""The part of a run in which a load stays the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..dynamics.load_pattern import INERTIAL
from ..ground.arrays import Array
from .fit import System, fitted, solved

Mask = NDArray[np.bool_]
TOLERANCE = 0.015  # deviation of a block with the same load, as a share of the mean effort
WIDE = 3.0  # deviations within which a block carries the same load
SHARE = 0.9  # of the blocks: if more carry the same load, all do
SEED = 4  # blocks that a search starts from
STRIDE = 2  # blocks from one start to the next
ROUNDS = 4  # fits of one search
GAP = 2  # blocks that may be left out within a load
LEAST_MASS = 1e-4  # share of the mass's deviation, as which an empty stretch counts


def loaded_blocks(system: System, count: int, size: Array) -> Mask:
    """Blocks that carry the greatest load that stays the same, and all of the empty run.

    The search starts at short stretches. Each grows by the blocks that fit its load. The greatest
    is that with the largest product of mass and number of blocks.

    Args:
        system: all blocks; the first `count` are those of the run with the load.
        count: number of its blocks.
        size: (k,) mean effort of each drive [N m, N].

    Returns:
        Mask (B,).
    """
    rows = np.ones(len(system.target), dtype=bool)
    if count < 2 * SEED:
        return rows
    part = _without_offsets(system, count)
    noise = np.maximum(TOLERANCE * size, system.floor)
    best = np.zeros(count, dtype=bool)
    greatest = -np.inf
    least = float(system.deviation[0]) * LEAST_MASS
    for start in range(0, count - SEED + 1, STRIDE):
        members, mass = _grown(part, noise, start)
        weight = members.sum() * max(mass, least)
        if members.sum() >= SEED and weight > greatest:
            greatest, best = weight, members
    if best.any() and best.mean() < SHARE:
        rows[:count] = best
    return rows


def _grown(part: System, noise: Array, start: int) -> tuple[Mask, float]:
    """Blocks that carry the load of a short stretch, and its mass [kg].

    Args:
        part: blocks of the run with the load.
        noise: (k,) standard deviation of a block with the same load [N m, N].
        start: first block of the stretch.
    """
    count = len(part.target)
    members = np.zeros(count, dtype=bool)
    members[start : start + SEED] = True
    middle = start + SEED // 2
    fit = solved(part.only(members), noise)
    for _ in range(ROUNDS):
        residual = part.target - part.matrix @ fit.values
        # few blocks say little of the others where the load's place counts
        spread = np.sqrt(noise**2 + _variances(part, fit.covariance))
        is_near: Mask = np.asarray((np.abs(residual) < WIDE * spread).all(axis=1))
        grown = _around(is_near, middle)
        if not grown.any():
            return grown, 0.0
        fit = solved(part.only(grown), noise)
        if np.array_equal(grown, members):
            break
        members = grown
    return members, float(fit.values[0])


def _variances(part: System, covariance: Array) -> Array:
    """Variances (B, k) of expected efforts by those (p, p) of the unknowns [N^2 m^2, N^2]."""
    products = (part.matrix @ covariance) * part.matrix
    return np.asarray(products.sum(axis=2))


def _around(mask: Mask, middle: int) -> Mask:
    """The blocks of a mask (B,) around a middle one, up to a gap that is too long."""
    result = np.zeros_like(mask)
    for step in (-1, 1):
        gap = 0
        k = middle
        while 0 <= k < len(mask) and gap <= GAP:
            result[k] = mask[k]
            gap += 1
            if mask[k]:
                gap = 0
            k += step
    return result


def _without_offsets(system: System, count: int) -> System:
    """The blocks of the first run, less the errors of the model that an empty run shows.

    Args:
        system: blocks of all runs; the first `count` are those of the first run.
        count: number of its blocks.
    """
    first = np.zeros(len(system.target), dtype=bool)
    first[:count] = True
    part = system.only(first)
    if first.all():
        return part
    fit = fitted(system.only(~first))
    shown = fit.values.copy()
    shown[:INERTIAL] = 0.0
    deviation = np.minimum(part.deviation, np.sqrt(np.diagonal(fit.covariance)))
    deviation[:INERTIAL] = part.deviation[:INERTIAL]
    target = part.target - part.matrix @ shown
    return replace(part, target=target, deviation=deviation)
