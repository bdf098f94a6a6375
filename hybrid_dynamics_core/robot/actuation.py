"""Drives of a robot: conversion between drive forces and tau, and hydraulic cylinders."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from ..algebra.independence import independent_rows
from ..closed_state.state import ClosedState
from ..description.actuators import HydraulicCylinder, Transmission
from ..dynamics.distribution import IMPOSSIBLE, Distribution, Drives, distribute
from ..dynamics.hydraulics import CylinderState, cylinder_state, force_range
from ..errors import InputError, SingularityError
from ..ground.arrays import Array
from ..ground.check_arguments import real_number
from ..ground.check_arrays import mapping_of, real_array
from ..ground.lazy import lazy
from ..ground.suggestions import no_such_name
from .closure import Closure
from .model import RobotModel

# least share of a drive's row of R that is independent of the rows before
INDEPENDENT = 1e-9


class Actuation:
    """Drives of a robot.

    A drive may be on any joint of a loop, not only on the active coordinate.
    """

    def __init__(self, model: RobotModel, closure: Closure) -> None:
        self._model = model
        self._closure = closure

    @property
    def cylinders(self) -> Mapping[str, HydraulicCylinder]:
        """The hydraulic cylinders of the description, by joint."""
        return self._model.description.actuators

    @lazy
    def drives(self) -> tuple[str, ...]:
        """Driven joints that determine the motion, in the order of the coordinates.

        Joints with an actuator come first, then active joints until all but the idle coordinates
        are determined.
        """
        return tuple(name for name in self.determining if name not in self._model.idle)

    @lazy
    def determining(self) -> tuple[str, ...]:
        """The n joints that determine the motion: the drives, then idle coordinates."""
        model = self._model
        R = self._closure.close(model.reference).R
        sizes = np.linalg.norm(R, axis=1)
        preferred = [model.coordinates.index(name) for name in (*self.cylinders, *model.active)]
        order = list(dict.fromkeys(preferred))  # idle ones are the last of the active coordinates
        rows = independent_rows(R, order, INDEPENDENT * np.maximum(sizes, 1.0))
        return tuple(model.coordinates[k] for k in sorted(rows))

    @lazy
    def all_drives(self) -> tuple[str, ...]:
        """All driven joints, including redundant ones, in the order of the coordinates.

        These are the active joints except idle ones, dependent motors, and joints with an actuator.
        The drives of transmissions come last, in place of the joints that they move.
        """
        model = self._model
        driven = {*model.active, *model.dependent_motors, *self.cylinders}
        driven -= set(model.idle)
        for transmission in self._transmissions.values():
            driven -= {*transmission.multipliers} - {*self.cylinders}
        joints = tuple(name for name in model.coordinates if name in driven)
        return (*joints, *self._transmissions)

    @property
    def _transmissions(self) -> Mapping[str, Transmission]:
        return self._model.description.transmissions

    def _rates_of(self, R: Array, name: str) -> Array:
        """Rates (..., n) of a joint or drive per unit rates of the active coordinates."""
        rates = np.zeros_like(R[..., 0, :])
        for joint, multiplier in self._multipliers_of(name).items():
            rates = rates + multiplier * R[..., self._model.coordinates.index(joint), :]
        return rates

    def _multipliers_of(self, name: str) -> Mapping[str, float]:
        """Rate of a joint or drive per rate of each joint that moves it."""
        if name in self._transmissions:
            return self._transmissions[name].multipliers
        return {name: 1.0}

    def distribute(
        self,
        state: ClosedState,
        tau: ArrayLike,
        preload: Mapping[str, ArrayLike] | None = None,
        weights: Mapping[str, float] | None = None,
    ) -> Distribution:
        """Distribute tau over `all_drives`, within their limits.

        The forces minimise the sum of squares of (force - preload) / weight. If the limits do not
        allow all of tau, the drives give as much as possible, and `missing` is the rest.
        `generalised_forces` converts the forces back to tau.

        Args:
            state: closed state, or a batch of N.
            tau: generalised forces (n,) or (N, n) [N m, N]; entries of idle coordinates are
                ignored.
            preload: preferred forces by drive, where tau allows them [N, N m].
            weights: unit of force by drive [N, N m]; by default its effort limit, or the largest
                limit of all drives.

        Raises:
            InputError: a drive is unknown, a shape is wrong, a value is not finite, or limits are
                active and the solver (the extra `drives`) is not installed.
        """
        tau = self._closure.vector_like(state, "tau", tau)
        names = self.all_drives
        preload_of = self._by_drive("preload", preload or {})
        weight_of = self._by_drive("weights", weights or {})
        bounds = [self._force_bounds(name) for name in names]
        lower, upper = np.reshape(bounds, (-1, 2)).T
        weight = _weights(lower, upper)
        for name, value in weight_of.items():
            weight[names.index(name)] = value
        if not (weight > 0.0).all():
            raise InputError("weights: expected forces above zero")
        wanted = np.array([preload_of.get(name, 0.0) for name in names])
        drives = Drives(lower, upper, weight, wanted)
        driven = [k for k, name in enumerate(self._model.active) if name not in self._model.idle]
        rates = np.zeros((*tau.shape[:-1], len(names), len(driven)))
        for k, name in enumerate(names):
            rates[..., k, :] = self._rates_of(state.R, name)[..., driven]
        loads = np.atleast_2d(tau[..., driven])
        pairs = zip(np.reshape(rates, (len(loads), len(names), len(driven))), loads, strict=True)
        shares: list[Array] = []
        for rate, load in pairs:
            shares.append(distribute(rate, load, drives) if names else np.zeros(0))
        forces = np.reshape(shares, (*tau.shape[:-1], len(names)))
        return self._distribution(tau, rates, forces, drives, driven)

    def _distribution(
        self, tau: Array, rates: Array, forces: Array, drives: Drives, driven: list[int]
    ) -> Distribution:
        """The distribution of given forces (..., m), with its missing part and drives at limits."""
        given = np.einsum("...mi,...m->...i", rates, forces)
        missing = np.zeros(tau.shape)
        missing[..., driven] = tau[..., driven] - given
        largest = np.abs(rates).max(axis=-2, initial=0.0)
        largest = largest * np.abs(forces).max(axis=-1, keepdims=True, initial=0.0)
        rounding = IMPOSSIBLE * np.maximum(np.abs(tau[..., driven]), largest)
        is_possible = (np.abs(missing[..., driven]) <= rounding).all(axis=-1)
        at_limit = (forces <= drives.lower) | (forces >= drives.upper)
        names = self.all_drives
        return Distribution(
            MappingProxyType({name: forces[..., k] for k, name in enumerate(names)}),
            missing,
            is_possible,
            MappingProxyType({name: at_limit[..., k] for k, name in enumerate(names)}),
        )

    @property
    def effort_ranges(self) -> Mapping[str, tuple[float, float]]:
        """Least and greatest effort of each of `all_drives` [N m, N], infinite without a limit."""
        return MappingProxyType({name: self._force_bounds(name) for name in self.all_drives})

    def drive_rates(self, state: ClosedState) -> Array:
        """Rates of `all_drives` per unit rates of the active coordinates.

        Args:
            state: closed state, or a batch of N.

        Returns:
            (m, n) or (N, m, n): forces f of the drives act as tau = rates^T f.
        """
        self._closure.check_state(state)
        columns = [self._rates_of(state.R, name) for name in self.all_drives]
        if not columns:
            return np.zeros((*state.u.shape[:-1], 0, state.u.shape[-1]))
        return np.stack(columns, axis=-2)

    def _force_bounds(self, name: str) -> tuple[float, float]:
        """Least and greatest force [N] or torque [N m] of a drive."""
        if name in self._transmissions:
            limit = self._transmissions[name].effort_limit
            return -limit, limit
        limit = self._model.description.joints[name].effort_limit
        lower, upper = -limit, limit
        if name in self.cylinders:
            pull, push = force_range(self.cylinders[name])
            lower, upper = max(lower, pull), min(upper, push)
        return lower, upper

    def _by_drive(self, what: str, values: Mapping[str, ArrayLike]) -> dict[str, float]:
        """Check numbers given by drive."""
        result: dict[str, float] = {}
        for name, value in mapping_of(what, values).items():
            if name not in self.all_drives:
                raise InputError(f"{what}: {no_such_name('drive', name, self.all_drives)}")
            result[name] = real_number(f"{what}: {name}", value)
            if not np.isfinite(result[name]):
                raise InputError(f"{what}: that of '{name}' is not finite")
        return result

    def generalised_forces(
        self,
        state: ClosedState,
        forces: Mapping[str, ArrayLike],
    ) -> Array:
        """Convert forces along any joints, or of any drives, to generalised forces: tau = R^T f.

        For the forces of drives this is tau_q in Chu (2020), below Eq. 17.

        Forward dynamics from measured cylinder forces is
        `forward_dynamics(state, generalised_forces(state, forces))`.

        Args:
            state: closed state, or a batch of N.
            forces: force [N] or torque [N m] by joint or by drive, each a number or (N,).

        Returns:
            tau (n,) or (N, n) [N m, N].

        Raises:
            InputError: there is no such joint, a shape is wrong, or a value is not finite.
        """
        self._closure.check_state(state)
        coordinates = self._model.coordinates
        along = np.zeros_like(state.s)
        for name, force in mapping_of("forces", forces).items():
            if name not in (*coordinates, *self._transmissions):
                raise InputError(f"there is no joint '{name}'; known: {', '.join(coordinates)}")
            checked = _checked_force(state, name, force)
            for joint, multiplier in self._multipliers_of(name).items():
                along[..., coordinates.index(joint)] += multiplier * checked
        tau: Array = np.einsum("...ij,...i->...j", state.R, along)
        return tau

    def drive_forces(
        self,
        state: ClosedState,
        tau: ArrayLike,
    ) -> Mapping[str, Array]:
        """Forces of the `drives` that give the generalised forces tau.

        Entries of tau along idle coordinates are ignored.

        Args:
            state: closed state, or a batch of N.
            tau: generalised forces (n,) or (N, n) [N m, N].

        Returns:
            Force [N] or torque [N m] by joint, each a number or (N,).

        Raises:
            SingularityError: at this state, the drives cannot give every tau.
            InputError: a shape is wrong, or a value is not finite.
        """
        tau = self._closure.vector_like(state, "tau", tau)
        indices = [self._model.coordinates.index(name) for name in self.determining]
        rows = state.R[..., indices, :]
        self._check_drives(rows)
        transposed = np.swapaxes(rows, -1, -2)
        solution = np.linalg.solve(transposed, tau[..., None])
        forces = solution[..., 0].astype(np.float64)
        by_name: dict[str, Array] = {}
        for k, name in enumerate(self.determining):
            if name not in self._model.idle:
                by_name[name] = forces[..., k]
        return MappingProxyType(by_name)

    def hydraulics(
        self,
        state: ClosedState,
        tau: ArrayLike,
    ) -> Mapping[str, CylinderState]:
        """Pressures, flows and remaining stroke of every cylinder.

        Args:
            state: closed state, or a batch of N.
            tau: generalised forces (n,) or (N, n) [N m, N].

        Returns:
            The state of each cylinder, by joint.

        Raises:
            SingularityError: at this state, the drives cannot give every tau.
            InputError: a shape is wrong, or a value is not finite.
        """
        forces = self.drive_forces(state, tau)
        unloaded = np.zeros(state.s.shape[:-1])
        result = {}
        for name, cylinder in self.cylinders.items():
            k = self._model.coordinates.index(name)
            stroke = state.s[..., k]
            speed = state.ds[..., k]
            force = np.asarray(forces.get(name, unloaded))
            result[name] = cylinder_state(cylinder, stroke, speed, force)
        return MappingProxyType(result)

    def _check_drives(self, rows: Array) -> None:
        """Raise if a motion moves none of the drives, to working precision.

        Args:
            rows: rows of R of the drives, (n, n) or (N, n, n).
        """
        n = rows.shape[-1]
        if not n:
            return
        # rows that do not close stay NaN
        closed = np.isfinite(rows).all(axis=(-2, -1), keepdims=True)
        sizes = np.linalg.norm(rows, axis=-1, keepdims=True)
        scaled = rows / np.maximum(sizes, 1.0)
        _, values, motions = np.linalg.svd(np.where(closed, scaled, np.eye(n)))
        distances = np.atleast_1d(values[..., -1])
        singular = distances < INDEPENDENT
        if not singular.any():
            return
        first = int(np.flatnonzero(singular)[0])
        distance = float(distances[first])
        motion = motions.reshape(-1, n, n)[first, -1]
        index = first if rows.ndim == 3 else None
        raise self._dependent_drives(motion, distance, index)

    def _dependent_drives(
        self, motion: Array, distance: float, index: int | None
    ) -> SingularityError:
        """The error for a motion (n,) of the active joints that moves no drive."""
        motion = motion / motion[np.argmax(np.abs(motion))]
        moving = []
        for name, part in zip(self._model.active, motion, strict=True):
            if abs(part) > 1e-6:
                moving.append(f"{name} ({part:+.3g})")
        problem = (
            f"the drives {', '.join(self.drives)} cannot give every tau here: moving"
            f" {', '.join(moving)} moves none of them (smallest singular value {distance:.2g})"
        )
        return SingularityError(problem, loop="", distance=distance, index=index)


def _checked_force(state: ClosedState, name: str, force: ArrayLike) -> Array:
    """Check a force on a joint: a number, or one for each state."""
    value = real_array(f"the force on '{name}'", force)
    shapes = ((), state.s.shape[:-1])
    if value.shape not in shapes or not np.isfinite(value).all():
        raise InputError(
            f"the force on '{name}' has shape {value.shape}; expected finite numbers, one a state"
        )
    return value


def _weights(lower: Array, upper: Array) -> Array:
    """Half of the force range of each drive (m,); the largest of all for drives without limits."""
    halves = 0.5 * (upper - lower)
    finite = halves[np.isfinite(halves)]
    largest = finite.max(initial=0.0) or 1.0
    return np.where(np.isfinite(halves), halves, largest)
