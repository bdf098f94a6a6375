"""What a drawing holds: every link, joint, loop and active name, in both formats."""

import re
from itertools import combinations
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
from hybrid_dynamics_core.scene.style import RED

from .conftest import drawing_of, robot_of


def gids(figure: Figure) -> set[str]:
    return {artist.get_gid() for artist in figure.findobj() if artist.get_gid()}


def owners(found: set[str], kind: str) -> set[str]:
    """Names with artists of their own; several that are drawn as one are joined by +."""
    joined = [gid.removeprefix(f"{kind}:") for gid in found if gid.startswith(f"{kind}:")]
    return {name for part in joined for name in part.split("+")}


def labels(figure: Figure) -> set[str]:
    found = [
        artist for artist in figure.findobj(Text) if (artist.get_gid() or "").startswith("name:")
    ]
    return {name for artist in found for name in artist.get_text().split(", ")}


def test_every_link_joint_and_closure_has_its_artist(robot: Robot) -> None:
    found = gids(drawing_of(robot.name))
    assert owners(found, "link") >= {robot.base_frame, *robot.description.links}
    assert owners(found, "joint") >= set(robot.coordinates)
    assert owners(found, "closure") >= {closure.name for closure in robot.description.closures}


def test_the_svg_holds_them_by_name_and_the_active_names_as_text(robot: Robot, tmp_path) -> None:
    path = tmp_path / "robot.svg"
    draw(robot, path=path)
    tree = ElementTree.parse(path)
    ids = {element.get("id") for element in tree.iter() if element.get("id")}
    written = {
        "".join(element.itertext()).strip()
        for element in tree.iter()
        if element.tag.endswith("}text")
    }
    assert owners(ids, "link") >= {robot.base_frame, *robot.description.links}
    assert owners(ids, "joint") >= set(robot.coordinates)
    assert written >= {*robot.active, robot.end_effector, robot.name}
    for closure in robot.description.closures:
        assert any(text.startswith(f"{closure.name}: ") for text in written), closure.name


def test_names_are_shown_as_asked(robot: Robot) -> None:
    shown = {names: labels(draw(robot, names=names)) for names in ("none", "joints", "all")}
    shown["active"] = labels(drawing_of(robot.name))
    assert shown["none"] == set()
    assert shown["active"] == {*robot.active, robot.end_effector}
    assert shown["joints"] == {*robot.coordinates, robot.end_effector}
    assert shown["all"] > shown["joints"]
    assert shown["all"] <= {*robot.coordinates, *robot.frames, robot.base_frame}


def test_the_base_is_named_among_the_links(robot: Robot) -> None:
    assert robot.base_frame in labels(draw(robot, names="all"))


@pytest.mark.parametrize(("name", "which"), [("five_bar", "the"), ("excavator", "each")])
def test_the_pin_of_the_key_looks_as_the_pins_of_the_picture(name: str, which: str) -> None:
    figure = draw(robot_of(name))
    (handle,) = (
        handle
        for legend in figure.legends
        for handle, text in zip(legend.legend_handles, legend.get_texts(), strict=True)
        if text.get_text() == f"pin that closes {which} loop"
    )
    closures = {f"closure:{closure.name}" for closure in robot_of(name).description.closures}
    edges = {
        to_hex(artist.get_edgecolor())
        for artist in figure.findobj(Polygon)
        if artist.get_gid() in closures
    }
    assert to_hex(handle.get_markeredgecolor()) in edges


def test_active_joints_and_no_others_have_the_colour_of_drives(robot: Robot) -> None:
    figure = drawing_of(robot.name)
    red = {
        re.sub(r"\.\d+$", "", patch.get_gid()).removeprefix("joint:")
        for patch in figure.findobj(Polygon)
        if (patch.get_gid() or "").startswith("joint:") and to_hex(patch.get_facecolor()) == RED
    }
    assert red == set(robot.active)
    assert owners(gids(figure), "drive") == {
        *robot.active,
        *(f"{name}.head" for name in robot.active),
    } | {f"{name}.head.2" for name in robot.active if robot.joint_types[name] == "prismatic"}


def test_names_of_active_joints_do_not_hide_each_other(robot: Robot) -> None:
    figure = drawing_of(robot.name)
    named = [
        artist for artist in figure.findobj(Text) if (artist.get_gid() or "").startswith("name:")
    ]
    assert len(named) == len(robot.active) + 1
    boxes = [label.get_window_extent() for label in named]
    for one, other in combinations(boxes, 2):
        assert not one.overlaps(other)
    for box in boxes:
        assert np.all(figure.bbox.min <= box.min)
        assert np.all(box.max <= figure.bbox.max)


