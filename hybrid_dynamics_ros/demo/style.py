"""Colours and type of the figure."""

from __future__ import annotations

from typing import Any, Final

INK: Final = "#1f2933"
QUIET: Final = "#52606d"
GRID: Final = "#d9dee3"
SHADOW: Final = "#b8c2cc"
# After Okabe and Ito: told apart by all kinds of sight.
BLUE: Final = "#0072b2"
RED: Final = "#d55e00"
GREEN: Final = "#009e73"
ORANGE: Final = "#e69f00"
PURPLE: Final = "#aa4499"

STYLE: Final[dict[Any, Any]] = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "text.color": INK,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.titlesize": 10.5,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.linewidth": 0.8,
    "axes3d.xaxis.panecolor": "#f7f8fa",
    "axes3d.yaxis.panecolor": "#f7f8fa",
    "axes3d.zaxis.panecolor": "#eef1f4",
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "xtick.color": INK,
    "ytick.color": INK,
    "lines.linewidth": 1.8,
    "lines.solid_capstyle": "round",
    "mathtext.fontset": "dejavusans",
    "svg.hashsalt": "hybrid_dynamics",  # the same results give the same file
}
