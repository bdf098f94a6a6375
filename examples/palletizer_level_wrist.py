"""A palletizer carries a box along a straight line: its parallelograms keep the wrist level, no motor does.

python examples/palletizer_level_wrist.py [--plot FILE]

The box is picked at one place, lifted, carried and put down at another, without turning. Inverse
kinematics gives the four motors for every pose; how far the hand tilts is then read from the closed
mechanism.
"""

from __future__ import annotations

import argparse
from itertools import pairwise

import numpy as np

from hybrid_dynamics_core import IKStatus, Pose, load

CORNERS = np.array(
    [[1.6, -0.8, 0.9], [1.6, -0.8, 1.5], [1.4, 0.9, 1.5], [1.4, 0.9, 0.9]]
)  # of the path [m]
DOWN = np.array(
    [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]
)  # gripper downward, box along x


def line(per_side: int = 20) -> np.ndarray:
    """Points (N, 3) on the straight sides between the corners [m]."""
    share = np.linspace(0.0, 1.0, per_side, endpoint=False)[:, None]
    sides = [a + share * (b - a) for a, b in pairwise(CORNERS)]
    return np.vstack([*sides, CORNERS[-1:]])


def carry() -> dict[str, np.ndarray]:
    """Motors (N, 4) [rad]; tilt (N,) of the hand and turn (N,) of the box [rad]; error (N,) of the path [m]."""
    robot = load("palletizer")
    points, motors, seed = line(), [], robot.reference
    for point in points:
        found = robot.inverse_kinematics(Pose(point, DOWN), seed=seed)
        if found.status is not IKStatus.SOLVED:
            raise SystemExit(f"{point} m: {found.message}")
        motors.append(seed := found.u)
    state = robot.close(np.array(motors))
    hand, tip = robot.forward_kinematics(state, "hand").rotation, robot.forward_kinematics(state)
    return {
        "points": points,
        "motors": state.u,
        "tilt": np.arctan2(
            np.hypot(hand[:, 2, 0], hand[:, 2, 2]), hand[:, 2, 1]
        ),  # the hand's y axis points up
        "turn": np.arctan2(tip.rotation[:, 1, 0], tip.rotation[:, 0, 0]),
        "error": np.linalg.norm(tip.position - points, axis=1),
        "forearm": state.s[
            :, robot.coordinates.index("p6")
        ],  # hand against forearm: that does turn
    }


def plot(result: dict[str, np.ndarray], path: str) -> None:
    """Motors, and what the hand does."""
    from hybrid_dynamics_core.drawing.page import (  # noqa: PLC0415  needs Matplotlib
        entitled,
        written_page,
    )
    from hybrid_dynamics_core.drawing.style import QUIET, RED  # noqa: PLC0415

    along = np.concatenate(
        [[0.0], np.cumsum(np.linalg.norm(np.diff(result["points"], axis=0), axis=1))]
    )
    about = (
        "a box is lifted, carried along straight lines and put down; two parallelograms keep the"
        " hand level"
    )
    with written_page(path, "A palletizer keeps its wrist level", about, height=3.5) as figure:
        motors, wrist = figure.subplots(1, 2)
        for k, style in enumerate(("-", "-", "-", "--")):
            motors.plot(along, np.degrees(result["motors"][:, k]), style, label=f"q{k + 1}")
        wrist.plot(along, np.degrees(result["forearm"]), color=QUIET, label="to the forearm")
        wrist.plot(along, np.degrees(result["tilt"]), color=RED, label="to the horizontal")
        motors.set(xlabel="way along the path [m]", ylabel="angle of a motor [deg]")
        wrist.set(xlabel="way along the path [m]", ylabel="angle of the hand [deg]")
        entitled(motors, "what the motors do", 4)
        entitled(wrist, "how the hand stands", 2)


def main() -> None:
    """Print how level the hand stays; draw if asked."""
    parser = argparse.ArgumentParser(description="A palletizer keeps its wrist level.")
    parser.add_argument("--plot", metavar="FILE", help="write a figure (.svg or .png)")
    options = parser.parse_args()
    result = carry()
    turned = np.degrees(np.ptp(result["forearm"]))
    print(f"{len(result['points'])} poses, off the path by at most {result['error'].max():.1e} m")
    print(
        f"the hand turns by {turned:.0f} degrees against the forearm and tilts by"
        f" {result['tilt'].max():.1e} rad"
    )
    column = np.degrees(np.ptp(result["motors"][:, 0]))
    print(
        f"the column turns by {column:.0f} degrees, the box by"
        f" {np.abs(result['turn']).max():.1e} rad"
    )
    if options.plot:
        plot(result, options.plot)


if __name__ == "__main__":
    main()
