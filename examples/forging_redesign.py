"""The forging robot of Chu et al. (2020) with its cylinders placed anew, for the least force.

python examples/forging_redesign.py [--plot FILE]

Arm and path stay those of the paper, with a billet of 20 kg. Ten numbers are free: both coordinates
of the four pins of the two cylinders, and the lengths of their barrels. Each force along the path,
pushing or pulling, counts as a share of the largest of its cylinder with the paper's pins. The
largest share is to be least, within the strokes and away from singular places. Then the smallest
cylinders of a catalogue are chosen for the paper's pins and for the new ones.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from hybrid_dynamics_core import Loads, Payload, Robot, load
from hybrid_dynamics_core.design import (
    Cycle,
    Design,
    DesignResult,
    Duty,
    Method,
    Quantity,
    joined,
)
from hybrid_dynamics_core.sizing import Margins, Sizing, read_catalogue, read_duty, size_drive

CATALOGUE = Path(__file__).parent / "catalogues" / "short_cylinders.csv"
PINS = {  # bounds [m]
    "joints.q11.origin.xyz[0]": (-0.8, -0.3),
    "joints.q11.origin.xyz[2]": (0.0, 0.4),
    "loops.theta_1.pin.l2[0]": (0.2, 0.6),
    "loops.theta_1.pin.l2[1]": (-0.1, 0.1),
    "joints.q12.origin.xyz[0]": (0.395, 0.45),
    "joints.q21.origin.xyz[0]": (0.0, 0.4),
    "joints.q21.origin.xyz[1]": (-0.1, 0.1),
    "loops.theta_2.pin.l3[0]": (-0.3, -0.1),
    "loops.theta_2.pin.l3[1]": (-0.1, 0.1),
    "joints.q22.origin.xyz[0]": (0.395, 0.45),
}
CYLINDERS = ("q12", "q22")
STROKE = (0.06, 0.29)  # [m] beyond the barrel
BILLET = 20.0  # [kg]
START = (0.0, 0.10, 0.15, 0.0)
RATES = (np.deg2rad(10.0), 0.01, 0.005, np.deg2rad(5.0))  # of the paper's path, for 10 s


def path(robot: Robot, points: int = 20) -> list[Duty]:
    """The paper's path in joint angles, which stay when pins move."""
    rates = np.broadcast_to(RATES, (points, 4))
    time = np.linspace(0.0, 10.0, points)
    state = robot.close(START + time[:, None] * rates, rates)
    accelerations = robot.accelerations(state, np.zeros((points, 4)))
    places = {name: robot.coordinates.index(name) for name in ("q1", "q2", "q3", "q4")}
    loads = billet(robot)
    duty: list[Duty] = []
    for k in range(points):
        at = {name: float(state.s[k, j]) for name, j in places.items()}
        velocity = {name: float(state.ds[k, j]) for name, j in places.items()}
        change = {name: float(accelerations[k, j]) for name, j in places.items()}
        duty.append(Duty(at, velocity, change, loads))
    return duty


def billet(robot: Robot) -> Loads:
    """The robot's loads with the billet."""
    return robot.loads.with_payload(Payload(BILLET))


def largest_forces(cycle: Cycle) -> list[float]:
    """Largest force of each cylinder [N]."""
    return [float(np.abs(cycle.effort(name).value).max()) for name in CYLINDERS]


def shares(cycle: Cycle, largest: list[float]) -> Quantity:
    """Forces of both cylinders, in either direction, as shares of other ones."""
    parts: list[Quantity] = []
    for name, force in zip(CYLINDERS, largest, strict=True):
        share = cycle.effort(name) / force
        parts += [share, -share]
    return joined(*parts)


def strokes(cycle: Cycle) -> Quantity:
    """Way to both ends of the strokes [m]."""
    first, second = (cycle.coordinate(name) for name in CYLINDERS)
    low, high = STROKE
    return joined(first - low, high - first, second - low, high - second)


def problem(points: int = 20) -> Design:
    """The design: pins, path, and the angles that the path names."""
    robot = load("forging_chu2020")
    return Design(robot, PINS, path(robot, points), given=("q1", "q2", "q3", "q4"))


def solve(design: Design, starts: int = 1, method: Method = "SLSQP") -> DesignResult:
    """The pins with the least largest share of the paper's forces."""
    largest = largest_forces(design.cycle())
    limits = {"strokes": strokes, "regular": lambda cycle: cycle.distance() - 0.3}
    return design.minimise_largest(
        lambda cycle: shares(cycle, largest), limits, starts=starts, method=method
    )


def chosen(robot: Robot) -> dict[str, Sizing]:
    """The smallest cylinders of the catalogue for the path."""
    columns: dict[str, list[float]] = {"payload": []}
    for point in path(load("forging_chu2020")):
        columns["payload"].append(BILLET)
        for name, value in point.at.items():
            columns.setdefault(name, []).append(value)
            columns.setdefault(f"{name}.velocity", []).append(point.rates[name])
            columns.setdefault(f"{name}.acceleration", []).append(point.accelerations[name])
    duty = read_duty(columns, robot)
    catalogue = read_catalogue(CATALOGUE)
    margins = Margins(pressure=1.2)
    return {name: size_drive(robot, duty, catalogue, name, margins) for name in CYLINDERS}


def plot(design: Design, result: DesignResult, file: str) -> None:
    """Forces along the path before and after."""
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing.page import entitled, written_page  # noqa: PLC0415
    from hybrid_dynamics_core.drawing.style import QUIET, RED  # noqa: PLC0415

    about = "four pins and two barrels are free; arm, path and loads are those of the paper"
    time = np.linspace(0.0, 10.0, 20)
    before, after = design.cycle(), design.cycle(list(result.values.values()))
    with written_page(file, "The forging robot with new pins", about, height=3.5) as figure:
        for axes, name in zip(figure.subplots(1, 2, sharey=True), CYLINDERS, strict=True):
            axes.plot(time, before.effort(name).value / 1e3, color=QUIET, label="paper's pins")
            axes.plot(time, after.effort(name).value / 1e3, color=RED, label="new pins")
            axes.axhline(0.0, color=QUIET, linewidth=0.5)
            axes.set(xlabel="time [s]", ylabel="force [kN]")
            entitled(axes, f"cylinder {name}", 2)


def main() -> None:
    """Print what changes; draw if asked."""
    parser = argparse.ArgumentParser(
        description="The forging robot with its cylinders placed anew."
    )
    parser.add_argument("--plot", metavar="FILE", help="write a figure (.svg or .png)")
    options = parser.parse_args()
    design = problem()
    result = solve(design, starts=2)
    before = largest_forces(design.cycle())
    after = largest_forces(design.cycle(list(result.values.values())))
    for name, old, new in zip(CYLINDERS, before, after, strict=True):
        print(f"largest force of {name}: {old:.0f} N before, {new:.0f} N after")
    for (name, value), start in zip(result.values.items(), design.start, strict=True):
        print(f"  {name}: {start:.3f} m before, {value:.3f} m after")
    print(f"active: {', '.join(result.active)}")
    for words, robot in (("before", load("forging_chu2020")), ("after", result.robot)):
        for name, sizing in chosen(robot).items():
            fitting = sizing.chosen
            print(f"{words}: {name} takes {fitting.name if fitting else 'none of the catalogue'}")
    if options.plot:
        plot(design, result, options.plot)


if __name__ == "__main__":
    main()
