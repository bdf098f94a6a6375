"""Maps of the workspace and of margins."""

from dataclasses import replace
from importlib import resources

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.text import Text

from hybrid_dynamics_core import InputError, Robot
from hybrid_dynamics_core.drawing import draw_margins, draw_workspace
from hybrid_dynamics_core.drawing.maps.colours import top_of
from hybrid_dynamics_core.drawing.maps.margin_map import _draw_levels
from hybrid_dynamics_core.drawing.maps.planes import choose_planes
from hybrid_dynamics_core.drawing.maps.workspace import _BEYOND, _extended, _smoothed, values_of
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.kinematics.workspace import SampleStatus
from tests.hard_cases.linkages import four_bar

from .conftest import artists_of, legend_texts, robot_of

TURNING = """
format: 1
name: turning
links: {base: {}, column: {}, upper: {}, fore: {}}
joints:
  turn: {type: revolute, parent: base, child: column, axis: z, limits: [-2, 2]}
  q1:
    {type: revolute, parent: column, child: upper, origin: {xyz: [0, 0, 0.5]}, axis: y,
     limits: [-1, 1]}
  q2:
    {type: revolute, parent: upper, child: fore, origin: {xyz: [1, 0, 0]}, axis: y,
     limits: [0.5, 1.5]}
active: [turn, q1, q2]
end_effector: {link: fore, xyz: [0.6, 0, 0], rpy: [pi/2, 0, 0]}
reference: {q1: -0.5, q2: 1}
"""
_STEP = 0.02  # of the colours: less is not seen beside its neighbour
ROCKER = four_bar(0.3, 0.1, 0.3, 0.2).replace("{link: rocker}", "{link: rocker, xyz: [0.2, 0, 0]}")
PANELS = {
    "excavator": ["in the plane of the arm, at any slew"],
    "five_bar": ["in the robot's plane, x-y"],
    "delta": ["x-z plane, seen along +y", "y-z plane, seen along -x", "x-y plane, seen along -z"],
}


@pytest.mark.parametrize("name", PANELS)
def test_planes_are_chosen_for_the_robot(name, tmp_path) -> None:
    robot = robot_of(name)
    workspace = robot.workspace(3_000)
    path = tmp_path / "map.svg"
    figure = draw_workspace(robot, workspace, path)
    assert [axes.get_title(loc="left") for axes in figure.axes[:-1]] == PANELS[name]
    *panels, key = (axes.get_position() for axes in figure.axes)
    for panel in panels:  # their titles stand in one line
        assert panel.y0 == pytest.approx(panels[0].y0, abs=1e-9)
        assert panel.y1 == pytest.approx(panels[0].y1, abs=1e-9)
    assert key.x0 == pytest.approx(panels[0].x0)
    width = key.width * figure.get_figwidth()
    assert key.x1 == pytest.approx(panels[-1].x1) or width == pytest.approx(5.2)
    text = path.read_text(encoding="utf-8")
    for link in robot.description.links:  # the robot's own skeleton is in the picture
        if link != robot.base_frame and robot.description.links[link].mass:
            assert f'id="link:{link}' in text
    for axes, plane in zip(figure.axes, choose_planes(robot), strict=False):
        low, high = np.array([axes.get_xlim(), axes.get_ylim()]).T
        points = plane.points(workspace.samples)
        good = points[np.isfinite(points).all(axis=1)]
        assert (good > low).all()
        assert (good < high).all()


def test_a_turning_arm_is_turned_back() -> None:
    """Radius and height are kept, and nothing is left beside the plane of the arm."""
    robot = robot_of("excavator")
    samples = robot.workspace(500).samples
    (plane,) = choose_planes(robot)
    across, up = plane.points(samples).T
    x, y, z = samples.position.T
    assert np.abs(across) == pytest.approx(np.hypot(x, y), abs=1e-12)
    assert up == pytest.approx(z, abs=1e-12)


def test_a_column_that_does_not_turn_round_is_shown_from_above_too() -> None:
    file = resources.files("hybrid_dynamics_core").joinpath("robots/type_d.yaml")
    text = file.read_text(encoding="utf-8")
    limited = text.replace("axis: z, limits: [-pi, pi]}", "axis: z, limits: [-1, 1]}", 1)
    robot = Robot(parse_description(limited))
    assert robot.limits[0].tolist() == [-1.0, 1.0]
    titles = [plane.title for plane in choose_planes(robot)]
    assert titles == ["in the plane of the arm, at any q1", "x-y plane, seen along -z"]


