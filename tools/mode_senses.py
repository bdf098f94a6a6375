"""Draw what the names of assembly modes mean, for docs/own_robot.md."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch

from hybrid_dynamics_core.drawing.style import BLUE, INK, ORANGE, QUIET, SHADOW

Point = tuple[float, float]

FIRST: Point = (0.0, 0.0)
SECOND: Point = (1.0, 0.0)
HIGH: Point = (0.62, 0.72)
LOW: Point = (0.62, -0.72)
ALONG: Point = (1.0, 0.0)  # the line on which a stroke is found
NEAR: Point = (0.38, 0.0)
FAR: Point = (1.52, 0.0)
CENTRE: Point = (0.95, 0.55)
RADIUS = 0.14


def senses_picture() -> Figure:
    """Four panels: the two senses of a triangle, the two strokes of a slider."""
    figure = Figure(figsize=(7.4, 2.3), layout="constrained")
    panels = figure.subplots(1, 4)
    triangle(panels[0], "counterclockwise", HIGH)
    triangle(panels[1], "clockwise", LOW)
    slider(panels[2], "extended", FAR, NEAR)
    slider(panels[3], "retracted", NEAR, FAR)
    return figure


def triangle(axes: Axes, name: str, pin: Point) -> None:
    """Two bars from their pivots to a pin, and the sense of first pivot, second pivot, pin."""
    prepare(axes, name, (-0.3, 1.3), (-1.05, 1.05))
    bar(axes, FIRST, pin)
    bar(axes, SECOND, pin)
    axes.plot(*np.transpose([FIRST, SECOND]), color=SHADOW, linewidth=1.2, linestyle="--")
    joint(axes, FIRST, "1", (-0.16, 0.0))
    joint(axes, SECOND, "2", (1.16, 0.0))
    side = float(np.sign(pin[1]))
    joint(axes, pin, "pin", (pin[0], pin[1] + 0.2 * side))
    turn(axes, np.mean([FIRST, SECOND, pin], axis=0), side)


def slider(axes: Axes, name: str, pin: Point, other: Point) -> None:
    """A bar of fixed length whose pin is on the line of a stroke: two strokes fit."""
    prepare(axes, name, (-0.15, 1.75), (-1.05, 1.05))
    axes.plot([-0.1, 1.7], [0.0, 0.0], color=SHADOW, linewidth=1.2, linestyle="--")
    axes.plot(*np.transpose([CENTRE, other]), color=SHADOW, linewidth=2.0)
    bar(axes, FIRST, pin, BLUE)
    bar(axes, CENTRE, pin)
    joint(axes, CENTRE, "pivot", (CENTRE[0], CENTRE[1] + 0.2))
    joint(axes, pin, "pin", (pin[0] + 0.16, -0.2))
    arrow(axes, (FIRST[0], -0.42), (pin[0], -0.42))
    axes.text(FIRST[0], -0.64, "stroke", ha="left", fontsize=8.5, color=QUIET)


def prepare(axes: Axes, name: str, width: Point, height: Point) -> None:
    """Empty axes with a title."""
    axes.set_title(name, fontsize=10, color=INK, loc="center")
    axes.set(xlim=width, ylim=height, aspect="equal")
    axes.axis("off")


def bar(axes: Axes, start: Point, end: Point, colour: str = INK) -> None:
    """A link between two joints."""
    axes.plot(*np.transpose([start, end]), color=colour, linewidth=3.0, solid_capstyle="round")


def joint(axes: Axes, place: Point, name: str, label: Point) -> None:
    """A pin, with its name beside it."""
    axes.plot(*place, "o", color="white", markeredgecolor=INK, markersize=7)
    axes.text(*label, name, ha="center", va="center", fontsize=9, color=INK)


def turn(axes: Axes, centre: np.ndarray, side: float) -> None:
    """A round arrow about a centre, counterclockwise for a positive side."""
    angles = np.linspace(0.9 * np.pi, 2.4 * np.pi, 40)
    if side < 0.0:
        angles = -angles
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    places = centre + RADIUS * circle
    axes.plot(*places[:-2].T, color=ORANGE, linewidth=1.6)
    arrow(axes, tuple(places[-3]), tuple(places[-1]))


def arrow(axes: Axes, start: Point, end: Point) -> None:
    """A straight arrow from start to end."""
    patch = FancyArrowPatch(
        start,
        end,
        arrowstyle="-|>",
        mutation_scale=11,
        color=ORANGE,
        linewidth=1.6,
        shrinkA=0,
        shrinkB=0,
    )
    axes.add_patch(patch)
