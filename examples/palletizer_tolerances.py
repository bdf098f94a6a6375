"""Tolerances of a palletizer: where the hand may be, and which dimension to tighten first.

python examples/palletizer_tolerances.py [--plot FILE]

Both arms and the three rods are made to 0.1 mm, the pins have 0.02 mm of radial play. The rods of
the parallelograms are longer or shorter each by itself, so the hand tilts too. The tolerances are
assumed.
"""

from __future__ import annotations

import argparse

import numpy as np

from hybrid_dynamics_core import Pose, load
from hybrid_dynamics_core.tolerances import LinearErrors, ToleranceAnalysis

DOWN = np.diag([1.0, -1.0, -1.0])  # the flange points down
HEIGHT = 0.9  # of the line along which boxes are carried [m]
ENLARGED = 200.0  # of the ellipses
CHI_95 = 2.4477  # radius of 95 % in two dimensions [standard deviations]
TABLE = {
    "L2": "0.1*mm",  # the upper arm: its rods have entries of their own
    "L3": "0.1*mm",  # the forearm
    "loops.drive.pin.drive_rod[0]": "0.1*mm",
    "loops.level_1.pin.bar_1[0]": "0.1*mm",
    "loops.level_2.pin.bar_2[0]": "0.1*mm",
    "joints.q2.play": "0.02*mm",
    "joints.p2.play": "0.02*mm",
    "joints.p6.play": "0.02*mm",
    "loops.drive.play": "0.02*mm",
    "loops.level_1.play": "0.02*mm",
    "loops.level_2.play": "0.02*mm",
}


def analysis() -> ToleranceAnalysis:
    """The palletizer with its tolerances."""
    return ToleranceAnalysis("palletizer", TABLE)


def line(count: int = 25) -> tuple[np.ndarray, np.ndarray]:
    """Reaches (N,) [m] and active coordinates (N, 4) along a horizontal line."""
    robot = load("palletizer")
    reaches = np.linspace(1.25, 2.3, count)
    rows = []
    seed = robot.reference
    for reach in reaches:
        result = robot.inverse_kinematics(Pose([reach, 0.0, HEIGHT], DOWN), seed=seed)
        if result.u is None:
            raise SystemExit(f"{reach} m: {result.message}")
        seed = result.u
        rows.append(seed)
    return reaches, np.array(rows)


def grid() -> np.ndarray:
    """Active coordinates (N, 4) over the vertical plane of the arm."""
    robot = load("palletizer")
    upper, crank = np.meshgrid(np.linspace(0.8, 1.8, 6), np.linspace(-0.9, 0.3, 5))
    zero = np.zeros(upper.size)
    u = np.stack([zero, upper.ravel(), crank.ravel(), zero], axis=1)
    state = robot.close(u, check=False)
    return u[state.status == 0]


def ellipses(linear: LinearErrors) -> np.ndarray:
    """Outlines (N, 60, 2) [m] of 95 % of the positions in the vertical plane, about zero."""
    across = linear.covariance[:, [0, 2]][:, :, [0, 2]]
    values, vectors = np.linalg.eigh(across)
    angle = np.linspace(0.0, 2.0 * np.pi, 60)
    circle = CHI_95 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    roots = vectors * np.sqrt(values.clip(0.0))[:, None]
    return circle @ np.swapaxes(roots, 1, 2)


def plot(path: str) -> None:
    """Ellipses of the hand's place, and the error along a line."""
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing.page import entitled, written_page  # noqa: PLC0415
    from hybrid_dynamics_core.drawing.style import BLUE, QUIET, RED  # noqa: PLC0415

    study = analysis()
    robot = study.robot
    reaches, u = line()
    along, spread = study.linear(u), study.linear(grid())
    sampled = study.monte_carlo(u[::4], count=2000)
    tight = max(along.shares, key=lambda name: along.shares[name])
    halved = {name: _halved(text) if name == tight else text for name, text in TABLE.items()}
    about = "lengths within 0.1 mm, pins with 0.02 mm of radial play"
    with written_page(path, "Tolerances of a palletizer", about, height=3.8) as figure:
        places, sizes = figure.subplots(1, 2)
        centres = robot.forward_kinematics(robot.close(spread.u)).position[:, [0, 2]]
        for k, outline in enumerate(ellipses(spread)):
            x, z = (centres[k] + ENLARGED * outline).T
            label = f"95 % of all robots, {ENLARGED:.0f} times as large" if not k else None
            places.plot(x, z, color=BLUE, lw=1.2, label=label)
        places.set_aspect("equal")
        places.set(xlabel="reach [m]", ylabel="height [m]")
        sizes.plot(reaches, 1e3 * along.worst, color=QUIET, label="worst")
        sizes.plot(reaches, 1e3 * along.likely, color=BLUE, label="likely, 95 %")
        likely = 1e3 * sampled.likely
        sizes.plot(reaches[::4], likely, "o", color=BLUE, ms=4, label="of 2000 random robots")
        after = ToleranceAnalysis("palletizer", halved).linear(u)
        sizes.plot(reaches, 1e3 * after.likely, "--", color=RED, label=f"{tight} halved")
        sizes.set(xlabel="reach [m]", ylabel="error of the position [mm]", ylim=(0.0, None))
        entitled(places, "where the hand may be", 1)
        entitled(sizes, f"along a line {HEIGHT} m above the floor", 2)


def _halved(text: str) -> str:
    return f"0.5*{text}"


def main() -> None:
    """Print the errors and their shares; draw if asked."""
    parser = argparse.ArgumentParser(description="Tolerances of a palletizer.")
    parser.add_argument("--plot", metavar="FILE", help="write a figure (.svg or .png)")
    options = parser.parse_args()
    _, u = line()
    linear = analysis().linear(u)
    print(f"likely error (95 %): up to {1e3 * linear.likely.max():.2f} mm", end=", ")
    print(f"worst: {1e3 * linear.worst.max():.2f} mm")
    shares, halved = linear.shares, linear.halved
    for name in sorted(shares, key=lambda name: -shares[name]):
        print(f"{name:>30}: {100 * shares[name]:5.1f} %, halved {1e3 * halved[name]:.2f} mm")
    if options.plot:
        plot(options.plot)


if __name__ == "__main__":
    main()
