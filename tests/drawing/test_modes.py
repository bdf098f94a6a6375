"""Assembly modes side by side."""

import functools
import re

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hybrid_dynamics_core import InputError, Robot
from hybrid_dynamics_core.drawing import draw_modes
from hybrid_dynamics_core.drawing.maps.modes import _columns as columns_of
from hybrid_dynamics_core.drawing.paint.floor import floor_corners, tile_side
from hybrid_dynamics_core.drawing.paint.picture import make_scene
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.scene.attach import rail
from hybrid_dynamics_core.scene.skeleton import place_skeleton
from tests.hard_cases.linkages import four_bar, robot
from tests.sampling import swept

from .conftest import legend_texts, robot_of
from .shapes import SHAPES, shape


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
    written = titles(figure_of("forging_chu2020"))
    (marked,) = [text for text in written if "the robot's own" in text]
    assert marked.count("counterclockwise") == 2


@pytest.mark.parametrize("name", swept(["forging_chu2020", "staicu2015"]))
def test_all_panels_have_one_scale(name: str) -> None:
    figure = figure_of(name)
    first = figure.axes[0]
    for axes in figure.axes:
        np.testing.assert_allclose(axes.get_xlim(), first.get_xlim(), atol=1e-12)
        np.testing.assert_allclose(axes.get_ylim(), first.get_ylim(), atol=1e-12)


def test_panels_have_room_for_all_names() -> None:
    palletizer = robot_of("palletizer")
    some = draw_modes(palletizer, names="joints").axes[0]
    every = draw_modes(palletizer, names="all").axes[0]
    assert 1.3 * some.bbox.width < every.bbox.width < 1.6 * some.bbox.width


@pytest.mark.parametrize("name", ["forging_chu2020", "palletizer"])
def test_panels_begin_right_below_the_heading(name: str) -> None:
    figure = figure_of(name)
    figure.draw_without_rendering()
    lines = [text.get_window_extent().y0 for text in figure.texts if text.get_text()]
    heads = [axes.title.get_window_extent().y1 for axes in figure.axes]
    heads += [axes._left_title.get_window_extent().y1 for axes in figure.axes]
    heading = sorted(lines)[-2]  # the title stands above the line of what is shown
    assert 0.0 < (heading - max(heads)) / figure.dpi < 0.5


@pytest.mark.parametrize(("count", "shape", "columns"), [(2, 1.0, 2), (4, 1.0, 2), (4, 0.5, 2)])
def test_panels_stand_beside_and_above_each_other(count: int, shape: float, columns: int) -> None:
    assert columns_of(count, shape) == columns


def test_modes_may_be_fewer_and_are_written(tmp_path) -> None:
    path = tmp_path / "modes.svg"
    written = titles(draw_modes(robot_of("excavator"), path=path, most=2))
    # The first, and the robot's own under its own number.
    assert written[0].startswith("mode 1")
    assert written[1].startswith("mode 9")
    assert "the robot's own" in written[1]
    text = path.read_text(encoding="utf-8")
    assert "assembly modes" in text
    assert "2 of the 16 ways" in text


def test_where_no_loop_closes_there_is_nothing_to_draw(forging: Robot) -> None:
    with pytest.raises(InputError, match="do not close"):
        draw_modes(forging, [0.0, 9.0, 0.1, 0.0])


def unlimited() -> Robot:
    """A slider-crank whose slide has no limits: its rail is as long as it is needed."""
    text = re.sub(r", limits: [^}]*", "", SHAPES["slider_crank"])
    document = f"format: 1\nname: slider_crank\n{text}"
    return Robot(parse_description(document, file="slider_crank.yaml"))


def upright() -> Robot:
    return robot(four_bar(0.3, 0.1, 0.3, 0.2).replace("axis: z", "axis: y"))


STANDING = {  # robots whose modes lie on both sides of what holds them
    "four-bar": lambda: shape("hinge_and_weld"),
    "upright four-bar": upright,
    "slider-crank": unlimited,
    "five-bar": lambda: robot_of("five_bar"),
}


