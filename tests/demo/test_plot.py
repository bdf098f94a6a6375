"""The figure."""

import numpy as np

from hybrid_dynamics_ros.demo.judge.plot import draw, save_figure


def test_the_figure_is_written_as_png_and_svg_and_nothing_else(results, robot, tmp_path):
    png, svg = save_figure(results, robot, tmp_path / "figure", "source")
    assert sorted(tmp_path.iterdir()) == [png, svg]
    assert png.read_bytes().startswith(b"\x89PNG")
    assert 20_000 < png.stat().st_size < 200_000  # it is shown in the README
    assert "<svg" in svg.read_text()


def test_the_same_results_give_the_same_svg(results, robot, tmp_path):
    _, first = save_figure(results, robot, tmp_path / "first", "source")
    _, second = save_figure(results, robot, tmp_path / "second", "source")
    assert first.read_bytes() == second.read_bytes()


def test_each_effort_has_a_panel_with_what_was_received(results, robot):
    figure = draw(results, robot, "the source")
    panels = figure.axes[:4]
    for joint, axes in zip(["q1", "q12", "q22", "q4"], panels, strict=True):
        (line,) = axes.lines
        np.testing.assert_array_equal(
            line.get_ydata(), results.efforts.effort[:, results.efforts.names.index(joint)]
        )
        np.testing.assert_allclose(
            line.get_xdata(), np.arange(3, 1001) / 100, rtol=0, atol=1e-12
        )  # ns to s
    assert ["N m" in axes.get_ylabel() for axes in panels] == [True, False, False, True]


def test_axes_have_units_and_the_title_names_the_source(results, robot):
    figure = draw(results, robot, "the source")
    for axes in figure.axes:
        names = ("x", "y", "z") if hasattr(axes, "get_zlabel") else ("x", "y")
        assert all("[" in getattr(axes, f"get_{name}label")() for name in names)
    assert "the source" in [text.get_text() for text in figure.texts]


def test_the_path_is_drawn_through_the_received_positions(results, robot):
    space, over_time = draw(results, robot, "source").axes[4:]
    paths = [np.array(line.get_data_3d()).T for line in space.lines]
    assert any(np.array_equal(path, results.pose.position) for path in paths)
    drawn = np.array([line.get_ydata() for line in over_time.lines]).T
    np.testing.assert_array_equal(drawn, results.pose.position)
