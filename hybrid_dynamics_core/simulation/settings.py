"""How a simulation is run."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import integrate

from ..dynamics.loads import Loads
from ..errors import InputError

EXPLICIT = {"DOP853": integrate.DOP853, "RK45": integrate.RK45}
IMPLICIT = {"Radau": integrate.Radau, "BDF": integrate.BDF, "LSODA": integrate.LSODA}
METHODS = {**EXPLICIT, **IMPLICIT}


@dataclass(frozen=True, eq=False)
class Settings:
    """Settings of `simulate`.

    Attributes:
        loads: what acts besides the actuators; None: what the description gives.
        method: integrator of SciPy: DOP853 or RK45 for smooth motion, Radau, BDF or LSODA where
        strong friction with
            little smoothing makes it stiff.
        rtol, atol: relative and absolute tolerance of a step, the latter in rad, m, and per second.
        rate: samples kept a second of simulated time [Hz].
        hold: [s] period of a digital controller: tau is asked once a period and kept; None: at
        every instant.
        max_step: longest step [s].
        stop_at_limits: whether the simulation ends where a coordinate reaches its limit or a
        cylinder the end of its
            stroke. Otherwise it is told as an event and the motion goes on: there is no model of
            the stop itself.
        singular: distance to a singular configuration (`state.singularity`) at which the simulation
        ends.
        progress: whether to show a line of progress; None: on a terminal, once a second has passed.
    """

    loads: Loads | None = None
    method: str = "DOP853"
    rtol: float = 1e-9
    atol: float = 1e-11
    rate: float = 100.0
    hold: float | None = None
    max_step: float = math.inf
    stop_at_limits: bool = True
    singular: float = 0.01
    progress: bool | None = None

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise InputError(f"there is no method '{self.method}'; known: {', '.join(METHODS)}")
        for name in ("rtol", "atol", "rate", "max_step", "hold", "singular"):
            value = getattr(self, name)
            if value is not None and not value > 0.0:
                raise InputError(f"{name} is {value}; expected a number above zero")
        if self.loads is not None and any(w.values.ndim > 1 for w in self.loads.wrenches.values()):
            raise InputError("a simulation takes one wrench on a frame, not one a row")

    @property
    def implicit(self) -> bool:
        """Whether the method solves equations in each step."""
        return self.method in IMPLICIT


def checked_span(t_span: tuple[float, float]) -> tuple[float, float]:
    """Start and end [s], the end after the start. Raises InputError."""
    start, end = (float(t) for t in t_span)
    if not (np.isfinite(start) and np.isfinite(end) and start < end):
        raise InputError(
            f"t_span is ({start}, {end}); expected two times, the second after the first"
        )
    return start, end
