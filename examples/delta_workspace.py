"""A delta robot whose singular places stay away from its workspace.

python examples/delta_workspace.py [--plot FILE]

Arms, rods and the circle of the arms' axes are free within bounds. Over a cylinder of places of the
platform, the least distance to a singular place is to be largest: a min-max problem with exact
gradients.
"""

from __future__ import annotations

import argparse

import numpy as np

from hybrid_dynamics_core import load
from hybrid_dynamics_core.design import Duty, Recipe, keep_regular

GIVEN = ("x", "y", "z", "q4")
RADIUS = 0.25  # [m] of the workspace
HEIGHTS = (-0.15, 0.0, 0.1)  # [m] about the central height
VARIABLES = {  # bounds [m]
    "modules.delta.parameters.arm": (0.15, 0.40),
    "modules.delta.parameters.rod": (0.40, 0.90),
    "modules.delta.parameters.base_radius": (0.10, 0.30),
}


def workspace(around: int = 12) -> list[dict[str, float]]:
    """Places on the rim and on the axis of the workspace."""
    places: list[dict[str, float]] = []
    for z in HEIGHTS:
        places.append({"x": 0.0, "y": 0.0, "z": z})
        for angle in np.linspace(0.0, 2.0 * np.pi, around, endpoint=False):
            x, y = RADIUS * np.cos(angle), RADIUS * np.sin(angle)
            places.append({"x": float(x), "y": float(y), "z": z})
    return places


def designed() -> Recipe:
    """The design and its result."""
    places = [Duty(place) for place in workspace()]
    return keep_regular(load("delta"), VARIABLES, places, GIVEN)


def plot(found: Recipe, file: str) -> None:
    """Least distance around the rim of the workspace, before and after."""
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing.page import entitled, written_page  # noqa: PLC0415
    from hybrid_dynamics_core.drawing.style import QUIET, RED  # noqa: PLC0415

    about = "least distance of the loops to a singular place around the rim of the workspace"
    places = workspace()
    cycles = (found.design.cycle(), found.design.cycle(list(found.result.values.values())))
    title = "A delta robot whose singular places stay away"
    with written_page(file, title, about, height=3.5) as figure:
        for axes, z in zip(figure.subplots(1, len(HEIGHTS), sharey=True), HEIGHTS, strict=True):
            rows = [k for k, at in enumerate(places) if at["z"] == z and (at["x"] or at["y"])]
            angles = np.linspace(0.0, 360.0, len(rows), endpoint=False)
            for cycle, colour, words in zip(cycles, (QUIET, RED), ("before", "after"), strict=True):
                least = cycle.distance().value[rows].min(axis=1)
                axes.plot(angles, least, color=colour, label=words)
            axes.set(xlabel="angle on the rim [deg]", ylabel="least distance [-]", ylim=(0.0, 1.0))
            entitled(axes, f"z = {z:g} m", 2)


def main() -> None:
    """Print the lengths and distances; draw if asked."""
    parser = argparse.ArgumentParser(description="Singular places away from a workspace.")
    parser.add_argument("--plot", metavar="FILE", help="write a figure (.svg or .png)")
    options = parser.parse_args()
    found = designed()
    before = float(found.design.cycle().distance().value.min())
    print(f"least distance: {before:.3f} before, {-found.result.objective:.3f} after")
    for (name, value), start in zip(found.result.values.items(), found.design.start, strict=True):
        print(f"  {name}: {start:.3f} m before, {value:.3f} m after")
    print(f"active: {', '.join(found.result.active)}")
    if options.plot:
        plot(found, options.plot)


if __name__ == "__main__":
    main()
