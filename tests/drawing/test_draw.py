"""What a drawing holds: every link, joint, loop and active name, in both formats."""

import re
from collections.abc import Callable
from itertools import combinations, pairwise
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.text import Text

from hybrid_dynamics_core import ClosedState, InputError, Robot
from hybrid_dynamics_core.drawing import draw, draw_on
from hybrid_dynamics_core.drawing.paint.labels import Label, Labeller, TextBox
from hybrid_dynamics_core.drawing.paint.legend import add_legends
from hybrid_dynamics_core.drawing.paint.picture import make_scene
from hybrid_dynamics_core.scene.style import RED
from tests.sampling import swept

from .conftest import artists_of, drawing_of, robot_of


def gids(figure: Figure) -> set[str]:
    names = {artist.get_gid() for artist in figure.findobj()}
    return {name for name in names if name}


def owners(names: set[str], kind: str) -> set[str]:
    """Names with artists of their own; several that are drawn as one are joined by +."""
    result = set()
    for gid in names:
        if gid.startswith(f"{kind}:"):
            result |= set(gid.removeprefix(f"{kind}:").split("+"))
    return result


def labels(figure: Figure) -> set[str]:
    names = set()
    for artist in artists_of(figure, Text, "name:"):
        names |= set(artist.get_text().split(", "))
    return names


def links_of(robot: Robot) -> set[str]:
    return {robot.base_frame, *robot.description.links}


def test_every_link_joint_and_closure_has_its_artist(robot: Robot) -> None:
    names = gids(drawing_of(robot.name))
    closures = {closure.name for closure in robot.description.closures}
    assert owners(names, "link") >= links_of(robot)
    assert owners(names, "joint") >= set(robot.coordinates)
    assert owners(names, "closure") >= closures


def test_the_svg_holds_them_by_name_and_the_active_names_as_text(
    robot: Robot, svg_of: Callable[[str], Path]
) -> None:
    ids, written = set(), set()
    for element in ElementTree.parse(svg_of(robot.name)).iter():
        ids.add(element.get("id", ""))
        if element.tag.endswith("}text"):
            written.add("".join(element.itertext()).strip())
    assert owners(ids, "link") >= links_of(robot)
    assert owners(ids, "joint") >= set(robot.coordinates)
    assert written >= {*robot.active, robot.end_effector, robot.name}
    for closure in robot.description.closures:
        assert any(text.startswith(f"{closure.name}: ") for text in written), closure.name


def test_names_are_shown_as_asked(robot: Robot) -> None:
    joints = labels(drawing_of(robot.name, "joints"))
    everything = labels(drawing_of(robot.name, "all"))
    assert labels(drawing_of(robot.name, "none")) == set()
    assert labels(drawing_of(robot.name)) == {*robot.active, robot.end_effector}
    assert joints == {*robot.coordinates, robot.end_effector}
    assert everything > joints
    assert everything <= {*robot.coordinates, *robot.frames, robot.base_frame}


def test_the_base_is_named_among_the_links(robot: Robot) -> None:
    assert robot.base_frame in labels(drawing_of(robot.name, "all"))


@pytest.mark.parametrize("name", ["five_bar", "slider_crank"])
def test_the_key_begins_and_ends_where_its_room_does(name: str) -> None:
    figure = Figure(figsize=(4.0, 6.0))
    machine = robot_of(name)
    height = add_legends(figure, [make_scene(machine, None)], machine.description)
    boxes = [legend.get_window_extent() for legend in figure.legends]
    ends = figure.dpi * np.array([0.05, height])
    assert [boxes[0].y0, boxes[-1].y1] == pytest.approx(ends, abs=0.5)
    assert min(box.x0 for box in boxes) == pytest.approx(0.012 * figure.bbox.width, abs=0.5)
    for below, above in pairwise(boxes):
        assert below.y1 == pytest.approx(above.y0, abs=0.5)


@pytest.mark.parametrize(("name", "which"), [("five_bar", "the"), ("excavator", "each")])
def test_the_pin_of_the_key_is_that_of_the_picture(name: str, which: str) -> None:
    figure = drawing_of(name)
    handles = {}
    for legend in figure.legends:
        texts = [text.get_text() for text in legend.get_texts()]
        handles |= dict(zip(texts, legend.legend_handles, strict=True))
    handle = handles[f"pin that closes {which} loop"]
    closures = {f"closure:{closure.name}" for closure in robot_of(name).description.closures}
    pins = [artist for artist in figure.findobj(Polygon) if artist.get_gid() in closures]
    edges = {to_hex(pin.get_edgecolor()) for pin in pins}
    assert to_hex(handle.get_markeredgecolor()) in edges


