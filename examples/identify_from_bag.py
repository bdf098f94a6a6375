"""Masses from a recording: a bag of joint states with efforts tells what a robot weighs, with confidence.

python examples/identify_from_bag.py [--bag FOLDER] [--plot FILE]

A forging robot whose forearm is 20 % and whose gripper is 30 % heavier than its file says moves for
half a minute, and its joint states are recorded with noise. From the bag alone the base parameters
are found, those combinations of masses and inertias that any motion can show; the last quarter of
the bag is kept back to test them on. The same on the command line: `hybrid-dynamics bag make` and
`hybrid-dynamics bag identify`.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_ros.bags.analysis.collect import collect
from hybrid_dynamics_ros.bags.analysis.identify import Found, identify_track
from hybrid_dynamics_ros.bags.make import simulated, write_trajectory
from hybrid_dynamics_ros.bags.process import INPUT

HEAVIER = {"l3": 1.2, "l4": 1.3}  # mass and inertia of these links, in parts of the file's
NOISE = {"position": 1e-6, "effort": 5.0}  # standard deviations [rad or m], [N m or N]
SECONDS, RATE = 30.0, 1000.0  # of the recording


def real_robot() -> Robot:
    """The robot as it is, which the file does not know."""
    description = load("forging_chu2020").description
    links = dict(description.links)
    for name, share in HEAVIER.items():
        links[name] = replace(
            links[name], mass=share * links[name].mass, inertia=share * links[name].inertia
        )
    return Robot(replace(description, links=links))


def record(bag: Path) -> int:
    """Write the bag; how many messages."""
    motion = simulated(real_robot(), SECONDS, RATE).noisy(NOISE)
    return write_trajectory(bag, motion, INPUT, {"robot": "forging_chu2020"})


def identified(bag: Path) -> Found:
    """Base parameters from the bag, and what they are worth on its last quarter."""
    return identify_track(collect(bag, "forging_chu2020", smooth="spline", most=3000))


def truth(found: Found) -> np.ndarray:
    """The base parameters (b,) of the robot as it is."""
    base = found.result.base
    return base.values(base.parameters.values(real_robot().description))


def plot(found: Found, path: str) -> None:
    """Estimates with their intervals, less the truth, each in parts of its interval."""
    from hybrid_dynamics_core.drawing.page import (  # noqa: PLC0415  needs Matplotlib
        entitled,
        written_page,
    )
    from hybrid_dynamics_core.drawing.style import GRID  # noqa: PLC0415

    reach = 0.5 * np.ptp(found.result.interval, axis=1)
    base = found.result.base
    told = base.values(base.parameters.values(load("forging_chu2020").description))
    heavier = ", ".join(f"{name} {share:g} times" for name, share in HEAVIER.items())
    about = f"links of the recorded robot are heavier than its file says: {heavier}"
    with written_page(
        path, "Base parameters of the forging robot from a recording", about, height=3.5
    ) as figure:
        axes = figure.subplots()
        axes.axhspan(-1.0, 1.0, color=GRID, linewidth=0.0, label="95 % interval")
        axes.plot(
            (found.result.estimate - truth(found)) / reach,
            "o",
            markersize=4.5,
            label="estimate less the truth",
        )
        axes.plot(
            (told - truth(found)) / reach, "x", markersize=5.5, label="robot file less the truth"
        )
        axes.set(
            xlabel="number of the base parameter",
            ylabel="difference, in half intervals",
            yscale="symlog",
        )
        axes.set_yticks(
            [-100, -10, -1, 0, 1, 10, 100], ["−100", "−10", "−1", "0", "1", "10", "100"]
        )
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
        found = identified(bag)
    inside = (truth(found) >= found.result.interval[:, 0]) & (
        truth(found) <= found.result.interval[:, 1]
    )
    print(f"{inside.sum()} of {len(inside)} base parameters are within their 95 % intervals")
    print("effort left unexplained on the part kept back: by the file, and identified")
    for k, joint in enumerate(("q1 [N m]", "q12 [N]", "q22 [N]", "q4 [N m]")):
        print(f"  {joint:<9}{found.before[k]:10.1f}{found.noise[k]:10.2f}")
    if options.plot:
        plot(found, options.plot)


if __name__ == "__main__":
    main()
