"""Chu et al. (2020), Figure 9: inverse kinematics, the joints that give the path of Figure 8 back.

python examples/figures/chu2020_figure_9.py [FILE]

Each pose of the forward kinematics is given to the inverse kinematics, which starts from the
solution before. Its answers are drawn over the motion that made the poses. Position and orientation
are given: the roll q4 of the gripper does not move its tip. f8 of Eq. 33 is read with cos (printed:
sin).
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from hybrid_dynamics_core import Pose, load

from chu2020 import LAW, MOTION
from paper import BLUE, ORANGE, page, write

JOINTS = ("q1 [rad]", "q12 [m]", "q22 [m]", "q4 [rad]")


def curves(times: np.ndarray) -> np.ndarray:
    """Active coordinates (N, 4) found from the poses that the motion has at times (N,) [s]."""
    robot = load("forging_chu2020")
    poses = robot.forward_kinematics(robot.close_path(MOTION(times).u))
    solutions = []
    seed = robot.reference
    for position, rotation in zip(poses.position, poses.rotation, strict=True):
        seed = robot.inverse_kinematics(Pose(position, rotation), seed=seed).u
        solutions.append(seed)
    return np.array(solutions)


def draw() -> Figure:
    """Each joint: solved, and given."""
    t = np.linspace(0.0, 10.0, 41)
    solved = curves(t)
    given = MOTION(t).u
    worst = np.abs(solved - given).max()
    caption = f"""Dots: found from the poses of Figure 8; lines: the motion that made them, {LAW}.
        Largest difference {worst:.0e} rad or m. f8 of Eq. 33 read with cos (printed: sin)."""
    figure = page("Chu et al. (2020), Figure 9: joints from the path of the end effector", caption)
    for k, axes in enumerate(figure.subplots(2, 2, sharex=True).flat):
        axes.plot(t, given[:, k], color=BLUE, linewidth=1.4)
        axes.plot(t, solved[:, k], "o", color=ORANGE, markersize=3.2, markeredgecolor="none")
        axes.set(ylabel=JOINTS[k], xlim=(-0.2, 10.2))
        if k > 1:
            axes.set_xlabel("t [s]")
    figure.align_ylabels()
    return figure


if __name__ == "__main__":
    write(draw, __file__)
