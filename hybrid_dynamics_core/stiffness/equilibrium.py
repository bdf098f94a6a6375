"""Equilibrium of an elastic structure: deformations under loads, and motions that nothing holds.

The deformations e minimise |e|^2 / 2 minus the work of the loads, subject to A_s s + A_e e = 0. So
with multipliers lambda

    A_s^T lambda = p_s,  e = p_e - A_e^T lambda.

The first equation is the statics of rigid links. Where it leaves forces undetermined, as in
over-constrained loops, the energy decides: springs share the load by their compliance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..algebra.independence import norm
from ..ground.arrays import Array
from .structure import Structure

RANK = 1e-9  # least singular value over the largest that counts


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """The equations of a structure, solved once for all loads.

    Attributes:
        structure: the structure.
        inverse: (n_s, m) pseudo-inverse of A_s.
        free: (n_s, k) motions of the joints that no equation holds.
        self_stress: (m, j) multipliers that balance without any load.
        stressed: (n_e, j) deformations of these states of self-stress.
        scale: (n_s,) unit of each joint coordinate, of one length.
    """

    structure: Structure
    inverse: Array
    free: Array
    self_stress: Array
    stressed: Array
    scale: Array

    def deformations(self, loads: Array) -> Array:
        """Deformations (n_e, k) in coordinates of unit stiffness under loads (n_s + n_e, k).

        The loads must do no work on `free` motions.
        """
        gaps = self.structure.A_e.T @ self.multipliers(loads)
        deformations: Array = loads[len(self.scale) :] - gaps
        return deformations

    def multipliers(self, loads: Array) -> Array:
        """Multipliers lambda (m, k) of the equations under loads (n_s + n_e, k)."""
        size = len(self.scale)
        statics: Array = self.inverse.T @ loads[:size]
        if not self.stressed.size:
            return statics
        deformations = loads[size:] - self.structure.A_e.T @ statics
        shares, _, _, _ = np.linalg.lstsq(self.stressed, deformations, rcond=RANK)
        relieved: Array = statics + self.self_stress @ shares
        return relieved

    def joint_displacements(self, deformations: Array) -> Array:
        """Displacements (n_s, k) of the joints [rad, m], those of `free` motions being zero."""
        gaps = self.structure.A_e @ deformations
        moved: Array = -self.inverse @ gaps
        return moved

    def unheld(self, load: Array) -> float:
        """Share of the work of a load (n_s + n_e,) that no spring takes, on free motions."""
        along = load[: len(self.scale)] * self.scale
        work = self.free.T @ (along / self.scale**2)
        size_of_load = norm(along)
        if not size_of_load:
            return 0.0
        return norm(work) / size_of_load


def equilibrium(structure: Structure) -> Equilibrium:
    """Solve the statics of a structure.

    Args:
        structure: springs and equations.
    """
    tree = structure.posed.tree
    scale = np.ones(len(tree.coordinates))
    for k in range(len(scale)):
        if tree.is_revolute(k):
            scale[k] = 1.0 / structure.length
    scaled = structure.A_s * scale
    sizes = np.linalg.norm(scaled, axis=1)
    is_rounding = sizes <= RANK * sizes.max(initial=0.0)  # of an equation of springs alone
    units = 1.0 / np.where(is_rounding, 1.0, sizes)
    left, values, right = np.linalg.svd(scaled * units[:, None])
    counts = values > RANK * values.max(initial=0.0)
    rank = int(counts.sum())
    along = right[:rank].T / values[:rank]
    inverse = scale[:, None] * (along @ left[:, :rank].T) * units
    self_stress = units[:, None] * left[:, rank:]
    return Equilibrium(
        structure=structure,
        inverse=inverse,
        free=scale[:, None] * right[rank:].T,
        self_stress=self_stress,
        stressed=_beyond_rounding(
            structure.A_e.T @ self_stress, norm(structure.A_e * units[:, None])
        ),
        scale=scale,
    )


def _beyond_rounding(stressed: Array, size: float) -> Array:
    """A matrix without its parts that are rounding beside a size.

    Equations that are redundant among themselves have states of self-stress without deformations.
    """
    if not stressed.size:
        return stressed
    left, values, right = np.linalg.svd(stressed, full_matrices=False)
    kept = np.where(values > RANK * size, values, 0.0)
    result: Array = (left * kept) @ right
    return result
