"""Figures with a title above and a legend below the axes."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...description.model import RobotDescription
from ...scene.scene import Scene
from ...scene.style import QUIET
from .legend import add_legends

_HEAD = 0.62  # [in] height of title and subtitle
_EDGE = 0.16  # [in] left of the text


def framed(
    size: tuple[float, float],
    scenes: Sequence[Scene],
    description: RobotDescription,
    title: str,
    line: str,
) -> tuple[Figure, float]:
    """A figure with a title, a legend, and room for axes between them.

    Args:
        size: width and height of the room [in].
        scenes: scenes of one robot, for the legend.
        description: description of the robot.
        title: title of the figure.
        line: subtitle.

    Returns:
        The figure, and the height of the legend [in].
    """
    width, height = size
    key = add_legends(Figure(figsize=(width, height + 2.0)), scenes, description)
    total = height + key + _HEAD
    figure = Figure(figsize=(width, total))
    add_legends(figure, scenes, description)
    left = _EDGE / width
    figure.text(
        left,
        1.0 - 0.24 / total,
        title,
        fontsize=13,
        weight="bold",
        va="center",
    )
    figure.text(
        left,
        1.0 - 0.46 / total,
        line,
        fontsize=9,
        color=QUIET,
        va="center",
    )
    return figure, key


def axes_at(figure: Figure, box: tuple[float, float, float, float]) -> Axes:
    """Axes in a box of left, bottom, width and height [in]."""
    left, bottom, across, up = box
    width, height = figure.get_size_inches()
    return figure.add_axes((left / width, bottom / height, across / width, up / height))
