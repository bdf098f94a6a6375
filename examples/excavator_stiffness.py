"""How far an excavator's bucket sinks under its load, what gives way, and how fast it swings.

python examples/excavator_stiffness.py [--plot FILE]

Oil in three cylinders, the gear of the slew drive, and the steel of boom and stick are elastic.
The stick reaches out with a tonne in the bucket. Steel data and the bulk modulus are typical ones.
"""

from __future__ import annotations

import argparse

import numpy as np

from hybrid_dynamics_core import Payload, Robot, load
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.stiffness import (
    Beam,
    DriveStiffness,
    Elasticity,
    OilColumn,
    box_section,
)

E, G = 210e9, 81e9  # [Pa] steel
OIL = DriveStiffness(oil=OilColumn(1.2e9, dead_volume=(2e-3, 2e-3)))
ELASTICITY = Elasticity(
    drives={
        "slew": 8e7,
        "boom_cylinder": OIL,
        "stick_cylinder": OIL,
        "bucket_cylinder": OIL,
    },
    links={
        "boom": Beam(E, G, box_section(0.35, 0.5, 0.010), "stick_pitch"),
        "stick": Beam(E, G, box_section(0.30, 0.4, 0.008), "bucket_pitch"),
    },
)
LOAD = 1000.0  # [kg]
STROKES = np.linspace(1.3, 0.35, 12)  # [m] of the stick cylinder
NAMES = {
    "drives.boom_cylinder": "oil of the boom cylinder",
    "drives.stick_cylinder": "oil of the stick cylinder",
    "drives.bucket_cylinder": "oil of the bucket cylinder",
    "links.boom": "boom",
    "links.stick": "stick",
}


def reached(robot: Robot) -> tuple[Array, dict[str, Array], Array]:
    """Reach [m], drop of the bucket by element [mm], and the two lowest frequencies [Hz]."""
    loads = robot.loads.with_payload(Payload(LOAD))
    reach: list[float] = []
    drops: dict[str, list[float]] = {name: [] for name in NAMES}
    lowest: list[Array] = []
    for stroke in STROKES:
        state = robot.close([0.0, 0.7, stroke, 0.6])
        stiffness = robot.stiffness(state, ELASTICITY)
        reach.append(float(stiffness.position[0]))
        sag = stiffness.deflection(loads)
        for name in NAMES:
            drops[name].append(-1e3 * float(sag.by_element[name][2]))
        lowest.append(stiffness.modes(loads).frequencies[:2])
    by_element = {name: np.array(values) for name, values in drops.items()}
    return np.array(reach), by_element, np.array(lowest)


def plot(reach: Array, drops: dict[str, Array], lowest: Array, path: str) -> None:
    """Drops and frequencies over the reach."""
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing.page import entitled, written_page  # noqa: PLC0415
    from hybrid_dynamics_core.drawing.style import BLUE, PURPLE, QUIET, RED, STEEL  # noqa: PLC0415

    about = f"{LOAD:g} kg in the bucket, drives locked: oil, slew gear, boom and stick are elastic"
    with written_page(path, "An excavator that gives way", about, height=3.6) as figure:
        left, right = figure.subplots(1, 2)
        colours = (BLUE, QUIET, PURPLE, RED, STEEL)
        left.stackplot(reach, *drops.values(), labels=list(NAMES.values()), colors=colours)
        left.set(xlabel="reach of the teeth [m]", ylabel="drop [mm]")
        right.plot(reach, lowest[:, 0], color=RED, label="lowest")
        right.plot(reach, lowest[:, 1], color=BLUE, label="second")
        right.set(xlabel="reach of the teeth [m]", ylabel="natural frequency [Hz]")
        right.set_ylim(bottom=0.0)
        entitled(left, "what gives way", 2)
        entitled(right, "how fast it swings", 2)


def main() -> None:
    """Print drops and frequencies; draw if asked."""
    parser = argparse.ArgumentParser(description="An excavator that gives way.")
    parser.add_argument("--plot", metavar="FILE", help="write a figure (.svg or .png)")
    options = parser.parse_args()
    reach, drops, lowest = reached(load("excavator"))
    total = sum(drops.values())
    for k in (0, len(reach) - 1):
        print(f"at {reach[k]:.2f} m the bucket drops by {total[k]:.0f} mm", end=": ")
        parts = [f"{NAMES[name]} {drop[k]:.0f}" for name, drop in drops.items()]
        print(", ".join(parts))
        print(f"  and swings at {lowest[k, 0]:.2f} and {lowest[k, 1]:.2f} Hz")
    if options.plot:
        plot(reach, drops, lowest, options.plot)


if __name__ == "__main__":
    main()
