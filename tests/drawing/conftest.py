"""Every robot that is drawn: the shipped ones and others of many shapes, each loaded once."""

import functools

import pytest
from matplotlib.figure import Figure

from hybrid_dynamics_core import Robot, load, shipped_robots
from hybrid_dynamics_core.drawing import draw

from .shapes import SHAPES, shape

ROBOTS = (*shipped_robots(), *SHAPES)


@functools.cache
def robot_of(name: str) -> Robot:
    """A shipped robot or one of the shapes."""
    return shape(name) if name in SHAPES else load(name)


@functools.cache
def drawing_of(name: str) -> Figure:
    """A robot drawn with the names of its active joints: for reading only."""
    return draw(robot_of(name))


def artists_of(figure: Figure, kind: type, *prefixes: str) -> list:
    """Artists of a kind whose names begin with one of some prefixes."""
    artists = figure.findobj(kind)
    return [artist for artist in artists if (artist.get_gid() or "").startswith(prefixes)]


def legend_texts(figure: Figure) -> list[str]:
    """What the keys of a figure say."""
    texts = []
    for legend in figure.legends:
        texts += [text.get_text() for text in legend.get_texts()]
    return texts


@pytest.fixture(params=ROBOTS)
def robot(request: pytest.FixtureRequest) -> Robot:
    """Each robot in turn."""
    return robot_of(request.param)
