"""A steam engine turns through its dead centres: a flywheel carries crank and rod past them.

python examples/flywheel_through_dead_centres.py [--plot FILE]

The piston is the active joint, pushed by steam on alternate sides. At both ends of its stroke it
turns back, and no force along it moves the crank. With crank and rod of equal lengths the linkage
can also fold, with the piston in the middle: there the crank could go on alone.
"""

from __future__ import annotations

import argparse

import numpy as np

from hybrid_dynamics_core import ClosedState, Robot
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.simulation import Settings, Simulation, simulate

ENGINE = """
format: 1
name: steam_engine
gravity: [0, -9.81, 0]
links:
  base: {{}}
  flywheel: {{mass: 30, com: [0, 0, 0], inertia: {{xx: 0.6, yy: 0.6, zz: 1.2}}}}
  rod: {{mass: 4, com: [{rod}/2, 0, 0], inertia: {{xx: 0.001, yy: 0.09, zz: 0.09}}}}
  piston: {{mass: 6}}
joints:
  stroke: {{type: prismatic, parent: base, child: piston, axis: x, friction: {{viscous: 40}}}}
  wheel: {{type: revolute, parent: base, child: flywheel, axis: z, friction: {{viscous: 0.4}}}}
  swing: {{type: revolute, parent: flywheel, child: rod, axis: z, origin: {{xyz: [0.2, 0, 0]}}}}
closures:
  pin: {{kind: planar, between: {{rod: [{rod}, 0, 0], piston: [0, 0, 0]}}}}
active: [stroke]
end_effector: {{link: piston}}
reference: {{wheel: 1, swing: {swing}}}
"""
RODS = {"long rod": 0.5, "rod as long as the crank": 0.2}  # [m]
STEAM = 400.0  # [N]


def engine(rod: float) -> Robot:
    """The engine with a rod of some length [m]."""
    swing = -np.arcsin(0.2 * np.sin(1.0) / rod) - 1.0
    return Robot(parse_description(ENGINE.format(rod=rod, swing=float(swing))))


def steam(_time: float, state: ClosedState) -> list[float]:
    """The slide valve changes over as the piston turns; smoothed [N]."""
    return [STEAM * float(np.tanh(state.du[0] / 0.1))]


def run(rod: float, seconds: float = 1.5) -> Simulation:
    """The motion from a slow turn of the flywheel."""
    machine = engine(rod)
    start = machine.close_given({"wheel": 1.0}, {"wheel": 3.0})
    settings = Settings(rate=200.0, through_change_points=True, progress=False)
    return simulate(machine, start, None, steam, (0.0, seconds), settings)


def plot(runs: dict[str, Simulation], path: str) -> None:
    """Piston and flywheel, with the places that they pass."""
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing.page import entitled, written_page  # noqa: PLC0415
    from hybrid_dynamics_core.drawing.style import QUIET, RED  # noqa: PLC0415

    about = "steam pushes a piston, which turns back at its dead centres; a flywheel goes on"
    with written_page(path, "A steam engine starts", about, height=6.0) as figure:
        panels = figure.subplots(2, 2, sharex=True)
        for column, (name, motion) in zip(panels.T, runs.items(), strict=True):
            stroke, speed = column
            stroke.plot(motion.t, motion.u[:, 0], color=QUIET)
            speed.plot(motion.t, motion.state.ds[:, 1], color=QUIET)
            for kind, mark in (("toggle", "|"), ("change point", "o")):
                events = [event for event in motion.events if event.passage.kind == kind]
                if not events:
                    continue
                times = [event.time for event in events]
                places = [event.passage.s[0] for event in events]
                rates = [event.passage.rates[1] for event in events]
                label = {"toggle": "dead centre"}.get(kind, kind)
                stroke.plot(times, places, mark, color=RED, ms=5, mfc="none", label=label)
                speed.plot(times, rates, mark, color=RED, ms=5, mfc="none", label=label)
            entitled(stroke, f"{name}: piston", 2)
            entitled(speed, f"{name}: flywheel", 2)
            stroke.set(ylabel="piston [m]")
            speed.set(xlabel="time [s]", ylabel="flywheel [rad/s]")


def main() -> None:
    """Print what is passed; draw if asked."""
    parser = argparse.ArgumentParser(description="A steam engine turns through dead centres.")
    parser.add_argument("--plot", metavar="FILE", help="write a figure (.svg or .png)")
    options = parser.parse_args()
    runs = {name: run(rod) for name, rod in RODS.items()}
    for name, motion in runs.items():
        kinds = [event.passage.kind for event in motion.events]
        turned = (motion.state.s[-1, 1] - motion.state.s[0, 1]) / (2.0 * np.pi)
        print(
            f"{name}: {turned:.1f} turns in {motion.t[-1]:g} s, through {kinds.count('toggle')}"
            f" dead centres and {kinds.count('change point')} change points, in"
            f" {motion.steps} steps; energy error {motion.relative_energy_error:.0e}"
        )
    if options.plot:
        plot(runs, options.plot)


if __name__ == "__main__":
    main()