@pytest.mark.parametrize("make", STANDING.values(), ids=STANDING.keys())
def test_ground_is_the_same_in_every_mode_and_where_the_base_holds_joints(make) -> None:
    """The hatched ground lies below the joints of the base, by a few radii of a joint."""
    mechanism = make()
    modes = mechanism.assembly_modes(mechanism.reference)
    figure = draw_modes(mechanism)
    panels = [_ground(axes) for axes in figure.axes]
    assert len(panels) == len(modes) > 1
    for panel in panels:
        assert panel.keys() == panels[0].keys() != set()
        for name, points in panel.items():
            np.testing.assert_allclose(points, panels[0][name], atol=1e-12)
    for axes, mode in zip(figure.axes, modes, strict=True):
        scene = make_scene(mechanism, mode.state, make_scene(mechanism, None))
        # Marks are larger where modes take more room than the reference, by this at most.
        radius = 1.8 * scene.joint_radius
        skeleton = place_skeleton(mechanism, mode.state)
        held = [joint for joint in skeleton.joints if joint.parent == skeleton.base]
        places = np.array([points.mean(axis=0) for points in _ground(axes).values()])
        assert len(places) == len(held)
        for joint in held:
            if joint.type == "revolute":
                at = scene.projection.project(joint.start)
                assert np.linalg.norm(at - places, axis=1).min() < 5.0 * radius
            else:
                low, high = scene.projection.project(rail(joint))
                along = (places[:, 0] >= low[0]) & (places[:, 0] <= high[0])
                beside = np.abs(places[:, 1] - low[1]) < 3.0 * radius
                assert (along & beside).any()


def _ground(axes: Axes) -> dict[str, np.ndarray]:
    """Points of each hatch by name."""
    points = {}
    for hatch in axes.collections:
        name = hatch.get_gid() or ""
        if re.fullmatch(r"link:base(\.\d+)?", name):
            points[name] = np.vstack(hatch.get_segments())
    return points


@pytest.mark.parametrize("name", ["gough", "delta"])
def test_the_floor_is_at_one_height_in_every_mode(name: str) -> None:
    """The base stands where it does in the reference, also for a mode that reaches below."""
    mechanism = robot_of(name)
    home = make_scene(mechanism, None)
    level = floor_corners(home)[0, 2]
    for mode in mechanism.assembly_modes(mechanism.reference)[:3]:
        scene = make_scene(mechanism, mode.state, home)
        np.testing.assert_allclose(floor_corners(scene)[:, 2], level, atol=1e-12)
        assert tile_side(scene) == tile_side(home)
    if name == "gough":  # its base is the lowest part of it
        base = np.vstack([part.points for part in home.parts if part.role == "base"])
        np.testing.assert_allclose(base[:, 2], level, atol=1e-9)


@pytest.mark.sweep(sample="test_panels_have_room_for_all_names")
def test_long_names_of_loops_go_on_in_the_next_line() -> None:
    for text in titles(figure_of("gough")):
        lines = text.splitlines()
        assert max(map(len, lines)) <= 34  # letters of 0.07 in, in panels of 2.4 in
        loop = "".join(lines[1:]).replace(" ", "")
        assert loop.startswith("leg_A+leg_B+leg_C+leg_D+leg_E+leg_F:")


def test_the_key_tells_what_occurs_in_any_of_the_modes() -> None:
    """The delta's platform is far from where its coordinates begin in one mode only."""
    assert "coordinates of a platform" in legend_texts(figure_of("delta"))


@pytest.mark.parametrize("name", ["delta", "forging_chu2020"])
def test_the_floor_is_whole_tiles_and_a_little_wider_than_the_mechanism(name: str) -> None:
    scene = make_scene(robot_of(name), None)
    tile = tile_side(scene)
    corners = floor_corners(scene)[:, :2]
    points = np.vstack([scene.skeleton.points, *(part.points for part in scene.parts)])[:, :2]
    for room in (points.min(axis=0) - corners[0], corners[2] - points.max(axis=0)):
        assert (room > 0.29 * tile).all()
        assert (room < 1.31 * tile).all()
    counts = (corners[2] - corners[0]) / tile
    np.testing.assert_allclose(counts, np.rint(counts), atol=1e-9)
