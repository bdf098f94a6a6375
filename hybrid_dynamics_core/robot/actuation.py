"""The part of Robot that knows what drives it: forces of the drives from tau and back, hydraulic cylinders."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..description.actuators import HydraulicCylinder
from ..dynamics.hydraulics import CylinderState, cylinder_state
from ..errors import InputError, SingularityError
from ..ground.arrays import Array
from .dynamics import RobotDynamics

INDEPENDENT = 1e-9  # share of a drive's row of R that the rows before it must leave


class RobotActuators(RobotDynamics):
    """Methods of Robot.

    A drive may sit on any joint of a loop, not only where the active coordinate is.
    """

    @property
    def cylinders(self) -> Mapping[str, HydraulicCylinder]:
        """The hydraulic cylinders of the description, by joint."""
        return self.description.actuators

    @cached_property
    def drives(self) -> tuple[str, ...]:
        """The n joints that are driven: those with an actuator, then active joints until the motion is determined.

        In the order of the coordinates.
        """
        R = self.close(self.reference).R
        chosen: list[str] = []
        basis: list[Array] = []
        for name in (*self.cylinders, *self.active):
            if name in chosen or len(chosen) == len(self.active):
                continue
            row = R[self.coordinates.index(name)]
            rest = row - sum((b @ row * b for b in basis), np.zeros_like(row))
            if np.linalg.norm(rest) > INDEPENDENT * max(1.0, float(np.linalg.norm(row))):
                basis.append(rest / np.linalg.norm(rest))
                chosen.append(name)
        return tuple(sorted(chosen, key=self.coordinates.index))

    def generalised_forces(self, state: ClosedState, forces: Mapping[str, ArrayLike]) -> Array:
        """tau (n,) or (N, n) of forces [N] and torques [N m] along any joints, by name: R^T f, Chu (2020), Eq. 22.

        Forward dynamics from measured cylinder forces is `forward_dynamics(state,
        generalised_forces(state, f))`.
        """
        self._own(state)
        along = np.zeros_like(state.s)
        for name, force in forces.items():
            if name not in self.coordinates:
                raise InputError(
                    f"there is no joint '{name}'; known: {', '.join(self.coordinates)}"
                )
            value = np.asarray(force, dtype=float)
            if value.shape not in ((), state.s.shape[:-1]) or not np.isfinite(value).all():
                raise InputError(
                    f"the force on '{name}' has shape {value.shape}; expected finite numbers, one a"
                    " state"
                )
            along[..., self.coordinates.index(name)] += value
        tau: Array = np.einsum("...ij,...i->...j", state.R, along)
        return tau

    def drive_forces(self, state: ClosedState, tau: ArrayLike) -> Mapping[str, Array]:
        """Forces [N] and torques [N m] of the `drives` that give tau, by joint, each a number or (N,).

        Raises SingularityError where the drives, as they stand, cannot give every tau.
        """
        tau = self._like(state, "tau", tau)
        rows = state.R[..., [self.coordinates.index(name) for name in self.drives], :]
        self._check_drives(rows)
        forces: Array = np.linalg.solve(np.swapaxes(rows, -1, -2), tau[..., None])[..., 0].astype(
            np.float64
        )
        return MappingProxyType({name: forces[..., k] for k, name in enumerate(self.drives)})

    def _check_drives(self, rows: Array) -> None:
        """Raise SingularityError where some motion, to the digits there are, moves none of the drives: rows of R."""
        good = np.isfinite(rows).all(
            axis=(-2, -1), keepdims=True
        )  # rows that do not close stay NaN
        sizes = np.linalg.norm(rows, axis=-1, keepdims=True)
        scaled = np.where(good, rows / np.maximum(sizes, 1.0), np.eye(rows.shape[-1]))
        _, values, motions = np.linalg.svd(scaled)
        bad = np.atleast_1d(values[..., -1] < INDEPENDENT)
        if not bad.any():
            return
        row = int(np.flatnonzero(bad)[0])
        distance, motion = (
            np.atleast_2d(values)[row, -1],
            motions.reshape(-1, *motions.shape[-2:])[row, -1],
        )
        motion = motion / motion[np.argmax(np.abs(motion))]
        told = ", ".join(
            f"{n} ({x:+.3g})" for n, x in zip(self.active, motion, strict=True) if abs(x) > 1e-6
        )
        problem = (
            f"the drives {', '.join(self.drives)} cannot give every tau here: moving {told} moves"
            f" none of them (smallest singular value {distance:.2g})"
        )
        index = None if rows.ndim == 2 else row
        raise SingularityError(problem, loop="", distance=float(distance), index=index)

    def hydraulics(self, state: ClosedState, tau: ArrayLike) -> Mapping[str, CylinderState]:
        """Pressures, flows and stroke left of every cylinder, by joint, for efforts tau (n,) or (N, n) [N m, N]."""
        forces = self.drive_forces(state, tau)
        result = {}
        for name, cylinder in self.cylinders.items():
            k = self.coordinates.index(name)
            force = forces.get(name, np.zeros(state.s.shape[:-1]))
            result[name] = cylinder_state(
                cylinder, state.s[..., k], state.ds[..., k], np.asarray(force)
            )
        return MappingProxyType(result)
