"""Colours and type of the figures."""

from __future__ import annotations

from typing import Any, Final

INK: Final = "#1f2933"
QUIET: Final = "#52606d"
GRID: Final = "#d9dee3"
SHADOW: Final = "#b8c2cc"
STEEL: Final = "#dbe2e8"
# Palettes of Okabe and Ito, and of Tol, for all kinds of colour vision.
BLUE: Final = "#0072b2"
RED: Final = "#d55e00"
GREEN: Final = "#009e73"
ORANGE: Final = "#e69f00"
PURPLE: Final = "#aa4499"
SKY: Final = "#56b4e9"
WINE: Final = "#882255"
OLIVE: Final = "#999933"

# RED marks driven joints, PURPLE the end effector.
LOOPS: Final = (BLUE, GREEN, ORANGE, WINE, SKY, OLIVE)

STYLE: Final[dict[Any, Any]] = {
    "font.family": "sans-serif",  # DejaVu Sans, which comes with Matplotlib
    "font.size": 9.0,
    "text.color": INK,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.titlesize": 10.5,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.linewidth": 0.8,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "hatch.linewidth": 0.7,
    "xtick.color": INK,
    "ytick.color": INK,
    "lines.linewidth": 1.8,
    "lines.solid_capstyle": "round",
    "mathtext.fontset": "dejavusans",
    "svg.hashsalt": "hybrid_dynamics",  # the same drawing gives the same file
}

# Of three-dimensional axes, from Matplotlib 3.7.
PANES: Final[dict[Any, Any]] = {
    "axes3d.xaxis.panecolor": "#f7f8fa",
    "axes3d.yaxis.panecolor": "#f7f8fa",
    "axes3d.zaxis.panecolor": "#eef1f4",
}


def mix(colour: str, other: str, share: float) -> str:
    """A colour (#rrggbb) mixed with a share in [0, 1] of another."""
    mixed = "#"
    for k in (1, 3, 5):
        start, end = int(colour[k : k + 2], 16), int(other[k : k + 2], 16)
        mixed += f"{round(start + share * (end - start)):02x}"
    return mixed


def pale(colour: str) -> str:
    """The fill colour of a body of a given colour."""
    return mix(colour, "#ffffff", 0.68)


def deep(colour: str) -> str:
    """The edge colour of a body of a given colour."""
    return mix(colour, INK, 0.35)
