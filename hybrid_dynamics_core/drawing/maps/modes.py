"""Assembly modes side by side."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...closed_state.assembly_modes import AssemblyMode
from ...ground.arrays import Array
from ...robot.robot import Robot
from ...scene.scene import Scene, build_scene
from ...scene.style import INK, QUIET, STYLE
from ..options import Names
from ..paint.layout import axes_at, framed
from ..paint.picture import limits_of, make_scene, paint_scene

_WIDTHS: Final = {1: 6.0, 2: 4.4, 3: 3.6, 4: 3.1}  # [in] of a panel, by their number in a row
_NAMED: Final = 1.4  # factor of a panel's width if all names are shown
_LINE: Final = 0.155  # [in] height of a line of a panel's title
_LETTER: Final = 0.072  # [in] width of a bold letter
_SIDES: Final = (0.66, 0.1)  # [in] left and right of a panel's axes
_GROWTH: Final = 1.8  # largest scale of symbols if the modes need more room than the reference
_SHAPES: Final = (0.5, 1.5)  # least and greatest height of a panel over its width
_FIGURE_SHAPE: Final = 1.5  # preferred ratio of width to height of a figure
_EMPTY: Final = 0.4  # cost of an empty place in the last row


@dataclass(frozen=True)
class _Layout:
    """Panels of one size in rows; lengths in inches."""

    columns: int
    rows: int
    panel: float  # width of a panel
    height: float  # height of the axes
    above: float  # height of the title above the axes
    below: float

    @property
    def width(self) -> float:
        """Width of the axes."""
        return self.panel - sum(_SIDES)

    @property
    def pitch(self) -> float:
        """Height of a row."""
        return self.above + self.height + self.below

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of all panels."""
        return self.columns * self.panel, self.rows * self.pitch

    def box(self, place: int, key: float) -> tuple[float, float, float, float]:
        """Left, bottom, width and height of a panel's axes, above a legend of height `key`."""
        row, column = divmod(place, self.columns)
        left = column * self.panel + _SIDES[0]
        bottom = key + (self.rows - 1 - row) * self.pitch + self.below
        return left, bottom, self.width, self.height


def modes_figure(
    robot: Robot,
    modes: Sequence[AssemblyMode],
    marked: Mapping[str, str],
    names: Names,
    title: str | None,
    most: int,
) -> Figure:
    """The first modes in one view and scale, each with its number and the modes that differ.

    Args:
        robot: robot of the modes.
        modes: all of them.
        marked: the branch of the robot's own mode. If it is not among the first, it replaces the
            last.
        names: which names to show.
        title: title of the figure; None: the robot's name.
        most: number of modes that are drawn.

    Returns:
        The figure.
    """
    with mpl.rc_context({**STYLE, "font.size": 8.0}):
        indices = _drawn(modes, marked, most)
        scenes, limits = _scenes(robot, [modes[k] for k in indices])
        across, up = np.ptp(limits, axis=0)
        shape = float(np.clip(up / across, *_SHAPES))
        columns = _columns(len(indices), shape)
        panel = _WIDTHS[columns] * (_NAMED if names == "all" else 1.0)
        letters = round((panel - sum(_SIDES) + _SIDES[1]) / _LETTER)
        texts = [_text(k, modes, marked, letters) for k in indices]
        layout = _layout(panel, columns, shape, texts, scenes[0].projection.planar)
        title = title or f"{robot.name}: assembly modes"
        line = _line(len(indices), len(modes))
        figure, key = framed(layout.size, scenes, robot.description, title, line)
        for place, (k, scene) in enumerate(zip(indices, scenes, strict=True)):
            axes = axes_at(figure, layout.box(place, key))
            _entitle(axes, texts[place], modes[k].branch == marked)
            paint_scene(axes, scene, names, limits)
            if place % columns:
                axes.set_ylabel("")
    return figure


def _layout(
    panel: float,
    columns: int,
    shape: float,
    texts: Sequence[str],
    planar: bool,
) -> _Layout:
    """The layout for panels of a given width [in] and shape (height over width) with titles."""
    lines = max(text.count("\n") for text in texts)
    return _Layout(
        columns=columns,
        rows=math.ceil(len(texts) / columns),
        panel=panel,
        height=(panel - sum(_SIDES)) * shape,
        above=0.14 + _LINE * (1 + lines),
        below=0.46 if planar else 0.08,
    )


def _entitle(axes: Axes, text: str, is_marked: bool) -> None:
    colour = INK if is_marked else QUIET
    weight = "bold" if is_marked else "normal"
    axes.set_title(text, fontsize=8, color=colour, fontweight=weight)


def _drawn(modes: Sequence[AssemblyMode], marked: Mapping[str, str], most: int) -> list[int]:
    """Indices of the modes to draw."""
    drawn = list(range(min(most, len(modes))))
    late = [k for k in range(len(drawn), len(modes)) if modes[k].branch == marked]
    if late and drawn:
        drawn[-1] = late[0]
    return drawn


def _scenes(robot: Robot, modes: Sequence[AssemblyMode]) -> tuple[list[Scene], Array]:
    """Scenes of the modes, and limits (2, 2) [m] that contain all of them.

    Symbols have a size that suits these limits.
    """
    reference = make_scene(robot, None)
    _, limits = _in_scale(robot, modes, reference)
    growth = np.ptp(limits, axis=0) / np.ptp(limits_of(reference), axis=0)
    unit = reference.joint_radius * float(np.clip(float(growth.max()), 1.0, _GROWTH))
    larger = build_scene(robot.description, reference.skeleton, reference.projection, unit)
    return _in_scale(robot, modes, larger)


def _in_scale(
    robot: Robot, modes: Sequence[AssemblyMode], like: Scene
) -> tuple[list[Scene], Array]:
    """Scenes of the modes like a given one, and limits (2, 2) [m] that contain all of them."""
    scenes = [make_scene(robot, mode.state, like) for mode in modes]
    boxes = np.array([limits_of(scene) for scene in scenes])
    return scenes, np.array([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def _line(drawn: int, total: int) -> str:
    """The subtitle: the number of modes, and an explanation of the names."""
    if total == 1:
        ways = "the one way"
    elif drawn == total:
        ways = f"the {total} ways"
    else:
        ways = f"{drawn} of the {total} ways"
    return (
        f"{ways} in which the loops close with the same active joints, as the verb branches numbers"
        " and names them"
    )


def _columns(count: int, shape: float) -> int:
    """The best number of panels in a row, for the figure's shape and few empty places."""

    def cost(columns: int) -> float:
        rows = math.ceil(count / columns)
        figure_shape = columns / (rows * (shape + 0.2))
        empty = rows * columns - count
        return abs(math.log(figure_shape / _FIGURE_SHAPE)) + _EMPTY * empty

    return min(_WIDTHS, key=cost)


def _text(
    index: int,
    modes: Sequence[AssemblyMode],
    marked: Mapping[str, str],
    letters: int,
) -> str:
    """Number of a mode and its loops that differ, wrapped to lines of `letters`."""
    branch = modes[index].branch
    mark = " (the robot's own)" if branch == marked else ""
    lines = [f"mode {index + 1}{mark}"]
    for loop in branch:
        names = {mode.branch[loop] for mode in modes}
        if len(names) > 1:
            lines += _wrapped(f"{loop}: {branch[loop]}", letters)
    return "\n".join(lines)


def _wrapped(text: str, letters: int) -> list[str]:
    """A text wrapped after a + between names, or after a space."""
    lines = textwrap.wrap(text.replace("+", "+ "), letters, break_long_words=False)
    return [line.replace("+ ", "+") for line in lines]