def test_values_are_those_of_reachable_samples() -> None:
    robot = robot_of("five_bar")
    samples = robot.workspace(200).samples
    assert values_of(samples, "singularity") == pytest.approx(samples.singularity)
    assert values_of(samples, "limits") == pytest.approx(np.clip(samples.limit, 0.0, 1.0))


@pytest.mark.parametrize(
    ("largest", "top"),
    [
        (0.236, 0.25),
        (0.25, 0.25),
        (0.0103, 0.015),
        (0.62, 0.65),
        (0.97, 1.0),
        (1.0, 1.0),
        (0.0, 1.0),
    ],
)
def test_colours_end_at_the_largest_value_rounded_up(largest: float, top: float) -> None:
    maps = [np.array([np.nan, 0.0]), np.array([largest, largest / 2.0])]
    assert top_of(maps) == pytest.approx(top)
    assert top_of([np.array([np.nan])]) == 1.0


def test_the_bar_says_where_the_colours_end() -> None:
    robot = robot_of("delta")
    figure = draw_workspace(robot, robot.workspace(2_000))
    *panels, bar = figure.axes
    maps = [panel.collections[0] for panel in panels]
    largest = max(float(drawn.get_array().max()) for drawn in maps)
    top = bar.get_xlim()[1]
    assert 0.5 < largest <= top < 1.0
    assert bar.get_title(loc="left").endswith(f"1 best; colours up to {top:.3g})")
    for drawn in maps:  # one scale for all
        assert drawn.get_clim() == (0.0, top)


def coloured_line(figure: Figure) -> LineCollection:
    """The line of a path, which lies on a wider one in ink."""
    drawn = figure.axes[0].collections
    lines = [line for line in drawn if isinstance(line, LineCollection)]
    return lines[1]


def test_one_active_joint_gives_a_line_in_the_colours_of_its_margin() -> None:
    """The rocker of a four-bar: its end on an arc, each piece with the robot's margin there."""
    robot = Robot(parse_description(ROCKER))
    workspace = robot.workspace(500)
    figure = draw_workspace(robot, workspace)
    coloured = coloured_line(figure)
    ends = np.array(coloured.get_segments())
    state = robot.close(workspace.samples.first(workspace.spread).u)
    places = robot.forward_kinematics(state).position
    assert len(ends) == len(places) - 1
    lengths = np.hypot(*np.diff(ends, axis=1)[:, 0].T)
    assert lengths.max() < 0.02  # neighbours of that joint, not as they were drawn
    assert np.linalg.norm(ends - [0.3, 0.0], axis=2) == pytest.approx(0.2, abs=1e-12)
    assert np.ptp(ends[:, 0, 0]) > 0.1
    margin = np.sort(workspace.samples.first(workspace.spread).singularity)
    values = np.asarray(coloured.get_array())
    assert margin[0] <= values.min() <= values.max() <= margin[-1]
    assert values.max() == pytest.approx(margin[-1], rel=1e-2)
    kinds = {type(drawn).__name__ for drawn in figure.axes[0].collections}
    assert "QuadContourSet" not in kinds


def test_a_line_has_gaps_where_nothing_closes() -> None:
    robot = Robot(parse_description(ROCKER))
    workspace = robot.workspace(400)
    u = workspace.samples.u[:, 0]
    is_open = np.abs(u - robot.reference[0]) < 0.2
    status = np.where(is_open, SampleStatus.BEYOND, workspace.samples.status)
    workspace = replace(workspace, samples=replace(workspace.samples, status=status))
    samples = workspace.samples.first(workspace.spread)
    reachable = samples.reachable[np.argsort(samples.u[:, 0])]
    pieces = int((reachable[:-1] & reachable[1:]).sum())
    assert 0 < reachable.sum() < len(reachable)
    figure = draw_workspace(robot, workspace)
    segments = coloured_line(figure).get_segments()
    assert len(segments) == pieces < reachable.sum() - 1  # a gap in the middle


