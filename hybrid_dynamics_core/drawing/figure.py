"""A robot with title, picture and key."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from ..errors import InputError
from ..robot import Robot
from ..state import ClosedState
from .layout import axes_at, framed
from .legend import subtitle
from .names import Names
from .picture import limits_of, make_scene, paint_scene
from .style import STYLE

_WIDTH: Final = 7.2  # [in]
_TALLEST: Final = 6.0  # [in], of the axes
_PLANAR: Final = (0.62, 0.16, 0.46)  # [in] left, right and below the axes of a planar view: ticks and names
_SPATIAL: Final = (0.1, 0.1, 0.05)
_FORMATS: Final[dict[str, dict[str, Any]]] = {
    ".svg": {"metadata": {"Date": None}},
    ".png": {"dpi": 150, "pil_kwargs": {"optimize": True}},
}


def robot_figure(robot: Robot, state: ClosedState | None, names: Names, title: str | None) -> Figure:
    """A robot in a state, or in its reference configuration."""
    with mpl.rc_context(STYLE):
        scene = make_scene(robot, state)
        limits = limits_of(scene)
        left, right, below = _PLANAR if scene.view.planar else _SPATIAL
        across, up = np.ptp(limits, axis=0)
        width = _WIDTH - left - right
        height = min(width * float(up / across), _TALLEST)
        size = (_WIDTH, height + below)
        figure, key = framed(size, scene, robot.description, title or robot.name, subtitle(scene))
        paint_scene(axes_at(figure, (left, key + below, width, height)), scene, names, limits)
    return figure


def save(figure: Figure, path: Path) -> None:
    """Write a figure as what the suffix says. Raises InputError for others than .svg and .png."""
    suffix = path.suffix.lower()
    if suffix not in _FORMATS:
        raise InputError(f"{path}: a drawing is written as {' or '.join(_FORMATS)}, not as '{suffix}'")
    with mpl.rc_context({**STYLE, "svg.fonttype": "none"}):
        figure.savefig(path, **_FORMATS[suffix])
