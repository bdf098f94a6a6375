"""Staicu (2015), Figure 8: velocities of the upper module's actuators, legs D, E and F.

python examples/figures/staicu2015_figure_8.py [FILE]

The motion, and what was read otherwise than printed: see `staicu2015.py`.
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

import staicu2015
from paper import write


def curves(times: np.ndarray) -> np.ndarray:
    """Velocities (N, 3) [m/s] of legs D, E and F at times (N,) [s]."""
    return staicu2015.legs(times, "upper")[:, 1]


def draw() -> Figure:
    """One curve a leg."""
    return staicu2015.figure(8, "upper", 1)


if __name__ == "__main__":
    write(draw, __file__)
