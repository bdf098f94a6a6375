"""What the figures share: a page with title and caption, and where it is written."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from textwrap import fill

import matplotlib as mpl
from matplotlib.figure import Figure

from hybrid_dynamics_core.drawing.figure import save
from hybrid_dynamics_core.drawing.style import BLUE, GREEN, LOOPS, ORANGE, QUIET, STYLE

__all__ = ["BLUE", "GREEN", "LOOPS", "ORANGE", "QUIET", "page", "write"]
LINE = 0.16  # [in] of the caption


def page(title: str, caption: str, width: float = 7.2, height: float = 4.0) -> Figure:
    """A figure with a title, and below its axes a caption that says what was assumed."""
    text = fill(" ".join(caption.split()), round(width * 15.5))
    foot = LINE * (1 + text.count("\n")) + 0.14
    figure = Figure(figsize=(width, height + foot + 0.4), layout="constrained")
    whole = height + foot + 0.4
    figure.get_layout_engine().set(rect=(0.008, foot / whole, 0.98, (height - 0.04) / whole))
    figure.text(0.015, 1.0 - 0.22 / whole, title, fontsize=12, weight="bold", va="center")
    figure.text(0.015, foot / whole - 0.03 / whole, text, fontsize=8, color=QUIET, va="top", linespacing=1.35)
    return figure


def write(draw: Callable[[], Figure], script: str) -> None:
    """Draw, and write to the file named on the command line; SCRIPT.svg where none is."""
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(script).with_suffix(".svg").name
    with mpl.rc_context(STYLE):
        save(draw(), Path(path))
    print(path)
