"""Staicu (2015), Figure 10: accelerations of the upper module's actuators, legs D, E and F.

python examples/figures/staicu2015_figure_10.py [FILE]

The motion, and what was read otherwise than printed: see `staicu2015.py`.
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

import staicu2015
from paper import write


def curves(times: np.ndarray) -> np.ndarray:
    """Accelerations (N, 3) [m/s^2] of legs D, E and F at times (N,) [s]."""
    return staicu2015.legs(times, "upper")[:, 2]


def draw() -> Figure:
    """One curve a leg."""
    return staicu2015.figure(10, "upper", 2)


if __name__ == "__main__":
    write(draw, __file__)
