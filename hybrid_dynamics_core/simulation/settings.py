"""Settings of a simulation."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import integrate

from ..dynamics.loads import Loads
from ..errors import InputError
from ..ground.check_arguments import real_number, require_type
from ..ground.check_arrays import real_array

METHODS = {
    "DOP853": integrate.DOP853,
    "RK45": integrate.RK45,
    "Radau": integrate.Radau,
    "BDF": integrate.BDF,
    "LSODA": integrate.LSODA,
}
COMPILED = "DOP853"  # the method that also runs in compiled code
_POSITIVE = ("rtol", "atol", "rate", "max_step", "hold", "singular")


@dataclass(frozen=True, eq=False)
class Settings:
    """Settings of `simulate`.

    Attributes:
        loads: loads besides the actuators; None: those of the description.
        method: integrator of SciPy. DOP853 and RK45 are for smooth motion. Radau, BDF and LSODA are
            for stiff motion, such as strong friction with little smoothing.
        rtol: relative tolerance of a step.
        atol: absolute tolerance of a step [rad, m, rad/s, m/s, J].
        rate: recorded samples per second of simulated time [Hz].
        hold: period of a digital controller [s]: tau is evaluated once a period and held. None: it
            is evaluated at every instant.
        max_step: longest step [s].
        stop_at_limits: whether the simulation ends at a limit of a coordinate or the end of a
            stroke. Otherwise an event is recorded and the motion continues. The stop itself is not
            modelled.
        singular: distance to a singular configuration (`state.singularity`) at which the simulation
            ends.
        saturate: whether drives give no more than their efforts, pressures, powers and flows allow.
            The recorded tau is what they give.
        progress: whether to show a line of progress. None: on a terminal, after one second.
        through_change_points: whether the motion passes singular places where the mechanism does:
            change points, where rates stay continuous, and toggles, where another joint is
            integrated. Each is an event. Otherwise the simulation ends there.

    Raises:
        InputError: the method is unknown, a number is not above zero, or a wrench has rows.
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
    saturate: bool = False
    progress: bool | None = None
    through_change_points: bool = False

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise InputError(f"there is no method '{self.method}'; known: {', '.join(METHODS)}")
        for name in _POSITIVE:
            value = getattr(self, name)
            if value is not None and not real_number(name, value) > 0.0:
                raise InputError(f"{name} is {value}; expected a number above zero")
        if not math.isfinite(self.rate):
            raise InputError(f"rate is {self.rate}; expected a finite number of samples a second")
        if self.loads is None:
            return
        require_type("loads", self.loads, Loads, "robot.loads")
        for wrench in self.loads.wrenches.values():
            if wrench.values.ndim > 1:
                raise InputError("a simulation takes one wrench on a frame, not one a row")


def checked_span(t_span: tuple[float, float]) -> tuple[float, float]:
    """Start and end [s], the end after the start.

    Raises:
        InputError: the times are not finite or not ascending.
    """
    times = real_array("t_span", t_span)
    if times.shape != (2,):
        raise InputError(f"t_span has shape {times.shape}; expected start and end, as (0.0, 2.0)")
    start, end = times.tolist()
    finite = np.isfinite(start) and np.isfinite(end)
    if not (finite and start < end):
        raise InputError(
            f"t_span is ({start}, {end}); expected two times, the second after the first"
        )
    return start, end
