"""Forty thousand forging robots: how far the lifting cylinder swings the arm, and its force.

python examples/forging_design_map.py [--plot FILE] [--folder FOLDER]

Two numbers of the forging robot vary: its cylinder's pivot behind the column, and its pin on the
upper arm. Each design is computed at five strokes. The best design swings as far as the robot of
the paper and takes the least force. With --folder, a stopped call goes on where it was.
"""

from __future__ import annotations

import argparse

import numpy as np

from hybrid_dynamics_core import load
from hybrid_dynamics_core.sweeps import Study, grid, read_results, sweep, sweep_into

NAME = "forging_chu2020"
PIVOT = (0.55, 0.85, 200)  # L1: column axis to the pivot of the cylinder [m]
PIN = (0.15, 0.45, 200)  # b2: elbow to the pin of the cylinder [m]
STROKES = np.linspace(0.0, 0.25, 5)  # of the lifting cylinder [m]
SWING = "coordinate.q2.range"
FORCE = "effort.q12.max"


def study() -> Study:
    """All designs."""
    robot = load(NAME)
    u = np.tile(robot.reference, (len(STROKES), 1))
    u[:, robot.active.index("q12")] = STROKES
    return Study(robot, grid({"L1": PIVOT, "b2": PIN}), [SWING, FORCE], u)


def best_of(results: dict[str, np.ndarray]) -> tuple[int, int]:
    """Rows of the design of the paper, and of the one that swings as far with the least force."""
    apart = np.hypot(results["L1"] - 0.7, results["b2"] - 0.3)
    paper = int(apart.argmin())
    enough = results[SWING] >= results[SWING][paper]
    forces = np.where(enough, results[FORCE], np.inf)
    return paper, int(forces.argmin())


def label_places(levels: list[list[np.ndarray]]) -> list[np.ndarray]:
    """A point inside the longest line of each level, where a label has room, shape (2,)."""
    longest = [max(lines, key=len) for lines in levels if lines]
    return [line[len(line) // 3] for line in longest if len(line)]


def plot(results: dict[str, np.ndarray], path: str) -> None:
    """Maps of the swing and of the force."""
    # Matplotlib is an extra.
    from matplotlib.lines import Line2D  # noqa: PLC0415
    from matplotlib.patches import Patch  # noqa: PLC0415

    from hybrid_dynamics_core.drawing.page import entitled, written_page  # noqa: PLC0415
    from hybrid_dynamics_core.drawing.style import BLUE, GRID, INK, RED  # noqa: PLC0415

    shape = (PIVOT[2], PIN[2])
    x, y, closes = (results[name].reshape(shape) for name in ("L1", "b2", "closes"))
    paper, best = best_of(results)
    swings, forces = (15, 20, 25, 30, 40, 50, 70), (1, 1.5, 2, 3, 4, 6, 10)
    maps = (
        (SWING, np.degrees(1.0), swings, "swing of the upper arm [deg]"),
        (FORCE, 1e-3, forces, "largest force of the cylinder [kN]"),
    )
    about = "forty thousand designs at five strokes of 0 to 0.25 m"
    with written_page(path, "Where the lifting cylinder pulls", about, height=3.9) as figure:
        for axes, (name, factor, levels, title) in zip(figure.subplots(1, 2), maps, strict=True):
            values = factor * results[name].reshape(shape)
            axes.contourf(x, y, closes < 1.0, levels=[0.5, 1.5], colors=[GRID])
            lines = axes.contour(x, y, values, levels=levels, colors=BLUE, linewidths=1.0)
            axes.clabel(lines, manual=label_places(lines.allsegs))
            for row, colour in ((paper, INK), (best, RED)):
                axes.plot(results["L1"][row], results["b2"][row], "o", color=colour, clip_on=False)
            axes.set(xlabel="column to pivot, L1 [m]", ylabel="elbow to pin, b2 [m]")
            entitled(axes, title)
        keys = [
            Line2D([], [], color=INK, marker="o", ls="", label="as in the paper"),
            Line2D(
                [], [], color=RED, marker="o", ls="", label="swings as far with the least force"
            ),
            Patch(color=GRID, label="does not close at all strokes"),
        ]
        figure.legend(handles=keys, ncols=3, loc="outside lower left", fontsize=8)


def main() -> None:
    """Print the best design; draw if asked."""
    parser = argparse.ArgumentParser(description="Forty thousand forging robots.")
    parser.add_argument("--plot", metavar="FILE", help="write a figure (.svg or .png)")
    parser.add_argument("--folder", metavar="FOLDER", help="keep the results here")
    options = parser.parse_args()
    if options.folder:
        done = sweep_into(study(), options.folder, threads=2)
        print(f"{done.computed} of {done.designs} designs computed now")
        results = read_results(options.folder)
    else:
        results = sweep(study(), threads=2)
    closed = (results["status"] == "closed").mean()
    print(f"{len(results['design'])} designs, {100 * closed:.0f} % close at all strokes")
    for row, text in zip(best_of(results), ("paper", "best"), strict=True):
        place = f"L1 = {results['L1'][row]:.3f} m, b2 = {results['b2'][row]:.3f} m"
        swing = np.degrees(results[SWING][row])
        numbers = f"swings by {swing:.1f} degrees with {results[FORCE][row]:.0f} N"
        print(f"{text:>6}: {place}: {numbers}")
    if options.plot:
        plot(results, options.plot)


if __name__ == "__main__":
    main()
