"""Assembly modes side by side."""

import functools

import numpy as np
import pytest
from matplotlib.figure import Figure

from hybrid_dynamics_core import InputError, Robot
from hybrid_dynamics_core.drawing import draw_modes

from .conftest import robot_of


@functools.cache
def figure_of(name: str) -> Figure:
    return draw_modes(robot_of(name))


def titles(figure: Figure) -> list[str]:
    return [axes.get_title(loc="left") for axes in figure.axes]


def test_every_mode_has_a_panel_that_names_what_differs(forging: Robot) -> None:
    modes = forging.assembly_modes(forging.reference)
    written = titles(figure_of("forging_chu2020"))
    assert len(written) == len(modes) == 4
    for text, mode in zip(written, modes, strict=True):
        assert f"theta_1: {mode.branch['theta_1']}" in text
        assert f"theta_2: {mode.branch['theta_2']}" in text
        assert "theta_3" not in text  # a parallelogram in all of them


def test_the_mode_of_the_file_is_marked() -> None:
    own = [text for text in titles(figure_of("forging_chu2020")) if "the robot's own" in text]
    assert len(own) == 1
    assert own[0].count("counterclockwise") == 2


@pytest.mark.parametrize("name", ["forging_chu2020", "staicu2015"])
def test_all_panels_have_one_scale(name: str) -> None:
    figure = figure_of(name)
    limits = np.array([(*axes.get_xlim(), *axes.get_ylim()) for axes in figure.axes])
    np.testing.assert_allclose(limits, np.broadcast_to(limits[0], limits.shape), atol=1e-12)


def test_modes_may_be_fewer_and_are_written(forging: Robot, tmp_path) -> None:
    path = tmp_path / "modes.svg"
    assert len(draw_modes(forging, path=path, most=2).axes) == 2
    assert "assembly modes" in path.read_text(encoding="utf-8")


def test_where_no_loop_closes_there_is_nothing_to_draw(forging: Robot) -> None:
    with pytest.raises(InputError, match="do not close"):
        draw_modes(forging, [0.0, 9.0, 0.1, 0.0])
