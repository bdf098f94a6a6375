"""Assembly modes side by side."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from typing import Final

import matplotlib as mpl
import numpy as np
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
_NAMED: Final = 1.4  # times as wide where all names stand in it
_LINE: Final = 0.155  # [in] height of a line of a panel's title
_LETTER: Final = 0.072  # [in] width of one, in bold
_SIDES: Final = (0.66, 0.1)  # [in] left and right of a panel's axes
_GROWTH: Final = 1.8  # of marks, at most, where modes take more room than the reference alone
_SHAPES: Final = (0.5, 1.5)  # least and greatest height of a panel over its width


def modes_figure(
    robot: Robot,
    modes: Sequence[AssemblyMode],
    own: Mapping[str, str],
    names: Names,
    title: str | None,
    most: int,
) -> Figure:
    """The first `most` modes in one view and scale, each under its number and the names of what differs.

    own: the mode of the robot's file; where it comes later, it takes the last place.
    """
    with mpl.rc_context({**STYLE, "font.size": 8.0}):
        shown = _shown(modes, own, most)
        first, scenes, limits = _scenes(robot, [modes[k] for k in shown])
        across, up = np.ptp(limits, axis=0)
        shape = float(np.clip(up / across, *_SHAPES))
        columns = _columns(len(shown), shape)
        panel = _WIDTHS[columns] * (_NAMED if names == "all" else 1.0)
        width = panel - sum(_SIDES)
        texts = [_text(k, modes, own, round((width + _SIDES[1]) / _LETTER)) for k in shown]
        height = width * shape
        above = 0.14 + _LINE * (1 + max(text.count("\n") for text in texts))
        below = 0.46 if first.projection.planar else 0.08
        pitch = above + height + below
        rows = math.ceil(len(shown) / columns)
        size = (columns * panel, rows * pitch)
        line = _line(len(shown), len(modes))
        figure, key = framed(
            size, scenes, robot.description, title or f"{robot.name}: assembly modes", line
        )
        for place, (k, scene, text) in enumerate(zip(shown, scenes, texts, strict=True)):
            row, column = divmod(place, columns)
            left, bottom = column * panel + _SIDES[0], key + (rows - 1 - row) * pitch + below
            axes = axes_at(figure, (left, bottom, width, height))
            chosen = modes[k].branch == own
            axes.set_title(
                text,
                fontsize=8,
                color=INK if chosen else QUIET,
                fontweight="bold" if chosen else "normal",
            )
            paint_scene(axes, scene, names, limits)
            if column:
                axes.set_ylabel("")
    return figure


def _shown(modes: Sequence[AssemblyMode], own: Mapping[str, str], most: int) -> list[int]:
    """Which modes are drawn."""
    shown = list(range(min(most, len(modes))))
    late = [k for k in range(len(shown), len(modes)) if modes[k].branch == own]
    return [*shown[:-1], late[0]] if late and shown else shown


def _scenes(robot: Robot, modes: Sequence[AssemblyMode]) -> tuple[Scene, list[Scene], Array]:
    """The reference, the modes, and limits that hold all of them; marks of a size that suits these limits."""
    first, unit = make_scene(robot, None), None
    while True:
        scenes = [make_scene(robot, mode.state, first) for mode in modes]
        boxes = np.array([limits_of(scene) for scene in scenes])
        limits = np.array([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])
        if unit is not None:
            return first, scenes, limits
        growth = float((np.ptp(limits, axis=0) / np.ptp(limits_of(first), axis=0)).max())
        unit = first.unit * float(np.clip(growth, 1.0, _GROWTH))
        first = build_scene(robot.description, first.skeleton, first.projection, unit)


def _line(count: int, all_: int) -> str:
    """What is shown, and what the names above the panels are."""
    every = f"the {all_} ways" if count == all_ > 1 else f"{count} of the {all_} ways"
    ways = "the one way" if all_ == 1 else every
    return (
        f"{ways} in which the loops close with the same active joints, as the verb branches numbers"
        " and names them"
    )


def _columns(count: int, shape: float) -> int:
    """Panels in a row, so that the figure is about one and a half times as wide as high and few places stay empty."""

    def unsuited(columns: int) -> float:
        rows = math.ceil(count / columns)
        return abs(math.log(columns / (rows * (shape + 0.2)) / 1.5)) + 0.4 * (
            rows * columns - count
        )

    return min(_WIDTHS, key=unsuited)


def _text(k: int, modes: Sequence[AssemblyMode], own: Mapping[str, str], most: int) -> str:
    """Number of a mode and the loops in which the modes differ, each on lines of `most` letters."""
    told = [name for name in modes[k].branch if len({mode.branch[name] for mode in modes}) > 1]
    mark = " (the robot's own)" if modes[k].branch == own else ""
    lines = [line for name in told for line in _broken(f"{name}: {modes[k].branch[name]}", most)]
    return "\n".join([f"mode {k + 1}{mark}", *lines])


def _broken(text: str, most: int) -> list[str]:
    """A text in lines: where it is too long it goes on behind a + between names, or behind a space."""
    lines = textwrap.wrap(text.replace("+", "+ "), most, break_long_words=False)
    return [line.replace("+ ", "+") for line in lines]
