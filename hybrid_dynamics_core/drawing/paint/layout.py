"""Figures with a title above and a key below what they show."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...description.model import RobotDescription
from ...scene.scene import Scene
from ...scene.style import QUIET
from .legend import add_legends

_HEAD = 0.62  # [in] title and the line below it
_EDGE = 0.16  # [in] left of the text


def framed(
    size: tuple[float, float],
    scenes: Sequence[Scene],
    description: RobotDescription,
    title: str,
    line: str,
) -> tuple[Figure, float]:
    """A figure with room of a size [in] between title and key; the height of the key [in]."""
    width, height = size
    key = add_legends(Figure(figsize=(width, height + 2.0)), scenes, description)
    total = height + key + _HEAD
    figure = Figure(figsize=(width, total))
    add_legends(figure, scenes, description)
    figure.text(_EDGE / width, 1.0 - 0.24 / total, title, fontsize=13, weight="bold", va="center")
    figure.text(_EDGE / width, 1.0 - 0.46 / total, line, fontsize=9, color=QUIET, va="center")
    return figure, key


def axes_at(figure: Figure, box: tuple[float, float, float, float]) -> Axes:
    """Axes at left, bottom, width and height [in]."""
    width, height = figure.get_size_inches()
    return figure.add_axes((box[0] / width, box[1] / height, box[2] / width, box[3] / height))
