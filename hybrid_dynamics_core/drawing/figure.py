"""A robot with title, picture and key."""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import Final

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from ..closed_state.state import ClosedState
from ..errors import InputError
from ..robot.robot import Robot
from ..scene.style import STYLE
from .options import Names
from .paint.layout import axes_at, framed
from .paint.legend import subtitle
from .paint.picture import limits_of, make_scene, paint_scene

_WIDTH: Final = 7.2  # [in]
_HEIGHTS: Final = (1.8, 6.0)  # [in] least and greatest, of the axes
_PLANAR: Final = (
    0.76,
    0.16,
    0.46,
)  # [in] left, right and below the axes of a planar view: ticks and names
_SPATIAL: Final = (0.1, 0.1, 0.05)
_IMAGES: Final = 200  # [dots per inch] of what is an image within a drawing of lines
_LABEL: Final = 0.2  # [in] where the name of the upright axis ends
_PATHS: Final = re.compile(r' d="[^"]*"')
_DECIMALS: Final = re.compile(r"(\.\d\d)\d+")
_MAKER: Final = (  # stands in the files: by it they are known again
    f"hybrid_dynamics, Matplotlib {mpl.__version__}"
)


def robot_figure(
    robot: Robot, state: ClosedState | None, names: Names, title: str | None
) -> Figure:
    """A robot in a state, or in its reference configuration."""
    with mpl.rc_context(STYLE):
        scene = make_scene(robot, state)
        limits = limits_of(scene)
        left, right, below = _PLANAR if scene.projection.planar else _SPATIAL
        across, up = np.ptp(limits, axis=0)
        width = _WIDTH - left - right
        height = float(np.clip(width * up / across, *_HEIGHTS))
        size = (_WIDTH, height + below)
        figure, key = framed(size, [scene], robot.description, title or robot.name, subtitle(scene))
        axes = axes_at(figure, (left, key + below, width, height))
        paint_scene(axes, scene, names, limits)
        axes.yaxis.set_label_coords((_LABEL - left) / width, 0.5)
    return figure


def save(figure: Figure, path: Path) -> None:
    """Write a figure as what the suffix says.

    Raises InputError for others than .svg, .png and .pdf.
    """
    suffix = path.suffix.lower()
    if suffix not in (".svg", ".png", ".pdf"):
        raise InputError(f"{path}: a drawing is written as .svg, .png or .pdf, not as '{suffix}'")
    with mpl.rc_context({**STYLE, "svg.fonttype": "none"}):
        if suffix == ".png":
            figure.savefig(
                path, dpi=150, metadata={"Software": _MAKER}, pil_kwargs={"optimize": True}
            )
        elif suffix == ".pdf":
            figure.savefig(path, dpi=_IMAGES, metadata={"Creator": _MAKER, "CreationDate": None})
        else:
            text = io.StringIO()
            figure.savefig(
                text, format="svg", dpi=_IMAGES, metadata={"Creator": _MAKER, "Date": None}
            )
            path.write_text(_PATHS.sub(_rounded, text.getvalue()), encoding="utf-8")


def _rounded(path: re.Match[str]) -> str:
    """A path of an SVG with two decimals [pt]: half the size, and nothing that could be seen."""
    return _DECIMALS.sub(r"\1", path[0])
