"""The calls that frameworks of functions share: their arguments, results and starts."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, NamedTuple, Self

import numpy as np

from ...dynamics.loads import Loads
from ...errors import InputError
from ...ground.lazy import lazy
from ..closure import Closure
from ..dynamics import Dynamics
from .calls import CallTracer

Array = Any  # an array of the framework


class Start(NamedTuple):
    """A closed configuration that calls start from.

    Attributes:
        s: all coordinates (n_s,) [rad, m].
        start_map: R there, row by row (n_s * n,).
    """

    s: Array
    start_map: Array


class FunctionCalls(ABC):
    """The calls of a robot as functions of vectors (..., size)."""

    def __init__(
        self, closure: Closure, dynamics: Dynamics, loads: Loads, frame: str | None = None
    ) -> None:
        self._closure = closure
        self._dynamics = dynamics
        self._loads = loads
        self._frame = frame

    def at(self, frame: str) -> Self:
        """The same calls for another frame or link in place of the end effector.

        Raises:
            InputError: there is no such frame.
        """
        self._closure.model.frame(frame)
        return self._with(self._loads, frame)

    def under(self, loads: Loads) -> Self:
        """The same calls under other loads."""
        return self._with(loads, self._frame)

    def _with(self, loads: Loads, frame: str | None) -> Self:
        return type(self)(self._closure, self._dynamics, loads, frame)

    def close(
        self, u: Array, du: Array = 0.0, start: Start | None = None
    ) -> tuple[Array, Array, Array]:
        """All coordinates s and rates s', (..., n_s) each, and the status."""
        (s, ds), status = self._call("close", start, u=u, du=du)
        return s, ds, status

    def forward_kinematics(
        self, u: Array, start: Start | None = None
    ) -> tuple[Array, Array, Array]:
        """Position (..., 3) and rotation (..., 3, 3) of the end effector, and the status."""
        (position, rotation), status = self._call("forward_kinematics", start, u=u)
        return position, rotation, status

    def jacobian(self, u: Array, start: Start | None = None) -> tuple[Array, Array]:
        """Jacobian (..., 6, n) of the end effector, linear before angular, and the status."""
        (jacobian,), status = self._call("jacobian", start, u=u)
        return jacobian, status

    def inverse_dynamics(
        self,
        u: Array,
        du: Array,
        ddu: Array,
        gravity: Array | None = None,
        start: Start | None = None,
    ) -> tuple[Array, Array]:
        """Efforts tau (..., n) and the status, by the minimal form; Chu (2020), Eq. 17."""
        (tau,), status = self._call(
            "inverse_dynamics", start, u=u, du=du, ddu=ddu, gravity=self._gravity(gravity)
        )
        return tau, status

    def forward_dynamics(
        self,
        u: Array,
        du: Array,
        tau: Array,
        gravity: Array | None = None,
        start: Start | None = None,
    ) -> tuple[Array, Array]:
        """Accelerations u'' (..., n) and the status, by the minimal form; Chu (2020), Eq. 17."""
        (ddu,), status = self._call(
            "forward_dynamics", start, u=u, du=du, tau=tau, gravity=self._gravity(gravity)
        )
        return ddu, status

    def minimal_form(
        self,
        u: Array,
        du: Array,
        gravity: Array | None = None,
        start: Start | None = None,
    ) -> tuple[Array, Array, Array, Array]:
        """M-bar (..., n, n), C-bar u', G-bar (..., n), status; minimal form, Chu (2020), Eq. 17."""
        (mass, drift, weight), status = self._call(
            "minimal_form", start, u=u, du=du, gravity=self._gravity(gravity)
        )
        return mass, drift, weight, status

    def step(self, u: Array, start: Start | None = None) -> tuple[Start, Array]:
        """The closed configuration at u, for the next call along a motion, and the status."""
        if not self._closure.is_followed:  # closed forms need no R at the start
            s, _, status = self.close(u, start=start)
            return Start(s, self.start.start_map), status
        (s, start_map), status = self._call("step", start, u=u)
        return Start(s, start_map), status

    @property
    def start(self) -> Start:
        """The reference configuration."""
        if self._closure.is_followed:
            return Start(*self._closure.reference_start.flat)
        n_s, n = len(self._closure.model.coordinates), len(self._closure.model.active)
        return Start(self._closure.start, np.zeros(n_s * n))  # closed forms need no R

    def _gravity(self, gravity: Array | None) -> Array:
        """Gravity (..., 3) [m/s^2]; that of the loads if None."""
        return self._loads.gravity if gravity is None else gravity

    @lazy
    def _tracer(self) -> CallTracer:
        """Programs of the calls under these loads."""
        return CallTracer(
            self._closure, self._dynamics, self._loads, self._frame, self._closure.signs
        )

    def _call(self, name: str, start: Start | None, **vectors: Array) -> tuple[Any, Array]:
        """Results of a call in their shapes, and status.

        Args:
            name: name of the call.
            start: where loops start; the reference if None.
            vectors: its inputs by name.
        """
        given = start or self.start
        by_name = {**vectors, "start": given.s, "start_map": given.start_map, "guess": given.s}
        return self._run(name, by_name)

    @abstractmethod
    def _run(self, name: str, vectors: dict[str, Array]) -> tuple[Any, Array]:
        """Results of a call in their shapes, and status, from its vectors by name."""

    def _size(self, name: str) -> int:
        """Size of an input vector."""
        return self._closure.model.program_model.size(name)

    def _check_shape(self, name: str, shape: tuple[int, ...]) -> None:
        """Raise InputError for an input that is no vector (..., size)."""
        size = self._size(name)
        if not shape or shape[-1] != size:
            raise InputError(f"{name} has shape {shape}; expected (..., {size})")
