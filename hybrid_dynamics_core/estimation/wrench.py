"""A wrench from efforts along drives: least squares with covariance, blind directions left out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..ground.arrays import Array

Mask = NDArray[np.bool_]
AXES = ("fx", "fy", "fz", "mx", "my", "mz")
SIX = len(AXES)
VISIBLE = 1e-3  # share of the largest effort of a direction, below which one is blind
PURE = 1e-6  # share of an axis that may lie in blind directions
TINY = 1e-12  # share of the variances that keeps a covariance definite


@dataclass(frozen=True, eq=False)
class ToolForce:
    """Force and moment of the surroundings on the tool, with a leading N for the samples.

    Attributes:
        wrench: (6,) force [N], then moment [N m] about the frame's origin, in the axes of the
            frame; NaN along axes that no drive senses. Moments are zero where a force at a point
            is assumed.
        covariance: (6, 6) of the wrench; NaN along the same axes.
        visible: (6, 6) projector on the directions that the drives sense. Moments count by the
            distance of the frame from the base.
        visible_part: (6,) the part of the wrench along these.
        contact: whether the efforts are beyond what errors and noise explain.
        level: squared deviations of the efforts; a contact if it is above `threshold`.
        threshold: the level that noise exceeds in a share of the samples.
        is_ready: whether the observer has had enough samples; else all numbers are NaN.
        frame: name of the frame.
    """

    wrench: Array
    covariance: Array
    visible: Array
    visible_part: Array
    contact: Mask
    level: Array
    threshold: float
    is_ready: Mask
    frame: str

    @property
    def blind(self) -> tuple[str, ...]:
        """Axes along which no sample shows the wrench, such as "fy"."""
        blind: list[str] = []
        for axis, values in zip(AXES, np.atleast_2d(self.wrench).T, strict=True):
            if np.isnan(values).all():
                blind.append(axis)
        return tuple(blind)


@dataclass(frozen=True, eq=False)
class DriveEfforts:
    """What a wrench does to k drives at N samples.

    Attributes:
        along: (N, k) efforts of the wrench [N m, N].
        covariance: (N, k, k) of their errors.
        effect: (N, k, c) change of the efforts with the first c axes of the wrench; the others
            are zero.
        is_ready: (N,) samples that count.
        length: [m] moments over it are compared with forces.
    """

    along: Array
    covariance: Array
    effect: Array
    is_ready: Mask
    length: float

    def force(self, frame: str, threshold: float) -> ToolForce:
        """The wrench of least squares at a frame, a contact above a threshold."""
        units = np.repeat([1.0, self.length], SIX // 2)[: self.effect.shape[2]]
        whitened, target = self._whitened(units)
        rows, sizes, columns = np.linalg.svd(whitened, full_matrices=False)
        is_visible = sizes > VISIBLE * sizes[:, :1]
        inverse = np.where(is_visible, 1.0 / np.where(is_visible, sizes, 1.0), 0.0)
        axes = transposed(columns)
        scaled = units[:, None] * axes * inverse[:, None, :]
        part = scaled @ (transposed(rows) @ target)
        projector = (units[:, None] * axes * is_visible[:, None, :]) @ (columns / units)
        level = (target[..., 0] ** 2).sum(axis=1)
        visible = _padded(projector, 1.0)
        visible_part = np.zeros((len(level), SIX))
        visible_part[:, : part.shape[1]] = part[..., 0]
        covariance = _padded(scaled @ transposed(scaled), 0.0)
        is_blind = np.diagonal(visible, axis1=1, axis2=2) < 1.0 - PURE
        is_blind = is_blind | ~self.is_ready[:, None]
        of_blind = is_blind[:, :, None] | is_blind[:, None, :]
        return ToolForce(
            wrench=np.where(is_blind, np.nan, visible_part),
            covariance=np.where(of_blind, np.nan, covariance),
            visible=visible,
            visible_part=np.where(self.is_ready[:, None], visible_part, np.nan),
            contact=(level > threshold) & self.is_ready,
            level=np.where(self.is_ready, level, np.nan),
            threshold=threshold,
            is_ready=self.is_ready,
            frame=frame,
        )

    def _whitened(self, units: Array) -> tuple[Array, Array]:
        """Effects (N, k, c) and efforts (N, k, 1) in deviations: their errors are independent.

        Args:
            units: (c,) unit of each axis of the wrench [N, N m].
        """
        k = self.along.shape[1]
        variances = np.trace(self.covariance, axis1=1, axis2=2)
        least = TINY * np.maximum(variances, TINY)
        root = np.linalg.cholesky(self.covariance + least[:, None, None] * np.eye(k))
        effect = np.asarray(np.linalg.solve(root, self.effect * units), dtype=np.float64)
        target = np.asarray(np.linalg.solve(root, self.along[..., None]), dtype=np.float64)
        return effect, target


def transposed(matrices: Array) -> Array:
    """Transposes of matrices (N, i, j), laid out anew: products are the same bits for any N."""
    return np.ascontiguousarray(np.swapaxes(matrices, -1, -2))


def _padded(matrices: Array, diagonal: float) -> Array:
    """Matrices (N, 6, 6) with the given ones (N, c, c) first, and a diagonal after them."""
    c = matrices.shape[1]
    padded = np.broadcast_to(diagonal * np.eye(SIX), (len(matrices), SIX, SIX)).copy()
    padded[:, :c, :c] = matrices
    return padded
