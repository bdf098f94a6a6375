"""Masses from a recording: base parameters from a bag of joint states with efforts.

python examples/identify_from_bag.py [--bag FOLDER] [--plot FILE]

The forearm of a forging robot is 20 % heavier than its file says, its gripper 30 %. It moves for
half a minute, and its joint states are recorded with noise. From the bag alone the base parameters
are estimated: the combinations of masses and inertias that a motion can show. The last quarter of
the bag tests them. The same on the command line: `hybrid-dynamics bag make` and `hybrid-dynamics
bag identify`.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_ros.bags.analysis.collect import collect
from hybrid_dynamics_ros.bags.analysis.identification_result import IdentificationResult
from hybrid_dynamics_ros.bags.analysis.identify import identify_recording
from hybrid_dynamics_ros.bags.input_topic import INPUT
from hybrid_dynamics_ros.bags.make import simulated, write_trajectory

HEAVIER = {"l3": 1.2, "l4": 1.3}  # mass and inertia of these links, in parts of the file's
NOISE = {"position": 1e-6, "effort": 5.0}  # standard deviations [rad or m], [N m or N]
SECONDS = 30.0  # of the recording
RATE = 1000.0  # [Hz]
TICKS = (-100, -10, -1, 0, 1, 10, 100)


def real_robot() -> Robot:
    """The robot as it is, which the file does not know."""
    description = load("forging_chu2020").description
    links = dict(description.links)
    for name, share in HEAVIER.items():
        link = links[name]
        links[name] = replace(link, mass=share * link.mass, inertia=share * link.inertia)
    return Robot(replace(description, links=links))


def record(bag: Path) -> int:
    """Write the bag; how many messages."""
    motion = simulated(real_robot(), SECONDS, RATE).noisy(NOISE)
    return write_trajectory(bag, motion, INPUT, {"robot": "forging_chu2020"})


def identified(bag: Path) -> IdentificationResult:
    """Base parameters from the bag, and what they are worth on its last quarter."""
    return identify_recording(collect(bag, "forging_chu2020", smooth="spline", most=3000))


def base_parameters(result: IdentificationResult, robot: Robot) -> np.ndarray:
    """The base parameters (b,) of a robot."""
    base = result.identification.base
    return base.values(base.parameters.values(robot.description))


def truth(result: IdentificationResult) -> np.ndarray:
    """The base parameters (b,) of the robot as it is."""
    return base_parameters(result, real_robot())


def plot(result: IdentificationResult, path: str) -> None:
    """Estimates with their intervals, less the truth, each in parts of its interval."""
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing.page import entitled, written_page  # noqa: PLC0415
    from hybrid_dynamics_core.drawing.style import GRID  # noqa: PLC0415

    true = truth(result)
    half_interval = 0.5 * np.ptp(result.identification.interval, axis=1)
    estimate_error = (result.identification.estimate - true) / half_interval
    from_file = base_parameters(result, load("forging_chu2020"))
    file_error = (from_file - true) / half_interval
    heavier = ", ".join(f"{name} {share:g} times" for name, share in HEAVIER.items())
    about = f"links of the recorded robot are heavier than its file says: {heavier}"
    title = "Base parameters of the forging robot from a recording"
    with written_page(path, title, about, height=3.5) as figure:
        axes = figure.subplots()
        axes.axhspan(-1.0, 1.0, color=GRID, linewidth=0.0, label="95 % interval")
        axes.plot(estimate_error, "o", markersize=4.5, label="estimate less the truth")
        axes.plot(file_error, "x", markersize=5.5, label="robot file less the truth")
        axes.set(xlabel="number of the base parameter", ylabel="difference, in half intervals")
        axes.set_yscale("symlog")
        axes.set_yticks(TICKS, [str(tick).replace("-", "−") for tick in TICKS])
        entitled(axes, "what was found, and what the file says", 3)


def main() -> None:
    """Record, identify, print; draw if asked."""
    parser = argparse.ArgumentParser(description="Identification from a bag.")
    parser.add_argument("--bag", metavar="FOLDER", type=Path, help="keep the bag here")
    parser.add_argument("--plot", metavar="FILE", help="write a figure (.svg or .png)")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        bag = options.bag or Path(folder) / "recording"
        print(f"{record(bag)} messages recorded")
        result = identified(bag)
    low, high = result.identification.interval.T
    true = truth(result)
    inside = (low <= true) & (true <= high)
    print(f"{inside.sum()} of {len(inside)} base parameters are within their 95 % intervals")
    print("effort left unexplained on the part kept back: by the file, and identified")
    for k, joint in enumerate(("q1 [N m]", "q12 [N]", "q22 [N]", "q4 [N m]")):
        print(f"  {joint:<9}{result.file_residual[k]:10.1f}{result.residual[k]:10.2f}")
    if options.plot:
        plot(result, options.plot)


if __name__ == "__main__":
    main()
