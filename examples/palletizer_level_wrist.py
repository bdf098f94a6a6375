"""A palletizer carries a box along a straight line: parallelograms keep its wrist level.

python examples/palletizer_level_wrist.py [--plot FILE]

The box is picked at one place, lifted, carried and put down at another, without turning. Inverse
kinematics gives the four motors for every pose. How far the hand tilts is then read from the closed
mechanism. No motor holds it.
"""

from __future__ import annotations

import argparse
from itertools import pairwise

import numpy as np

from hybrid_dynamics_core import IKStatus, Pose, load

CORNERS = np.array(  # of the path [m]
    [
        [1.6, -0.8, 0.9],
        [1.6, -0.8, 1.5],
        [1.4, 0.9, 1.5],
        [1.4, 0.9, 0.9],
    ]
)
DOWN = np.diag([1.0, -1.0, -1.0])  # rotation: gripper downward, box along x


def line(per_side: int = 20) -> np.ndarray:
    """Points (N, 3) on the straight sides between the corners [m]."""
    share = np.linspace(0.0, 1.0, per_side, endpoint=False)[:, None]
    sides = [a + share * (b - a) for a, b in pairwise(CORNERS)]
    return np.vstack([*sides, CORNERS[-1:]])


def carry() -> dict[str, np.ndarray]:
    """The motion along the path.

    Returns:
        `points` (N, 3) [m], `motors` (N, 4) [rad], `tilt` (N,) of the hand and `turn` (N,) of the
        box [rad], `error` (N,) of the path [m], `forearm` (N,) angle of the hand against it [rad].
    """
    robot = load("palletizer")
    points = line()
    motors = []
    seed = robot.reference
    for point in points:
        result = robot.inverse_kinematics(Pose(point, DOWN), seed=seed)
        if result.status is not IKStatus.SOLVED:
            raise SystemExit(f"{point} m: {result.message}")
        seed = result.u
        motors.append(seed)
    state = robot.close(np.array(motors))
    hand = robot.forward_kinematics(state, "hand").rotation
    tip = robot.forward_kinematics(state)
    out_of_level = np.hypot(hand[:, 2, 0], hand[:, 2, 2])
    return {
        "points": points,
        "motors": state.u,
        "tilt": np.arctan2(out_of_level, hand[:, 2, 1]),  # the hand's y axis points up
        "turn": np.arctan2(tip.rotation[:, 1, 0], tip.rotation[:, 0, 0]),
        "error": np.linalg.norm(tip.position - points, axis=1),
        "forearm": state.s[:, robot.coordinates.index("p6")],
    }


def plot(result: dict[str, np.ndarray], path: str) -> None:
    """Motors, and what the hand does."""
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing.page import entitled, written_page  # noqa: PLC0415
    from hybrid_dynamics_core.drawing.style import QUIET, RED  # noqa: PLC0415

    steps = np.linalg.norm(np.diff(result["points"], axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)])
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
    tilt = result["tilt"].max()
    print(f"the hand turns by {turned:.0f} degrees against the forearm and tilts by {tilt:.1e} rad")
    column = np.degrees(np.ptp(result["motors"][:, 0]))
    box = np.abs(result["turn"]).max()
    print(f"the column turns by {column:.0f} degrees, the box by {box:.1e} rad")
    if options.plot:
        plot(result, options.plot)


if __name__ == "__main__":
    main()
