"""The example of Staicu (2015), Section 4: Figures 5 to 10, each of the three legs of a module.

For 3 s the platforms move by x = y = 0.05 m times s(t) and alpha_1 = pi/12 times s(t), with s(t) =
1 - cos(pi t / 3). z, alpha_2 and alpha_3 stay. The legs follow by inverse kinematics: all 18 leg
variables with rates and accelerations (Eq. 8 to 17). (2) prints alpha_E = -alpha_E, read as alpha_E
= -alpha_F. (9) prints sin where cos belongs in its second line.

The six figures show displacement, velocity and acceleration of the actuators of both modules. Which
number shows which is assumed here: pairs, lower module first. 5 and 6 are displacements, 7 and 8
velocities, 9 and 10 accelerations.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from matplotlib.figure import Figure

from hybrid_dynamics_core import Robot, load

from paper import BLUE, GREEN, ORANGE, page

SIZES = {  # [m], [rad]
    "x": 0.05,
    "y": 0.05,
    "z": 0.0,
    "alpha_1": math.pi / 12.0,
    "alpha_2": 0.0,
    "alpha_3": 0.0,
}
PULSE = math.pi / 3.0  # [rad/s]
WORDS = (("displacements", "m"), ("velocities", "m/s"), ("accelerations", "m/s²"))
MODULES = {"lower": "ABC", "upper": "DEF"}
CAPTION = """x = y = 0.05 m (1 - cos(pi t / 3)), alpha_1 = pi/12 (1 - cos(pi t / 3)),
    z = alpha_2 = alpha_3 = 0, from the central configuration. alpha_E read as 2 pi/3 ((2) prints
    alpha_E = -alpha_E), cos in the second line of (9) (printed: sin)."""


@cache
def robot() -> Robot:
    """The robot, loaded once."""
    return load("staicu2015")


def law(t: float) -> tuple[dict[str, float], dict[str, float], dict[str, float]]:
    """Pose of both platforms by coordinate, rates and accelerations, at a time [s]."""
    turn = PULSE * t
    values = scaled(1.0 - math.cos(turn))
    rates = scaled(PULSE * math.sin(turn))
    accelerations = scaled(PULSE**2 * math.cos(turn))
    return values, rates, accelerations


def scaled(s: float) -> dict[str, float]:
    """The sizes of the motion, times a number."""
    return {name: size * s for name, size in SIZES.items()}


def legs(times: np.ndarray, module: str) -> np.ndarray:
    """The motion of the three actuators of a module.

    Returns:
        Displacement [m], velocity [m/s] and acceleration [m/s^2] of each (N, 3, 3).
    """
    columns = [robot().coordinates.index(f"lambda_{leg}") for leg in MODULES[module]]
    rows = []
    near = None
    for t in times:
        near = robot().close_given(*law(float(t)), near=near)
        rows.append([near.s[columns], near.ds[columns], near.dds[columns]])
    return np.array(rows)


def figure(number: int, module: str, order: int) -> Figure:
    """One figure: derivative 0, 1 or 2 of the displacements of a module's actuators."""
    t = np.linspace(0.0, 3.0, 121)
    curves = legs(t, module)[:, order]
    words, unit = WORDS[order]
    title = f"Staicu (2015), Figure {number}: {words} of the {module} module's actuators"
    drawn = page(title, CAPTION, height=3.4)
    axes = drawn.subplots()
    for leg, column, colour in zip(MODULES[module], curves.T, (BLUE, GREEN, ORANGE), strict=True):
        axes.plot(t, column, color=colour, label=f"leg {leg}")
    axes.set(xlabel="t [s]", ylabel=f"{words} of lambda_32 [{unit}]", xlim=(0.0, 3.0))
    axes.legend(
        ncols=3, frameon=False, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0
    )
    return drawn