def test_active_joints_and_no_others_have_the_colour_of_drives(robot: Robot) -> None:
    figure = drawing_of(robot.name)
    red = set()
    for patch in artists_of(figure, Polygon, "joint:"):
        if to_hex(patch.get_facecolor()) == RED:
            name = patch.get_gid().removeprefix("joint:")
            red.add(re.sub(r"\.\d+$", "", name))
    assert red == set(robot.active)
    arrows = set(robot.active)
    for name in robot.active:
        arrows.add(f"{name}.head")
        if robot.joint_types[name] == "prismatic":
            arrows.add(f"{name}.head.2")
    assert owners(gids(figure), "drive") == arrows


def test_names_of_active_joints_do_not_hide_each_other(robot: Robot) -> None:
    figure = drawing_of(robot.name)
    named = artists_of(figure, Text, "name:")
    assert len(named) == len(robot.active) + 1
    boxes = [label.get_window_extent() for label in named]
    for one, other in combinations(boxes, 2):
        assert not one.overlaps(other)
    for box in boxes:
        assert np.all(figure.bbox.min <= box.min)
        assert np.all(box.max <= figure.bbox.max)


def test_letters_of_axes_stand_on_no_joint_and_no_arrow(robot: Robot) -> None:
    figure = drawing_of(robot.name)
    letters = artists_of(figure, Text, "letter:")
    # Of the end effector's frame; an axis along the view has a mark instead.
    assert len(letters) >= 2
    symbols = artists_of(figure, Polygon, "joint:", "drive:")
    for letter in letters:
        middle = np.mean(letter.get_window_extent().get_points(), axis=0)
        for symbol in symbols:
            outline = symbol.get_path().transformed(symbol.get_transform())
            assert not outline.contains_point(middle), symbol.get_gid()


def test_letters_of_axes_stand_ahead_of_their_arrows(robot: Robot) -> None:
    """None is nearer to the arrow of another; those that had to give way may stand beside it."""
    scene = make_scene(robot, None)
    ends = {line.owner: scene.projection.project(line.points) for line in scene.lines}
    for letter in artists_of(drawing_of(robot.name), Text, "letter:frame:"):
        name = letter.get_gid().removeprefix("letter:")
        middle = np.mean(letter.get_window_extent().get_points(), axis=0)
        place = letter.axes.transData.inverted().transform(middle)
        tips = {own: end[1] for own, end in ends.items() if own.startswith("frame:")}
        assert min(tips, key=lambda own: np.linalg.norm(place - tips[own])) == name
        if letter.get_position() == (0.0, 0.0):
            along = np.diff(ends[name], axis=0)[0]
            gap = place - ends[name][1]
            assert gap @ along >= 0.99 * np.linalg.norm(gap) * np.linalg.norm(along) > 0.0


@pytest.mark.parametrize("direction", np.linspace(0.0, 2.0 * np.pi, 25))
def test_a_name_stays_outside_of_the_circle_that_it_is_to_keep_clear_of(direction: float) -> None:
    half, clear = np.array([40.0, 6.0]), 10.0
    centre = TextBox(np.zeros(2), half, clear, 0.0).beside(direction, 0.0)
    gap = np.maximum(np.abs(centre) - half, 0.0)  # from the circle's middle to the box
    assert np.linalg.norm(gap) >= clear * (1.0 - 1e-9)  # but for rounding


WALL = np.array([[4.6, 0.0], [4.9, 0.0], [4.9, 10.0], [4.6, 10.0]])
FULL = np.array([[5.2, 0.0], [10.0, 0.0], [10.0, 10.0], [5.2, 10.0]])


@pytest.mark.parametrize(
    ("walls", "leaders"), [([FULL], 0), ([FULL, WALL], 1)], ids=["free", "behind a body"]
)
def test_a_name_behind_a_body_has_a_line_to_what_it_names(
    walls: list[np.ndarray], leaders: int
) -> None:
    figure = Figure(figsize=(4.0, 4.0))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0.0, 10.0), ylim=(0.0, 10.0))
    label = Label("rod", np.array([5.05, 5.0]), 0.05, {"fontsize": 8}, "name:link:rod", RED)
    Labeller(axes, [(wall, 5.0) for wall in walls]).place([label])
    assert axes.texts[0].get_window_extent().x1 < axes.transData.transform((5.2, 5.0))[0]
    assert len(axes.lines) == leaders


def test_a_body_covers_the_cells_inside_its_outline() -> None:
    figure = Figure(figsize=(3.0, 3.0), dpi=100)  # 100 cells of 3 pixels across
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0.0, 100.0), ylim=(0.0, 100.0))
    body = np.array([[10.2, 30.2], [19.8, 30.2], [19.8, 49.8], [10.2, 49.8]])
    grid = Labeller(axes, [(body, 5.0)]).grid
    expected = np.zeros((100, 100))
    expected[30:50, 10:20] = 5.0
    np.testing.assert_array_equal(grid, expected)


