"""Simulated lifts of the shipped excavator with noisy sensors and a model that is off."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from hybrid_dynamics_core import ClosedState, Loads, Payload, Robot, load
from hybrid_dynamics_core.control import JointTrajectory, Reference
from hybrid_dynamics_core.description.effects import JointEffect
from hybrid_dynamics_core.description.model import RobotDescription
from hybrid_dynamics_core.dynamics.hydraulics import chamber_pressures
from hybrid_dynamics_core.estimation import MeasuredRun
from hybrid_dynamics_core.ground.arrays import Array

FULL_SCALE = 2000.0  # [kg] of the load
RATE = 50.0  # [Hz]
PRESSURE = 0.1e5  # [Pa] noise of pressures
ENCODER = np.deg2rad(0.02)  # noise of encoders
FRICTION = 0.05  # share by which the friction of the model is off
LINKS = 0.01  # share by which its masses are off
BACK = 12e5  # [Pa] in the chamber that does not push
COULOMB = {"boom_cylinder": 6e3, "stick_cylinder": 3e3, "bucket_cylinder": 2e3}  # [N]
VISCOUS = {"boom_cylinder": 2e4, "stick_cylinder": 1e4, "bucket_cylinder": 6e3}  # [N s/m]
ENCODERS = {  # the angle that each cylinder moves
    "slew": "slew",
    "boom_cylinder": "boom_pitch",
    "stick_cylinder": "stick_pitch",
    "bucket_cylinder": "bucket_pitch",
}
TIMES = (0.0, 3.0, 5.0, 8.0, 10.0, 13.0)  # [s] of a lift: up, swing, out, hold, down
TRAVEL = 0.06  # [m or rad] by which points differ from lift to lift
PATH = (  # slewing [rad], cylinders [m]
    (0.0, 0.40, 1.05, 0.85),
    (0.0, 0.75, 0.95, 0.92),
    (0.8, 0.80, 0.85, 0.90),
    (1.2, 0.85, 0.65, 0.88),
    (1.2, 0.70, 0.80, 0.94),
    (0.6, 0.55, 0.95, 0.90),
)


@dataclass(frozen=True)
class Machine:
    """A machine, and the model that its users have of it."""

    true: Robot
    model: Robot


def machine(rng: np.random.Generator) -> Machine:
    """A machine whose model is off in its links and its friction."""
    shipped = load("excavator").description
    model = with_friction(shipped, 1.0 + 0.0 * rng.normal(size=3))
    shares = 1.0 + LINKS * rng.normal(size=len(model.links))
    friction = 1.0 + FRICTION * rng.normal(size=3)
    true = with_friction(_scaled(shipped, shares), friction)
    return Machine(Robot(true), Robot(model))


def with_friction(description: RobotDescription, shares: Array) -> RobotDescription:
    """A description with friction in its cylinders."""
    effects = dict(description.effects)
    for share, joint in zip(shares.tolist(), COULOMB, strict=True):
        coulomb, viscous = share * COULOMB[joint], share * VISCOUS[joint]
        effects[joint] = JointEffect(viscous=viscous, coulomb=coulomb)
    return replace(description, effects=MappingProxyType(effects))


def _scaled(description: RobotDescription, shares: Array) -> RobotDescription:
    links = {}
    for share, (name, link) in zip(shares.tolist(), description.links.items(), strict=True):
        links[name] = replace(link, mass=share * link.mass, inertia=share * link.inertia)
    return replace(description, links=MappingProxyType(links))


@dataclass(frozen=True)
class Recording:
    """What sensors give: times, coordinates, and pressures of both sides [Pa] by cylinder."""

    time: Array
    positions: Mapping[str, Array]
    pressures: Mapping[str, tuple[Array, Array]]

    def run(self, robot: Robot) -> MeasuredRun:
        """The run of a model."""
        return MeasuredRun.from_samples(robot, self.time, self.positions, pressures=self.pressures)


def recorded(true: Robot, rng: np.random.Generator, load_mass: float) -> Recording:
    """A lift of a load, with noise."""
    motion = moved(true, rng)
    com = np.array([-0.6, 0.35, 0.0]) + rng.uniform(-0.1, 0.1, 3)
    inertia = load_mass * np.diag([0.08, 0.08, 0.08])
    loads = true.loads.with_payload(Payload(load_mass, com, inertia))
    return measured(true, rng, motion, loads)


@dataclass(frozen=True, eq=False)
class Motion:
    """Times (N,) [s], goals and closed states of a motion."""

    time: Array
    goal: Reference
    state: ClosedState


def moved(true: Robot, rng: np.random.Generator) -> Motion:
    """The motion of a lift, with other points each time."""
    spread = TRAVEL * rng.uniform(-1.0, 1.0, (len(TIMES), 4))
    stops = np.zeros((len(TIMES), 4))
    path = JointTrajectory(list(TIMES), PATH + spread, stops, stops)
    time = np.arange(0.0, TIMES[-1], 1.0 / RATE)
    goal = path(time)
    return Motion(time, goal, true.close(goal.u, goal.du))


def measured(true: Robot, rng: np.random.Generator, motion: Motion, loads: Loads) -> Recording:
    """What noisy sensors give of a motion under some loads."""
    time, goal, state = motion.time, motion.goal, motion.state
    tau = true.inverse_dynamics(state, goal.ddu, loads)
    positions: dict[str, Array] = {}
    pressures: dict[str, tuple[Array, Array]] = {}
    for k, name in enumerate(true.active):
        encoder = true.coordinates.index(ENCODERS[name])
        lever = state.R[:, encoder, k]
        positions[name] = goal.u[:, k] + rng.normal(0.0, ENCODER, len(time)) / lever
    for name, cylinder in true.cylinders.items():
        pushing = replace(cylinder, return_pressure=BACK)
        force = tau[:, true.active.index(name)]
        cap, rod = chamber_pressures(pushing, force)
        noise = rng.normal(0.0, PRESSURE, (2, len(time)))
        pressures[name] = (cap + noise[0], rod + noise[1])
    return Recording(time, positions, pressures)
