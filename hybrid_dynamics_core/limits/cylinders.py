"""Flows, pressures and forces of the cylinders of a robot, and of the pumps that feed them."""

from __future__ import annotations

import math

import numpy as np

from ..closed_state.state import ClosedState
from ..description.actuators import HydraulicCylinder, Pump
from ..dynamics.hydraulics import chamber_flows, chamber_pressures
from ..ground.arrays import Array
from .robot_interfaces import LimitedRobot

STRONGEST = 1e9  # [Pa] no cylinder stands more
FADE = 0.1  # share of a flow limit within which the pressure falls to that of the return


class Cylinders:
    """The cylinders of a robot with their pumps."""

    def __init__(self, robot: LimitedRobot) -> None:
        """Take cylinders and pumps from a robot's description."""
        self._by_joint = robot.description.actuators
        self._pumps = robot.description.pumps
        self._places: dict[str, int] = {}
        for name in self._by_joint:
            self._places[name] = robot.coordinates.index(name)

    def extension(self, state: ClosedState, name: str) -> Array:
        """Rate (...) at which a cylinder extends [m/s]."""
        rate = state.ds[..., self._places[name]]
        return np.asarray(self._by_joint[name].sign * rate)

    def demand(self, state: ClosedState, name: str) -> Array:
        """Flow (...) into the chamber that fills [m^3/s]."""
        rate = state.ds[..., self._places[name]]
        cap, rod = chamber_flows(self._by_joint[name], rate)
        return np.asarray(np.maximum(cap, rod))

    def pump_flow(self, state: ClosedState, pump: Pump) -> Array:
        """Flow (...) of a pump into all of its cylinders [m^3/s]."""
        demands = [self.demand(state, name) for name in pump.cylinders]
        return np.asarray(np.sum(demands, axis=0))

    def pump_power(self, state: ClosedState, pump: Pump, forces: dict[str, Array]) -> Array:
        """Flow of a pump times the highest pressure that fills a chamber (...) [W]."""
        highest = np.zeros(state.s.shape[:-1])
        for name in pump.cylinders:
            pressure = self._filling_pressure(state, name, forces[name])
            highest = np.maximum(highest, pressure)
        return np.asarray(highest * self.pump_flow(state, pump))

    def pressure(self, name: str, force: Array) -> Array:
        """Pressure (...) of the chamber that pushes [Pa]."""
        cap, rod = chamber_pressures(self._by_joint[name], force)
        return np.asarray(np.maximum(cap, rod))

    def force_bounds(self, state: ClosedState, name: str) -> tuple[Array, Array]:
        """Least and greatest force (...) of a cylinder along its joint, by pressures [N]."""
        cylinder = self._by_joint[name]
        low = cylinder.return_pressure
        highest = cylinder.highest_pressure
        filling = np.maximum(self._supplied(state, name), low)
        extension = self.extension(state, name)
        cap = np.where(extension > 0.0, filling, highest)
        rod = np.where(extension < 0.0, filling, highest)
        push = cap * cylinder.cap_area - low * cylinder.rod_area
        pull = low * cylinder.cap_area - rod * cylinder.rod_area
        return _along(cylinder, pull, push)

    def flow_bounds(self, state: ClosedState, name: str) -> tuple[Array, Array]:
        """Bounds (...) of its force as the flow comes near its limit [N].

        The pressure that fills falls to that of the return at the limit. Beyond it the other
        chamber brakes, as with a valve on its way out.
        """
        cylinder = self._by_joint[name]
        low = cylinder.return_pressure
        highest = min(cylinder.highest_pressure, STRONGEST)
        unused = self._unused(state, name)
        supplied = np.clip(self._supplied(state, name), low, highest)
        starved = low + np.maximum(unused, 0.0) * (supplied - low)
        # a jump of pressure at rest would keep integrators from passing it
        filling = highest - self._moving(state, name) * (highest - starved)
        braking = low + np.maximum(-unused, 0.0) * (highest - low)
        extension = self.extension(state, name)
        push = filling * cylinder.cap_area - braking * cylinder.rod_area
        pull = braking * cylinder.cap_area - filling * cylinder.rod_area
        upper = np.where(extension > 0.0, push, highest * cylinder.cap_area)
        lower = np.where(extension < 0.0, pull, -highest * cylinder.rod_area)
        return _along(cylinder, lower, upper)

    def _pump_of(self, cylinder: str) -> Pump | None:
        for pump in self._pumps.values():
            if cylinder in pump.cylinders:
                return pump
        return None

    def _supplied(self, state: ClosedState, name: str) -> Array:
        """Highest pressure (...) of a chamber that fills, by the power of the pump [Pa]."""
        shape = state.s.shape[:-1]
        highest = np.full(shape, self._by_joint[name].highest_pressure)
        pump = self._pump_of(name)
        if pump is None or math.isinf(pump.power_limit):
            return highest
        flow = self.pump_flow(state, pump)
        by_power = quotient(pump.power_limit, flow)
        return np.asarray(np.minimum(highest, by_power))

    def _unused(self, state: ClosedState, name: str) -> Array:
        """1 below a flow limit, 0 at it, -1 beyond (...)."""
        used = self.demand(state, name) / self._by_joint[name].flow_limit
        pump = self._pump_of(name)
        if pump is not None:
            of_pump = self.pump_flow(state, pump) / pump.flow_limit
            used = np.maximum(used, of_pump)
        unused = (1.0 - used) / FADE
        return np.asarray(np.clip(unused, -1.0, 1.0))

    def _moving(self, state: ClosedState, name: str) -> Array:
        """Share (...) of the pump's state that a cylinder feels: 0 at rest, soon 1."""
        largest = self._by_joint[name].flow_limit
        pump = self._pump_of(name)
        if pump is not None:
            largest = min(largest, pump.flow_limit)
            by_power = pump.power_limit / self._by_joint[name].highest_pressure
            if by_power > 0.0:
                largest = min(largest, by_power)
        share = self.demand(state, name) / (FADE * largest)
        return np.asarray(np.clip(share, 0.0, 1.0))

    def _filling_pressure(self, state: ClosedState, name: str, force: Array) -> Array:
        """Pressure (...) of the chamber that fills, zero at rest [Pa]."""
        cap, rod = chamber_pressures(self._by_joint[name], force)
        extension = self.extension(state, name)
        filling = np.where(extension > 0.0, cap, rod)
        return np.where(extension == 0.0, 0.0, filling)


def _along(cylinder: HydraulicCylinder, pull: Array, push: Array) -> tuple[Array, Array]:
    """Bounds of the force along the joint from those along the extension."""
    if cylinder.sign > 0.0:
        return pull, push
    return -push, -pull


def quotient(limit: float, divisor: Array) -> Array:
    """A limit over sizes (...), infinite where they are zero."""
    with np.errstate(divide="ignore"):
        return np.asarray(limit / divisor)