@pytest.mark.parametrize("reach", [3.0, 300.0])
def test_a_name_stands_on_no_outline_however_long_that_is(reach: float) -> None:
    """An edge passes where the name would best stand; the name takes the other side of it."""
    axes = Figure(figsize=(5, 5)).add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0.0, 10.0), ylim=(0.0, 10.0))
    edge = 5.25
    low, high = 5.0 - reach, 5.0 + reach
    body = np.array([[low, edge], [high, edge], [high, 4.0 * reach], [low, 4.0 * reach]])
    label = Label(
        "a longer name", np.array([5.0, 5.0]), 0.05, {"fontsize": 8}, "name:link:rod", RED
    )
    Labeller(axes, [(body, 0.0)]).place([label])  # its ground is no reason to stand elsewhere
    (text,) = axes.texts
    box = text.get_window_extent()
    low, high = axes.transData.inverted().transform([(0.0, box.y0), (0.0, box.y1)])[:, 1]
    assert not low < edge < high


@pytest.mark.parametrize("name", ["excavator", "forging_chu2020", "type_c", "type_d"])
def test_the_name_of_the_base_keeps_off_the_axis_of_the_column(name: str) -> None:
    robot = robot_of(name)
    figure = drawing_of(name, "all")
    (axes,) = figure.axes
    figure.canvas.draw()
    (name_of_base,) = artists_of(figure, Text, f"name:link:{robot.base_frame}")
    box = name_of_base.get_window_extent()
    dashed = [line for line in axes.lines if line.get_linestyle() not in ("-", "None")]
    assert dashed
    for line in dashed:
        ends = axes.transData.transform(line.get_xydata())[[0, -1]]
        assert not any_inside(box, np.linspace(*ends, 200))


def any_inside(box, points: np.ndarray) -> bool:
    """Whether any of points (k, 2) is inside a box."""
    inside = (points > (box.x0, box.y0)) & (points < (box.x1, box.y1))
    return bool(inside.all(axis=1).any())


CROWDED = ("ankle", "excavator", "gough", "palletizer", "staicu2015")


@pytest.mark.parametrize("name", swept(CROWDED, ("ankle", "excavator")))
def test_no_line_to_a_name_runs_under_another_name(name: str) -> None:
    figure = drawing_of(name, "all")
    (axes,) = figure.axes[:1]
    figure.canvas.draw()
    names = artists_of(figure, Text, "name:")
    leaders = [line for line in axes.lines if line.get_zorder() == 19]
    assert names
    for leader in leaders:
        ends = axes.transData.transform(leader.get_xydata())
        inner = np.linspace(*ends, 50)[:-2]  # its end touches its own name
        for name_ in names:
            assert not any_inside(name_.get_window_extent(), inner)


def test_scales_are_equal(robot: Robot) -> None:
    (axes,) = drawing_of(robot.name).axes
    corner, right, up = axes.transData.transform([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])
    assert right[0] - corner[0] == pytest.approx(up[1] - corner[1], rel=1e-9)


def test_the_same_robot_gives_the_same_file(
    robot: Robot, svg_of: Callable[[str], Path], tmp_path: Path
) -> None:
    other = tmp_path / "other.svg"
    draw(robot, path=other, skeleton=True)
    assert other.read_bytes() == svg_of(robot.name).read_bytes()


def test_a_png_is_written(forging: Robot, tmp_path) -> None:
    path = tmp_path / "robot.PNG"
    draw(forging, path=path)
    assert path.read_bytes().startswith(b"\x89PNG")


def test_a_robot_on_axes_of_a_larger_figure(forging: Robot) -> None:
    figure = Figure()
    beside, right = figure.subplots(1, 2)
    beside.plot([0, 1], [0, 1])
    draw_on(right, forging, forging.close(forging.reference), names="joints")
    assert set(forging.coordinates) <= {text.get_text() for text in right.texts}
    assert len(figure.texts) == 0
    assert not beside.texts


def test_a_state_moves_what_is_drawn(forging: Robot) -> None:
    middles = []
    for state in (None, forging.close([0.0, 0.15, 0.15, 0.0])):
        (end,) = artists_of(draw(forging, state), Polygon, "link:l42")
        middles.append(end.get_xy().mean(axis=0))
    assert np.abs(middles[0] - middles[1]).max() > 0.01


def bad_states(robot: Robot) -> list[tuple[ClosedState, str]]:
    u = robot.reference
    open_state = robot.close([0.0, 9.0, 0.1, 0.0], check=False)
    return [(robot.close(np.stack([u, u])), "one state"), (open_state, "not finite")]


def test_a_batch_and_an_open_state_are_refused(forging: Robot) -> None:
    for state, words in bad_states(forging):
        with pytest.raises(InputError, match=words):
            draw(forging, state)


def test_other_formats_and_unknown_choices_are_refused(forging: Robot, tmp_path) -> None:
    with pytest.raises(InputError, match=r"\.svg, \.png or \.pdf, not as '\.jpg'"):
        draw(forging, path=tmp_path / "robot.jpg")
    with pytest.raises(InputError, match="none of none, active, joints, all"):
        draw(forging, names="some")
    assert not list(tmp_path.iterdir())
