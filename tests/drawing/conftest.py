"""Every robot that is drawn: the shipped ones and others of many shapes.

Each is loaded once, and drawn once with each set of names.
"""

import functools
from collections.abc import Callable
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from hybrid_dynamics_core import Robot, load, shipped_robots
from hybrid_dynamics_core.drawing import draw
from tests.sampling import swept

from .shapes import SHAPES, shape

ROBOTS = (*shipped_robots(), *SHAPES)
# planar and spatial loops, sliders, a serial arm
SAMPLE = ("delta", "forging_chu2020", "slider_crank", "wrist")


@functools.cache
def robot_of(name: str) -> Robot:
    """A shipped robot or one of the shapes."""
    return shape(name) if name in SHAPES else load(name)


@functools.cache
def drawing_of(name: str, names: str = "active") -> Figure:
    """A robot drawn with the names of its active joints, or others: for reading only."""
    return draw(robot_of(name), names=names, skeleton=True)


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


@pytest.fixture(scope="session")
def svg_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """The file of a robot's drawing, made once."""
    folder = tmp_path_factory.mktemp("drawings")

    def path_of(name: str) -> Path:
        path = folder / f"{name}.svg"
        if not path.exists():
            draw(robot_of(name), path=path, skeleton=True)
        return path

    return path_of


@pytest.fixture(params=swept(ROBOTS, SAMPLE))
def robot(request: pytest.FixtureRequest) -> Robot:
    """Each robot in turn."""
    return robot_of(request.param)