def test_a_map_of_two_joints_shows_ends(tmp_path) -> None:
    robot = robot_of("type_d")
    path = tmp_path / "over.png"
    figure = draw_margins(robot, ("q2", "p3"), path=path)
    axes, bar = figure.axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("q2 [m]", "p3 [rad]")
    assert not axes.get_position().overlaps(bar.get_position())
    assert bar.get_position().x1 == pytest.approx(axes.get_position().x1)
    upright = [line.get_xdata() for line in axes.lines if np.ptp(line.get_xdata()) == 0.0]
    ends = {round(float(x[0]), 6) for x in upright}
    assert {0.02, 0.32} <= ends
    assert path.read_bytes().startswith(b"\x89PNG")
    words = legend_texts(figure)
    assert "stroke end or limit" in words
    assert "toggle point of a loop" not in words
    assert "reference configuration" in words


def test_toggle_points_differ_from_limits() -> None:
    u = [0.0, 0.2, 0.1, 0.0]
    forging = robot_of("forging_chu2020")
    figure = draw_margins(forging, ("q12", "q22"), u, colour="singularity")
    words = legend_texts(figure)
    assert "toggle point of a loop" in words
    assert "stroke end or limit" not in words
    assert "loops do not close here" in words
    assert "configuration given" in words  # the map is taken there, not at the reference


@pytest.mark.parametrize(
    ("pair", "colour", "words"),
    [
        (
            ("q12", "q2"),
            "singularity",
            r"'q2' is not an active joint \(did you mean 'q22'\?\); they are q1, q12, q22, q4",
        ),
        (("q12", "q12"), "singularity", "two different active joints"),
        (("q12", "q22"), "red", "none of singularity, limits"),
    ],
)
def test_wrong_choices_are_refused(pair, colour, words) -> None:
    with pytest.raises(InputError, match=words):
        draw_margins(robot_of("forging_chu2020"), pair, colour=colour)


def test_letters_of_axes_stand_on_no_part_of_the_robot() -> None:
    """Seen from above an arm is a bar, and axes that lie in it have their letters beside it."""
    arm = Robot(parse_description(TURNING))
    figure = draw_workspace(arm, arm.workspace(500))
    above = next(
        axes for axes in figure.axes if axes.get_title(loc="left") == "x-y plane, seen along -z"
    )
    bars = artists_of(above, Polygon, "link:")
    letters = artists_of(above, Text, "letter:")
    assert len(bars) >= 2
    assert {text.get_text() for text in letters} >= {"x"}
    for text in letters:
        place = text.get_window_extent().get_points().mean(axis=0)
        middle = above.transData.inverted().transform(place)
        assert not any(bar.get_path().contains_point(middle) for bar in bars)


def test_colours_change_in_invisible_steps_and_drawings_of_lines_stay_light(
    tmp_path,
) -> None:
    robot, path = robot_of("excavator"), tmp_path / "map.svg"
    figure = draw_workspace(robot, robot.workspace(3_000), path, colour="limits")
    drawn = [getattr(areas, "levels", ()) for areas in figure.axes[0].collections]
    levels = next(levels for levels in drawn if len(levels) > 2)
    assert np.diff(levels).max() < _STEP * np.ptp(levels)
    assert path.stat().st_size < 600_000  # [bytes]; 4 MB where every step is an outline


def test_smoothing_keeps_a_constant_up_to_its_edge_and_carries_it_some_cells_further() -> None:
    values = np.full((30, 30), np.nan)
    values[9:19, 10:21] = 0.3
    smoothed = _smoothed(values)
    np.testing.assert_allclose(smoothed, values, rtol=1e-12)
    carried = np.isfinite(_extended(smoothed))
    assert carried[12].nonzero()[0].tolist() == list(range(10 - int(_BEYOND), 21 + int(_BEYOND)))


@pytest.mark.parametrize(("place", "has_name"), [(0.09, False), (0.11, True), (0.89, True)])
def test_a_line_with_room_beside_it_is_named(place: float, has_name: bool) -> None:
    """Of what is shown 0.08 / 1.16 at each end lie beyond the ranges, and 0.03 are kept clear."""
    line = np.linspace(-1.0, 3.0, 41)
    across = np.tile((line + 1.0) / 4.0, (41, 1))
    axes = Figure().add_subplot()
    _draw_levels(axes, [line, line], 0.2 + 0.1 * (across - place))
    assert [text.get_text() for text in axes.texts] == ["0.2"] * has_name
