"""Staicu (2015), Figure 5: displacements of the lower module's actuators, legs A, B and C.

python examples/figures/staicu2015_figure_5.py [FILE]

The motion, and what was read otherwise than printed: see `staicu2015.py`.
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

import staicu2015
from paper import write


def curves(times: np.ndarray) -> np.ndarray:
    """Displacements (N, 3) [m] of legs A, B and C at times (N,) [s]."""
    return staicu2015.legs(times, "lower")[:, 0]


def draw() -> Figure:
    """One curve a leg."""
    return staicu2015.figure(5, "lower", 0)


if __name__ == "__main__":
    write(draw, __file__)
