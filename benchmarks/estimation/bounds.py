"""The least deviations that any method can have: Cramer-Rao bounds of mass and force.

A bound holds for all methods that know no more than the sensors, the deviations of the model, and
that a force is constant for some time.
"""

from __future__ import annotations

import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.dynamics.load_pattern import INERTIAL
from hybrid_dynamics_core.estimation import MeasuredRun, Tolerances
from hybrid_dynamics_core.estimation.equations import Modelling, to_drives
from hybrid_dynamics_core.estimation.fit import System, solved
from hybrid_dynamics_core.ground.arrays import Array

from .lifts import (
    ENCODER,
    ENCODERS,
    FRICTION,
    LINKS,
    PRESSURE,
    RATE,
    Motion,
    machine,
    moved,
    recorded,
)

CONFIDENT = 1.96  # deviations that hold 95 %
ERRORS = {  # of masses of links: standard deviation as a share
    "a deviation of 1 %": LINKS,
    "1 % at most, evenly spread": LINKS / np.sqrt(3.0),
    "a deviation of 0.5 %": 0.5 * LINKS,
}
LOAD = 1000.0  # [kg] that is weighed
OPEN = 1e6  # deviation of what nothing is known of
WINDOWS = (0.3, 0.5, 1.0)  # [s] for which a force is constant
SIZE, ANGLE = 0.02, np.deg2rad(5.0)  # that are wanted
HEAD = "| force constant for | by encoders | by links and friction | 2 % from | 5 degrees from |"


def mass_bound(seed: int = 0, links: float = LINKS) -> float:
    """Least deviation of a mass [kg] where friction is known, but masses of links are not.

    Args:
        seed: of the machine.
        links: standard deviation of these masses, as a share.
    """
    rng = np.random.default_rng(seed)
    both = machine(rng)
    run = recorded(both.true, rng, LOAD).run(both.model)
    limits = Tolerances(links, 0.0, 0.0, 0.0, 0.0, friction_share=0.0)
    modelling = Modelling(run, both.model.loads, both.model.end_effector, limits)
    load = np.full(INERTIAL, OPEN)
    unknowns = modelling.unknowns([run], load)
    equations = modelling.equations(run, loaded=True)
    noise = _noise(both.model, run)
    zero = np.zeros(len(unknowns.deviation))
    same_run = np.zeros(len(equations.target))
    system = System(equations.matrix, equations.target, zero, unknowns.deviation, noise, same_run)
    return float(np.sqrt(solved(system, noise).covariance[0, 0]))


def _noise(robot: Robot, run: MeasuredRun) -> Array:
    """Deviation (k,) of the force of each cylinder by noise of pressures [N]."""
    deviations: list[float] = []
    for name in run.drives:
        cylinder = robot.cylinders[name]
        deviations.append(PRESSURE * float(np.hypot(cylinder.cap_area, cylinder.rod_area)))
    return np.array(deviations)


def force_bounds(seed: int = 0) -> list[str]:
    """The table of bounds of a force in the plane of the arm."""
    rng = np.random.default_rng(seed)
    both = machine(rng)
    motion = moved(both.true, rng)
    run = recorded(both.true, rng, 0.0).run(both.model)
    lines = [HEAD, "|---|---|---|---|---|"]
    for window in WINDOWS:
        by_encoders = _deviations(both.model, motion, run, window, by_model=False)
        by_model = _deviations(both.model, motion, run, window, by_encoders=False)
        together = _deviations(both.model, motion, run, window)
        worst = CONFIDENT * float(np.median(together))
        cells = [
            f"{window:g} s",
            f"{np.median(by_encoders):.0f} N",
            f"{np.median(by_model):.0f} N",
            f"{worst / SIZE / 1e3:.1f} kN",
            f"{worst / np.tan(ANGLE) / 1e3:.1f} kN",
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def _deviations(
    robot: Robot,
    motion: Motion,
    run: MeasuredRun,
    window: float,
    *,
    by_encoders: bool = True,
    by_model: bool = True,
) -> Array:
    """Least deviation (N,) of a force along an axis of the plane, at each sample [N].

    Args:
        robot: the model.
        motion: the true motion.
        run: a run of it.
        window: time for which the force is constant [s].
        by_encoders: whether encoders have noise.
        by_model: whether links and friction are off.
    """
    samples = window * RATE
    state = motion.state
    noise = _noise(robot, run) / np.sqrt(samples)
    covariance = np.broadcast_to(np.diag(noise**2), (len(motion.time), 3, 3)).copy()
    mapping = to_drives(robot, state, run.drives)
    if by_encoders:
        # of the second derivative of a parabola through equally spaced samples
        factor = ENCODER * np.sqrt(720.0 / samples) / window**2
        levers = []
        for k, name in enumerate(robot.active):
            levers.append(state.R[:, robot.coordinates.index(ENCODERS[name]), k])
        deviation = factor / np.stack(levers, axis=1)
        inertia = mapping @ robot.minimal_form(state)[0]
        columns = inertia * deviation[:, None, :]
        covariance += columns @ np.swapaxes(columns, 1, 2)
    if by_model:
        limits = Tolerances(LINKS, FRICTION, 0.0, 0.0, 0.0, friction_share=0.0)
        modelling = Modelling(run, robot.loads, robot.end_effector, limits)
        unknowns = modelling.unknowns([run], np.zeros(INERTIAL))
        columns = modelling.equations(run, loaded=False).matrix * unknowns.deviation
        covariance += columns @ np.swapaxes(columns, 1, 2)
    pose = robot.forward_kinematics(state)
    jacobian = np.swapaxes(pose.rotation, 1, 2) @ robot.jacobian(state)[:, :3]
    effect = mapping @ np.swapaxes(jacobian[:, :2], 1, 2)
    information = np.swapaxes(effect, 1, 2) @ np.linalg.solve(covariance, effect)
    inverse = np.linalg.inv(information)
    return np.asarray(np.sqrt(np.trace(inverse, axis1=1, axis2=2) / 2.0))
