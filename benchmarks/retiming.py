"""Shortest times along paths, beside those by hand and those of toppra and ruckig.

python -m benchmarks.retiming [--paths N] [--seed S]

toppra and ruckig are compared with where they are installed: `pip install toppra ruckig`.
"""

from __future__ import annotations

import argparse
import textwrap
import time
from importlib.util import find_spec

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

from hybrid_dynamics_core import InputError, Robot, load
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.retiming.ramps import ramp

WAY = 1.5  # [m]
CART = """
    format: 1
    name: cart
    links: {cart: {mass: 2}}
    joints: {x: {type: prismatic, parent: base, child: cart, axis: x, LIMITS}}
    active: [x]
    end_effector: {link: cart}
"""


def cart(limits: str) -> Robot:
    """A mass of 2 kg on a level slide."""
    return Robot(parse_description(textwrap.dedent(CART).replace("LIMITS", limits)))


def with_power(force: float, power: float, mass: float = 2.0) -> float:
    """Shortest time with a force, above power / force with a power, both ways [s]."""
    slow = power / force
    half = WAY / 2.0 - slow**2 * mass / (2.0 * force)
    fast = (3.0 * power * half / mass + slow**3) ** (1.0 / 3.0)
    return float(2.0 * (slow * mass / force + mass / (2.0 * power) * (fast**2 - slow**2)))


def with_falling_force(mass: float = 2.0) -> float:
    """Shortest time with a force of 6 N that falls to nothing at 2 m/s [s]."""

    def acceleration(rate: float) -> float:
        return (6.0 - 3.0 * rate) / mass

    def excess(rate: float) -> float:
        way, _ = quad(lambda v: v / acceleration(v), 0.0, rate)
        return float(way - WAY / 2.0)

    fastest = brentq(excess, 0.0, 1.999)
    span, _ = quad(lambda v: 1.0 / acceleration(v), 0.0, fastest)
    return float(2.0 * span)


def by_hand() -> dict[str, tuple[str, float]]:
    """Limits of the cart, and its shortest time [s]."""
    return {
        "force": ("effort_limit: 6", 2.0 * (WAY / 3.0) ** 0.5),
        "rate": ("effort_limit: 6, velocity_limit: 1", WAY + 1.0 / 3.0),
        "power": ("effort_limit: 6, power_limit: 4", with_power(6.0, 4.0)),
        "table": ("effort_table: {rate: [0, 2], effort: [6, 0]}", with_falling_force()),
    }


def toppra_time(robot: Robot, path: Array, count: int = 400) -> float:
    """Shortest time [s] by toppra along the same curve, within pressures and rates."""
    import toppra  # noqa: PLC0415  not everywhere
    from toppra.algorithm import TOPPRA  # noqa: PLC0415
    from toppra.constraint import SecondOrderConstraint  # noqa: PLC0415

    toppra.setup_logging("ERROR")
    names = robot.drives
    bounds = [robot.effort_ranges[name] for name in names]
    lower, upper = np.transpose(bounds)

    def forces(u: Array, du: Array, ddu: Array) -> Array:
        state = robot.close(u, du)
        by_name = robot.drive_forces(state, robot.inverse_dynamics(state, ddu))
        return np.array([by_name[name] for name in names])

    def rows(_u: Array) -> Array:
        return np.vstack([np.eye(len(names)), -np.eye(len(names))])

    def right(_u: Array) -> Array:
        return np.concatenate([upper, -lower])

    constraint = SecondOrderConstraint(
        forces, rows, right, dof=len(robot.active), discretization_scheme=1
    )
    curve = robot.retime(path, stations=20).curve
    s = np.linspace(0.0, curve.end, count + 1)
    spline = toppra.SplineInterpolator(curve.s, curve.points, curve.boundary)
    timed = TOPPRA([constraint], spline, gridpoints=s)
    _, rate, _ = timed.compute_parameterization(0.0, 0.0)
    return float((2.0 * np.diff(s) / (rate[1:] + rate[:-1])).sum())


def ruckig_error(count: int, seed: int) -> float:
    """Largest relative difference of durations of ramps from those of ruckig."""
    from ruckig import InputParameter, Ruckig, Trajectory  # noqa: PLC0415  not everywhere

    rng = np.random.default_rng(seed)
    worst = 0.0
    for _ in range(count):
        way, rate, acceleration, jerk = 10.0 ** rng.uniform(-2.0, 2.0, 4)
        given, trajectory = InputParameter(1), Trajectory(1)
        given.current_position, given.target_position = [0.0], [way]
        given.max_velocity, given.max_acceleration = [rate], [acceleration]
        given.max_jerk = [jerk]
        Ruckig(1).calculate(given, trajectory)
        other = trajectory.duration
        worst = max(worst, abs(ramp(way, rate, acceleration, jerk).duration / other - 1.0))
    return worst


def excavator_paths(count: int, seed: int) -> list[Array]:
    """Random paths of boom, stick and bucket that the excavator can follow [m]."""
    robot = load("excavator")
    rng = np.random.default_rng(seed)
    paths: list[Array] = []
    while len(paths) < count:
        path = robot.reference + rng.uniform(-0.15, 0.15, (3, 4)) * np.array([0.0, 1.0, 1.0, 1.0])
        try:
            robot.retime(path, stations=20)
        except InputError:
            continue
        paths.append(path)
    return paths


def main() -> None:
    """Print all comparisons."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.retiming", description=__doc__)
    parser.add_argument("--paths", type=int, default=10, help="random paths of the excavator")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    for name, (limits, shortest) in by_hand().items():
        motion = cart(limits).retime([[0.0], [WAY]])
        print(f"{name}: {motion.duration:.5f} s, by hand {shortest:.5f} s")
    if find_spec("ruckig"):
        print(f"ramps, less ruckig: {ruckig_error(1000, arguments.seed):.1e} of the duration")
    robot = load("excavator")
    has_toppra = find_spec("toppra") is not None
    for path in excavator_paths(arguments.paths, arguments.seed):
        begin = time.perf_counter()
        motion = robot.retime(path)
        spent = time.perf_counter() - begin
        line = f"excavator: {motion.duration:.5f} s, found in {spent:.2f} s"
        if has_toppra:
            line += f", toppra {toppra_time(robot, path):.5f} s"
        print(line)


if __name__ == "__main__":
    main()
