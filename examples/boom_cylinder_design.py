"""The boom cylinder of an excavator is placed so that its force is level over the swing.

python examples/boom_cylinder_design.py [--plot FILE]

Four numbers say where the cylinder's pins are. Over the swing of the boom its force is to be level,
within the stroke that it has, below the force that its bore gives, and away from singular places.
The gradients are exact. Then the smallest bore for the new forces is read from ISO 3320.
"""

from __future__ import annotations

import argparse

import numpy as np

from hybrid_dynamics_core import load
from hybrid_dynamics_core.design import Cycle, Design, DesignResult, Duty, Quantity, size_bores

NAME = "boom_cylinder"
PINS = {  # bounds [m]: on the boom along and above its line, on the house ahead and up
    "loops.boom_loop.pin.boom[0]": (1.6, 3.2),
    "loops.boom_loop.pin.boom[1]": (0.1, 1.0),
    "joints.boom_barrel_pitch.origin.xyz[0]": (0.3, 0.9),
    "joints.boom_barrel_pitch.origin.xyz[2]": (0.9, 1.6),
}
GIVEN = ("slew", "boom_pitch", "stick_cylinder", "bucket_cylinder")
SWING = np.linspace(-0.3, 0.8, 20)  # [rad] of the boom
STROKE = (0.05, 1.15)  # [m]
PRESSURE = 14e6  # [Pa] that the cylinder may take


def unevenness(cycle: Cycle) -> Quantity:
    """Deviation of the force from its mean, as a share of that."""
    force = cycle.effort(NAME)
    apart = force - force.mean()
    return (apart * apart).mean().sqrt() / force.mean()


def designed(starts: int = 2) -> tuple[Design, DesignResult]:
    """The design and its result."""
    design = Design(load("excavator"), PINS, [Duty({"boom_pitch": a}) for a in SWING], GIVEN)
    limits = {
        "retracted": lambda cycle: cycle.coordinate(NAME) - STROKE[0],
        "extended": lambda cycle: STROKE[1] - cycle.coordinate(NAME),
        "pressure": lambda cycle: PRESSURE - cycle.pressure(NAME),
        "regular": lambda cycle: cycle.distance() - 0.1,
    }
    return design, design.minimise(unevenness, limits, starts=starts)


def plot(design: Design, result: DesignResult, path: str) -> None:
    """Forces and strokes before and after."""
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing.page import entitled, written_page  # noqa: PLC0415
    from hybrid_dynamics_core.drawing.style import QUIET, RED  # noqa: PLC0415

    about = (
        "four coordinates of two pins, within the stroke, below the pressure limit and away from"
        " singular places"
    )
    cycles = (design.cycle(), design.cycle(list(result.values.values())))
    with written_page(path, "A boom cylinder whose force is level", about, height=3.5) as figure:
        forces, strokes = figure.subplots(1, 2)
        for cycle, colour, name in zip(cycles, (QUIET, RED), ("before", "after"), strict=True):
            angle = np.degrees(SWING)
            forces.plot(angle, cycle.effort(NAME).value / 1e3, color=colour, label=name)
            strokes.plot(angle, cycle.coordinate(NAME).value, color=colour, label=name)
        forces.set(xlabel="angle of the boom [deg]", ylabel="force of the cylinder [kN]")
        strokes.set(xlabel="angle of the boom [deg]", ylabel="stroke [m]")
        forces.set_ylim(bottom=0.0)
        entitled(forces, "what the cylinder holds", 2)
        entitled(strokes, "how far it is out", 2)


def main() -> None:
    """Print where the pins go and what they give; draw if asked."""
    parser = argparse.ArgumentParser(description="A boom cylinder whose force is level.")
    parser.add_argument("--plot", metavar="FILE", help="write a figure (.svg or .png)")
    options = parser.parse_args()
    design, result = designed()
    before = float(unevenness(design.cycle()).value)
    print(f"the force is off its mean by {100 * before:.1f} % before,", end=" ")
    print(f"by {100 * result.objective:.1f} % after")
    for name, value in result.values.items():
        print(f"  {name}: {value:.3f} m")
    print(f"active: {', '.join(result.active)}")
    robot = result.robot
    held = {"slew": 0.0, "stick_cylinder": 0.7, "bucket_cylinder": 0.6}
    states = [robot.close_given({**held, "boom_pitch": angle}) for angle in SWING[::5]]
    bore = size_bores(robot, [(state, None) for state in states], {NAME: PRESSURE})[NAME]
    print(f"a bore of {1e3 * bore.needed:.0f} mm is enough; ISO 3320: {1e3 * bore.bore:.0f} mm")
    if options.plot:
        plot(design, result, options.plot)


if __name__ == "__main__":
    main()