def test_letters_of_axes_stand_on_no_joint_and_no_arrow(robot: Robot) -> None:
    figure = drawing_of(robot.name)
    letters = [
        artist for artist in figure.findobj(Text) if (artist.get_gid() or "").startswith("letter:")
    ]
    assert (
        len(letters) >= 2
    )  # of the end effector's frame; an axis along the view has a mark instead
    symbols = [
        patch
        for patch in figure.findobj(Polygon)
        if (patch.get_gid() or "").startswith(("joint:", "drive:"))
    ]
    for letter in letters:
        middle = np.mean(letter.get_window_extent().get_points(), axis=0)
        for symbol in symbols:
            assert (
                not symbol.get_path().transformed(symbol.get_transform()).contains_point(middle)
            ), symbol.get_gid()


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


@pytest.mark.parametrize("reach", [3.0, 300.0])
def test_a_name_stands_on_no_outline_however_long_that_is(reach: float) -> None:
    """A straight edge passes where the name would best stand.

    The name takes the other side of it.
    """
    axes = Figure(figsize=(5, 5)).add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0.0, 10.0), ylim=(0.0, 10.0))
    edge = 5.25
    body = np.array(
        [
            [5.0 - reach, edge],
            [5.0 + reach, edge],
            [5.0 + reach, 4.0 * reach],
            [5.0 - reach, 4.0 * reach],
        ]
    )
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
    figure = draw(robot, names="all")
    (axes,) = figure.axes
    figure.canvas.draw()
    (box,) = (
        t.get_window_extent() for t in axes.texts if t.get_gid() == f"name:link:{robot.base_frame}"
    )
    dashed = [line for line in axes.lines if line.get_linestyle() not in ("-", "None")]
    assert dashed
    for line in dashed:
        along = np.linspace(*axes.transData.transform(line.get_xydata())[[0, -1]], 200)
        assert not ((along > (box.x0, box.y0)) & (along < (box.x1, box.y1))).all(axis=1).any()


@pytest.mark.parametrize("name", ["ankle", "excavator", "gough", "palletizer", "staicu2015"])
def test_no_line_to_a_name_runs_under_another_name(name: str) -> None:
    figure = draw(robot_of(name), names="all")
    (axes,) = figure.axes[:1]
    figure.canvas.draw()
    names = [text for text in axes.texts if (text.get_gid() or "").startswith("name:")]
    leaders = [
        axes.transData.transform(line.get_xydata())
        for line in axes.lines
        if line.get_zorder() == 19
    ]
    assert names
    for ends in leaders:
        inner = np.linspace(*ends, 50)[:-2]  # its end touches its own name
        for box in (text.get_window_extent() for text in names):
            assert not ((inner > (box.x0, box.y0)) & (inner < (box.x1, box.y1))).all(axis=1).any()


def test_scales_are_equal(robot: Robot) -> None:
    (axes,) = drawing_of(robot.name).axes
    corner, right, up = axes.transData.transform([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])
    assert right[0] - corner[0] == pytest.approx(up[1] - corner[1], rel=1e-9)


def test_the_same_robot_gives_the_same_file(robot: Robot, tmp_path) -> None:
    files = [tmp_path / name for name in ("one.svg", "two.svg")]
    for file in files:
        draw(robot, path=file)
    assert files[0].read_bytes() == files[1].read_bytes()


def test_a_png_is_written(forging: Robot, tmp_path) -> None:
    path = tmp_path / "robot.PNG"
    draw(forging, path=path)
    assert path.read_bytes().startswith(b"\x89PNG")


def test_a_robot_on_axes_of_a_larger_figure(forging: Robot) -> None:
    figure = Figure()
    left, right = figure.subplots(1, 2)
    left.plot([0, 1], [0, 1])
    draw_on(right, forging, forging.close(forging.reference), names="joints")
    assert set(forging.coordinates) <= {text.get_text() for text in right.texts}
    assert len(figure.texts) == 0
    assert not left.texts


def test_a_state_moves_what_is_drawn(forging: Robot) -> None:
    figures = [draw(forging), draw(forging, forging.close([0.0, 0.15, 0.15, 0.0]))]
    ends = [next(a for a in f.findobj() if a.get_gid() == "link:l42").get_xy() for f in figures]
    assert np.abs(ends[0].mean(axis=0) - ends[1].mean(axis=0)).max() > 0.01


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
