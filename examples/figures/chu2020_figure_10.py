"""Chu et al. (2020), Figure 10: the efforts of the four drives along the paper's motion.

python examples/figures/chu2020_figure_10.py [FILE]

The print gives curves without numbers, and is silent or contradicts itself in places.
docs/figure_10.md names every assumption and its size. The largest are rods of 0.4 m (1 % of F12)
and links as slender rods (8 % of tau_1).
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from hybrid_dynamics_core import load
from hybrid_dynamics_core.control import efforts_along

from chu2020 import LAW, MOTION
from paper import BLUE, page, write

EFFORTS = ("tau_1 [N m]", "F12 [N]", "F22 [N]", "tau_4 [N m]")


def curves(times: np.ndarray) -> np.ndarray:
    """tau_1 [N m], F12 [N], F22 [N] and tau_4 [N m], (N, 4), at times (N,) [s]."""
    return efforts_along(load("forging_chu2020"), MOTION, times)


def draw() -> Figure:
    """The four efforts."""
    t = np.linspace(0.0, 10.0, 201)
    tau = curves(t)
    caption = f"""Motion: {LAW}. Not in the paper, assumed: rods of both cylinders 0.4 m long,
        links slender uniform rods. J_z with the sign that makes R = [E; -J_z^-1 J_u], r_C2 with C2
        in y (printed: S2), centre of mass of l41 at (L3 - b3)/2 (printed: L3/2)."""
    figure = page("Chu et al. (2020), Figure 10: efforts of the drives", caption)
    for k, axes in enumerate(figure.subplots(2, 2, sharex=True).flat):
        axes.plot(t, np.round(tau[:, k], 12), color=BLUE)  # tau_4 is zero but for rounding
        axes.set(ylabel=EFFORTS[k], xlim=(0.0, 10.0))
        if k > 1:
            axes.set_xlabel("t [s]")
    figure.align_ylabels()
    return figure


if __name__ == "__main__":
    write(draw, __file__)
