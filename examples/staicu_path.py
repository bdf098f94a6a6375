"""Staicu's robot of two modules follows a circle with a tilted platform: poses to legs, and legs back to poses.

python examples/staicu_path.py [--plot FILE]

The lower module carries the platform round a circle, the upper one tilts it towards the middle. All
18 leg variables follow from the pose with their rates; then the six legs alone are given, and the
pose comes back.
"""

from __future__ import annotations

import argparse
import math

import numpy as np

from hybrid_dynamics_core import load

RADIUS, TILT, PERIOD = 0.08, 0.15, 4.0  # of the circle [m], of the platform [rad], for one turn [s]
POSE = ("x", "y", "z", "alpha_1", "alpha_2", "alpha_3")


def pose(t: float) -> tuple[dict[str, float], dict[str, float]]:
    """Pose by coordinate [m, rad] and its rates at a time [s]."""
    w = 2.0 * math.pi / PERIOD
    c, s = math.cos(w * t), math.sin(w * t)
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
    """Time (N,) [s], legs (N, 6) [m] and their rates [m/s], pose wanted and found (N, 6), singularity (N,)."""
    robot = load("staicu2015")
    t, near, rows = np.linspace(0.0, PERIOD, count), None, []
    for moment in t:
        near = robot.close_given(
            *pose(float(moment)), near=near
        )  # inverse kinematics, on its branch
        rows.append((near.u, near.du))
    legs, rates = (np.array(part) for part in zip(*rows, strict=True))
    back = robot.close_path(legs, rates)  # forward kinematics, from leg lengths alone
    columns = [robot.coordinates.index(name) for name in POSE]
    wanted = np.array([list(pose(float(moment))[0].values()) for moment in t])
    return {
        "t": t,
        "legs": legs,
        "rates": rates,
        "wanted": wanted,
        "found": back.s[:, columns],
        "speeds": back.ds[:, columns],
        "singularity": np.asarray(back.singularity),
    }


def plot(result: dict[str, np.ndarray], path: str) -> None:
    """Legs and their rates."""
    from hybrid_dynamics_core.drawing.page import written_page  # noqa: PLC0415  needs Matplotlib
    from hybrid_dynamics_core.drawing.style import LOOPS  # noqa: PLC0415

    about = (
        "round a circle, tilting; legs A to C belong to the lower module, D to F (dashed) to the"
        " upper one"
    )
    with written_page(
        path, "Legs of Staicu's robot along a closed path", about, height=3.6
    ) as figure:
        panels = figure.subplots(1, 2, sharex=True)
        for axes, part, label in zip(
            panels, ("legs", "rates"), ("extension [mm]", "rate [mm/s]"), strict=True
        ):
            for leg, column, colour in zip("ABCDEF", 1e3 * result[part].T, LOOPS, strict=True):
                axes.plot(
                    result["t"],
                    column,
                    "--" if leg in "DEF" else "-",
                    color=colour,
                    label=f"leg {leg}",
                )
            axes.set(xlabel="t [s]", ylabel=label, xlim=result["t"][[0, -1]])
        panels[0].set_title("how far the legs are out")
        panels[1].set_title("how fast they move")
        figure.legend(
            *panels[0].get_legend_handles_labels(), loc="outside lower left", ncols=6, fontsize=8
        )


def main() -> None:
    """Print what the legs have to do, and how well the pose comes back; draw if asked."""
    parser = argparse.ArgumentParser(description="Staicu's robot on a circle.")
    parser.add_argument("--plot", metavar="FILE", help="write a figure (.svg or .png)")
    options = parser.parse_args()
    result = follow()
    for k, leg in enumerate("ABCDEF"):
        span, fastest = (
            1e3 * np.ptp(result["legs"][:, k]),
            1e3 * np.abs(result["rates"][:, k]).max(),
        )
        print(f"leg {leg}: travels {span:6.1f} mm, up to {fastest:6.1f} mm/s")
    print(
        f"pose from the legs: {np.abs(result['found'] - result['wanted']).max():.0e} m or rad"
        " beside the wanted one"
    )
    print(f"nearest to a singularity: {result['singularity'].min():.2f} (0 singular, 1 best)")
    if options.plot:
        plot(result, options.plot)


if __name__ == "__main__":
    main()
