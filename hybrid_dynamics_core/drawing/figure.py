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
from .paint.picture import limits_of, make_scene, paint_scene, with_visuals

_WIDTH: Final = 7.2  # [in]
_HEIGHTS: Final = (1.8, 6.0)  # [in] least and greatest, of the axes
# [in] margins left, right and below the axes, for ticks and names of a planar view
_PLANAR: Final = (0.76, 0.16, 0.46)
_SPATIAL: Final = (0.1, 0.1, 0.05)
_DPI_OF_IMAGES: Final = 200  # resolution of images inside vector graphics
_DPI_OF_PNG: Final = 150
_LABEL: Final = 0.2  # [in] right edge of the name of the vertical axis
_PATHS: Final = re.compile(r' d="[^"]*"')  # of an SVG
_DECIMALS: Final = re.compile(r"(\.\d\d)\d+")  # two decimals to keep, and the rest
# Metadata of files: the program that made them.
_MAKER: Final = f"hybrid_dynamics, Matplotlib {mpl.__version__}"


def robot_figure(
    robot: Robot,
    state: ClosedState | None,
    names: Names,
    title: str | None,
    skeleton: bool = False,
) -> Figure:
    """A robot in a closed state.

    Args:
        robot: to be drawn.
        state: one closed state; None: the reference configuration.
        names: which names to show.
        title: title of the figure; None: the robot's name.
        skeleton: whether visuals are left out.

    Returns:
        The figure.
    """
    with mpl.rc_context(STYLE):
        scene = make_scene(robot, state)
        if not skeleton:
            scene = with_visuals(scene, robot, state)
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
    """Write a figure in the format of the file's suffix.

    Args:
        figure: to be written.
        path: path of the file, .svg, .png or .pdf.

    Raises:
        InputError: for other suffixes.
    """
    suffix = path.suffix.lower()
    writers = {".svg": _save_svg, ".png": _save_png, ".pdf": _save_pdf}
    if suffix not in writers:
        raise InputError(f"{path}: a drawing is written as .svg, .png or .pdf, not as '{suffix}'")
    with mpl.rc_context({**STYLE, "svg.fonttype": "none"}):
        writers[suffix](figure, path)


def _save_svg(figure: Figure, path: Path) -> None:
    text = io.StringIO()
    metadata = {"Creator": _MAKER, "Date": None}
    figure.savefig(text, format="svg", dpi=_DPI_OF_IMAGES, metadata=metadata)
    path.write_text(_PATHS.sub(_rounded, text.getvalue()), encoding="utf-8")


def _save_png(figure: Figure, path: Path) -> None:
    metadata = {"Software": _MAKER}
    figure.savefig(
        path,
        dpi=_DPI_OF_PNG,
        metadata=metadata,
        pil_kwargs={"optimize": True},
    )


def _save_pdf(figure: Figure, path: Path) -> None:
    metadata = {"Creator": _MAKER, "CreationDate": None}
    figure.savefig(path, dpi=_DPI_OF_IMAGES, metadata=metadata)


def _rounded(path: re.Match[str]) -> str:
    """A path of an SVG with two decimals [pt]: half the size, and no visible difference."""
    return _DECIMALS.sub(r"\1", path[0])
