"""Staicu (2015), Figure 7: velocities of the lower module's actuators, legs A, B and C.

python examples/figures/staicu2015_figure_7.py [FILE]

The motion, and what was read otherwise than printed: see `staicu2015.py`.
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

import staicu2015
from paper import write


def curves(times: np.ndarray) -> np.ndarray:
    """Velocities (N, 3) [m/s] of legs A, B and C at times (N,) [s]."""
    return staicu2015.legs(times, "lower")[:, 1]


def draw() -> Figure:
    """One curve a leg."""
    return staicu2015.figure(7, "lower", 1)


if __name__ == "__main__":
    write(draw, __file__)
