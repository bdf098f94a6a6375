"""Weighing a bucket: the mass of its load from pressures of three cylinders.

python examples/weighing_bucket.py [--plot FILE]

A lift is recorded with noise: pressures 0.1 bar, strokes 0.2 mm. The file of the machine says that
its stick is 1 % lighter than it is, and nothing about friction. The load is weighed without and
with a run of the empty bucket. The machine, its load and its friction are assumed.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from hybrid_dynamics_core import Payload, Robot, load
from hybrid_dynamics_core.control import JointTrajectory
from hybrid_dynamics_core.description.effects import JointEffect
from hybrid_dynamics_core.estimation import MeasuredRun, PayloadEstimate, estimate_payload

MASS = 1350.0  # [kg] of the load, that nobody knows
PLACE = [-0.6, 0.35, 0.0]  # of its centre of mass, from the teeth [m]
FRICTION = {"boom_cylinder": 5e3, "stick_cylinder": 3e3, "bucket_cylinder": 2e3}  # [N]
NOISE = {"pressure": 0.1e5, "stroke": 2e-4}  # [Pa], [m]
TIMES = [0.0, 3.0, 6.0, 9.0, 12.0]  # [s] at the points below
POINTS = [  # slewing [rad], cylinders of boom, stick and bucket [m]
    [0.0, 0.40, 1.05, 0.85],  # dug
    [0.3, 0.80, 0.95, 0.92],  # lifted
    [1.2, 0.80, 0.70, 0.88],  # swung and reached out
    [1.2, 0.60, 0.80, 0.94],  # lowered
    [0.9, 0.70, 0.95, 0.90],  # and back
]


def true_machine(robot: Robot) -> Robot:
    """The machine as it is: a heavier stick, and friction in its cylinders."""
    links = dict(robot.description.links)
    links["stick"] = replace(links["stick"], mass=1.01 * links["stick"].mass)
    effects = dict(robot.description.effects)
    for joint, coulomb in FRICTION.items():
        effects[joint] = JointEffect(coulomb=coulomb)
    changes = {"links": MappingProxyType(links), "effects": MappingProxyType(effects)}
    return Robot(replace(robot.description, **changes))


def recorded(
    true: Robot, model: Robot, mass: float, rng: np.random.Generator
) -> tuple[MeasuredRun, np.ndarray]:
    """What the sensors of a lift show, and the efforts that the model needs without load [N]."""
    t = np.arange(0.0, TIMES[-1], 0.02)
    stop = np.zeros_like(POINTS)
    goal = JointTrajectory(TIMES, POINTS, stop, stop)(t)
    state = true.close(goal.u, goal.du)
    tau = true.inverse_dynamics(state, goal.ddu, true.loads.with_payload(Payload(mass, PLACE)))
    strokes = goal.u + rng.normal(0.0, NOISE["stroke"], goal.u.shape)
    pressures = {}
    for name, cylinder in true.hydraulics(state, tau).items():
        sides = np.stack([cylinder.cap_pressure, cylinder.rod_pressure])
        pressures[name] = tuple(sides + rng.normal(0.0, NOISE["pressure"], sides.shape))
    positions = dict(zip(true.active, strokes.T, strict=True))
    run = MeasuredRun.from_samples(model, t, positions, pressures=pressures)
    return run, model.inverse_dynamics(state, goal.ddu)[:, 1:]


def weighed() -> tuple[MeasuredRun, np.ndarray, dict[str, PayloadEstimate]]:
    """The run, the efforts of the model without load, and both estimates."""
    model = load("excavator")
    true = true_machine(model)
    rng = np.random.default_rng(4)
    run, required = recorded(true, model, MASS, rng)
    empty, _ = recorded(true, model, 0.0, rng)
    estimates = {
        "without an empty run": estimate_payload(run),
        "with an empty run": estimate_payload(run, empty),
    }
    return run, required, estimates


def plot(
    run: MeasuredRun, required: np.ndarray, estimates: dict[str, PayloadEstimate], path: str
) -> None:
    """The force of the boom's cylinder, measured and needed, and both intervals."""
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing.page import entitled, written_page  # noqa: PLC0415
    from hybrid_dynamics_core.drawing.style import INK, LOOPS  # noqa: PLC0415

    about = f"a load of {MASS:.0f} kg, weighed by the pressures of three cylinders"
    with written_page(path, "Weighing a bucket", about, height=5.2) as figure:
        force, mass = figure.subplots(2, 1, height_ratios=[2.2, 1.0])
        force.plot(run.time, run.efforts[:, 0] / 1e3, color=LOOPS[0], label="measured")
        force.plot(run.time, required[:, 0] / 1e3, color=LOOPS[1], label="model, empty bucket")
        force.set(xlabel="t [s]", ylabel="boom cylinders [kN]", ylim=(0.0, None))
        for k, (name, estimate) in enumerate(estimates.items()):
            colour = LOOPS[k + 2]
            mass.plot(estimate.interval, [k, k], color=colour, linewidth=3.0, label=name)
            mass.plot([estimate.mass], [k], "o", color=colour)
        mass.plot([MASS, MASS], [-0.5, 1.5], "--", color=INK, label="truth")
        mass.set(xlabel="mass [kg]", ylabel="run", ylim=(-0.5, 1.5), yticks=[])
        entitled(force, "what the load adds", 2)
        entitled(mass, "estimates with 95 % intervals", 3)


def main() -> None:
    """Print the estimates; draw if asked."""
    parser = argparse.ArgumentParser(description="Weighing a bucket.")
    parser.add_argument("--plot", metavar="FILE", help="write a figure (.svg or .png)")
    options = parser.parse_args()
    run, required, estimates = weighed()
    for name, estimate in estimates.items():
        low, high = estimate.interval
        print(f"{name:>20}: {estimate.mass:6.1f} kg, {low:.0f} to {high:.0f} kg with 95 %")
    x, y, _ = estimates["with an empty run"].com
    print(f"its centre of mass is {x:+.2f} m, {y:+.2f} m from the teeth")
    if options.plot:
        plot(run, required, estimates, options.plot)


if __name__ == "__main__":
    main()
