"""Chu et al. (2020), Figure 8: forward kinematics of the end effector along the paper's motion.

python examples/figures/chu2020_figure_8.py [FILE]

The print gives curves without numbers. f8, Eq. 33, prints sin for cos. With sin the carrier would
tilt, and the end effector with it, so cos is used. The assembly mode is that of the paper's
Figure 6.
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from hybrid_dynamics_core import load

from chu2020 import LAW, MOTION
from paper import BLUE, GREEN, ORANGE, page, write


def curves(times: np.ndarray) -> np.ndarray:
    """Position of the end effector (N, 3) in the base frame [m], at times (N,) [s]."""
    robot = load("forging_chu2020")
    return robot.forward_kinematics(robot.close_path(MOTION(times).u)).position


def draw() -> Figure:
    """x, y and z over time, and the path."""
    t = np.linspace(0.0, 10.0, 201)
    position = curves(t)
    caption = (
        f"Motion: {LAW}. f8 of Eq. 33 read with cos (printed: sin), elbow up as in the paper's"
        " Figure 6."
    )
    figure = page("Chu et al. (2020), Figure 8: path of the end effector", caption)
    curve, path = figure.subplots(1, 2, width_ratios=(1.15, 1.0))
    for name, column, colour in zip("xyz", position.T, (BLUE, GREEN, ORANGE), strict=True):
        curve.plot(t, column, color=colour, label=name)
    curve.set(xlabel="t [s]", ylabel="position [m]", xlim=(0.0, 10.0))
    curve.legend(ncols=3, frameon=False)
    distance = np.hypot(position[:, 0], position[:, 1])
    path.plot(distance, position[:, 2], color=BLUE)
    path.plot(distance[0], position[0, 2], "o", color=BLUE, markersize=5)
    path.set(xlabel="distance from the column [m]", ylabel="height [m]", aspect="equal")
    path.set_title("in the turning plane of the arm, dot: t = 0", fontsize=9)
    return figure


if __name__ == "__main__":
    write(draw, __file__)
