"""Staicu's robot of two modules on a circle: poses to legs, and legs back to poses.

python examples/staicu_path.py [--plot FILE]

The lower module carries the platform round a circle, the upper one tilts it towards the middle. All
18 leg variables follow from the pose with their rates. Then the six legs alone are given, and the
pose comes back.
"""

from __future__ import annotations

import argparse
import math

import numpy as np

from hybrid_dynamics_core import load

RADIUS = 0.08  # of the circle [m]
TILT = 0.15  # of the platform [rad]
PERIOD = 4.0  # of one turn [s]
STYLES = {"A": "-", "B": "-", "C": "-", "D": "--", "E": "--", "F": "--"}  # of the legs' curves
POSE = ("x", "y", "z", "alpha_1", "alpha_2", "alpha_3")


def pose(t: float) -> tuple[dict[str, float], dict[str, float]]:
    """Pose by coordinate [m, rad] and its rates at a time [s]."""
    w = 2.0 * math.pi / PERIOD
    c = math.cos(w * t)
    s = math.sin(w * t)
    values = {
        "x": RADIUS * c,
        "y": RADIUS * s,
        "z": -0.02,
        "alpha_1": TILT * s,
        "alpha_2": -TILT * c,
        "alpha_3": 0.0,
    }
    rates = {"x": -RADIUS * s, "y": RADIUS * c, "alpha_1": TILT * c, "alpha_2": TILT * s}
    return values, {name: w * rate for name, rate in rates.items()}


def follow(count: int = 81) -> dict[str, np.ndarray]:
    """The motion, at so many times.

    Returns:
        `t` (N,) [s], `legs` (N, 6) [m] and their `rates` [m/s], the `wanted` pose and the one
        `from_legs` (N, 6) with its `speeds`, `singularity` (N,).
    """
    robot = load("staicu2015")
    t = np.linspace(0.0, PERIOD, count)
    near = None
    wanted = []
    legs = []
    rates = []
    for moment in t.tolist():
        values, speeds = pose(moment)
        near = robot.close_given(values, speeds, near=near)  # inverse kinematics, on its branch
        wanted.append(list(values.values()))
        legs.append(near.u)
        rates.append(near.du)
    state = robot.close_path(legs, rates)  # forward kinematics, from leg lengths alone
    columns = [robot.coordinates.index(name) for name in POSE]
    return {
        "t": t,
        "legs": np.array(legs),
        "rates": np.array(rates),
        "wanted": np.array(wanted),
        "from_legs": state.s[:, columns],
        "speeds": state.ds[:, columns],
        "singularity": np.asarray(state.singularity),
    }


def plot(result: dict[str, np.ndarray], path: str) -> None:
    """Legs and their rates."""
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing.page import written_page  # noqa: PLC0415
    from hybrid_dynamics_core.drawing.style import LOOPS  # noqa: PLC0415

    about = (
        "round a circle, tilting; legs A to C belong to the lower module, D to F (dashed) to the"
        " upper one"
    )
    title = "Legs of Staicu's robot along a closed path"
    t = result["t"]
    with written_page(path, title, about, height=3.6) as figure:
        panels = figure.subplots(1, 2, sharex=True)
        for axes, part in zip(panels, ("legs", "rates"), strict=True):
            for k, leg in enumerate("ABCDEF"):
                style = STYLES[leg]
                axes.plot(t, 1e3 * result[part][:, k], style, color=LOOPS[k], label=f"leg {leg}")
        panels[0].set(xlabel="t [s]", ylabel="extension [mm]", xlim=t[[0, -1]])
        panels[1].set(xlabel="t [s]", ylabel="rate [mm/s]", xlim=t[[0, -1]])
        panels[0].set_title("how far the legs are out")
        panels[1].set_title("how fast they move")
        lines, labels = panels[0].get_legend_handles_labels()
        figure.legend(lines, labels, loc="outside lower left", ncols=6, fontsize=8)


def main() -> None:
    """Print what the legs have to do, and how well the pose comes back; draw if asked."""
    parser = argparse.ArgumentParser(description="Staicu's robot on a circle.")
    parser.add_argument("--plot", metavar="FILE", help="write a figure (.svg or .png)")
    options = parser.parse_args()
    result = follow()
    for k, leg in enumerate("ABCDEF"):
        travel = 1e3 * np.ptp(result["legs"][:, k])
        fastest = 1e3 * np.abs(result["rates"][:, k]).max()
        print(f"leg {leg}: travels {travel:6.1f} mm, up to {fastest:6.1f} mm/s")
    error = np.abs(result["from_legs"] - result["wanted"]).max()
    print(f"pose from the legs: {error:.0e} m or rad beside the wanted one")
    print(f"nearest to a singularity: {result['singularity'].min():.2f} (0 singular, 1 best)")
    if options.plot:
        plot(result, options.plot)


if __name__ == "__main__":
    main()
