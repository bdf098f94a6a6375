"""Results of a family of robots, with their derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...ground.arrays import Array
from ...kernels.run import Codes
from ...programs.live import PARAMETERS, derivative_name
from ...programs.outcome import kinds

BY = (PARAMETERS, "u")
DISTANCES = "distances"


@dataclass(frozen=True, eq=False)
class FamilyResult:
    """Results at some parameters, with their derivatives; a batch has a leading N.

    Attributes:
        values: results by name.
        by_parameters: derivative of each by the parameters, one axis more at the end (..., k).
        by_u: derivative of each by the active coordinates (..., n).
        status: 0 where the loops close, otherwise an `OutcomeKind`; () or (N,). Rows without a
            result are NaN.
    """

    values: Mapping[str, Array]
    by_parameters: Mapping[str, Array]
    by_u: Mapping[str, Array]
    status: Codes

    def __getitem__(self, name: str) -> Array:
        """A result by name."""
        return self.values[name]


def result_of(
    results: Mapping[str, Array], codes: Codes, outputs: Sequence[str], by: Mapping[str, int]
) -> FamilyResult:
    """The results of a program and their derivatives; rows without a result become NaN.

    Args:
        results: results of the program, with derivatives.
        codes: status codes.
        outputs: names of the results.
        by: lengths of the vectors by which they are differentiated, by name.
    """
    parts: dict[str, dict[str, Array]] = {vector: {} for vector in BY}
    for value in results.values():
        value[codes != 0] = np.nan
    for vector, count in by.items():
        for name in outputs:
            derivative = results[derivative_name(name, vector)]
            shape = (*results[name].shape, count)
            parts[vector][name] = derivative.reshape(shape)
    values = {name: results[name] for name in outputs}
    return FamilyResult(values, parts[PARAMETERS], parts["u"], kinds(codes))


def by_loop(result: FamilyResult, blocks: Sequence[str], loops: Sequence[str]) -> FamilyResult:
    """The result with distances of loops in place of blocks: the least of each loop's blocks.

    Args:
        result: the result, with one distance for each block.
        blocks: the loop of each block.
        loops: names of the loops.
    """
    distances = result.values[DISTANCES]
    nearest: list[NDArray[np.int64]] = []
    for loop in loops:
        members = np.flatnonzero(np.array(blocks) == loop)
        least = np.argmin(distances[..., members], axis=-1)
        nearest.append(members[least])
    if not nearest:
        return result
    chosen = np.stack(nearest, axis=-1)
    parts = (result.values, result.by_parameters, result.by_u)
    values, by_parameters, by_u = (_with_distances(part, chosen) for part in parts)
    return FamilyResult(values, by_parameters, by_u, result.status)


def _with_distances(part: Mapping[str, Array], blocks: NDArray[np.int64]) -> Mapping[str, Array]:
    """The values or derivatives with distances of some blocks only.

    Args:
        part: values by name, or their derivatives, which have one axis more.
        blocks: index of the chosen block by loop (loops,), or by row (N, loops).
    """
    if DISTANCES not in part:
        return part
    distances = part[DISTANCES]
    axes_after = distances.ndim - blocks.ndim
    indices = blocks.reshape(*blocks.shape, *[1] * axes_after)
    chosen = np.take_along_axis(distances, indices, axis=blocks.ndim - 1)
    return {**part, DISTANCES: chosen}
