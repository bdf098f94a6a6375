"""What the figures share: the look of a page, and where it is written."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure

from hybrid_dynamics_core.drawing.figure import save
from hybrid_dynamics_core.drawing.page import PLOTS, page
from hybrid_dynamics_core.drawing.style import BLUE, GREEN, ORANGE, QUIET

__all__ = ["BLUE", "GREEN", "ORANGE", "QUIET", "page", "write"]


def write(draw: Callable[[], Figure], script: str) -> None:
    """Draw, and write to the file named on the command line; SCRIPT.svg where none is."""
    path = Path(Path(script).with_suffix(".svg").name)
    if len(sys.argv) > 1:
        path = Path(sys.argv[1])
    with mpl.rc_context(PLOTS):
        save(draw(), path)
    print(path)
