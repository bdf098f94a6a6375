"""Every drawing of random robots, turned so that axes are seen end-on."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon
from matplotlib.text import Annotation, Text

from hybrid_dynamics_core import Robot, load, shipped_robots
from hybrid_dynamics_core.drawing import (
    draw,
    draw_margins,
    draw_modes,
    draw_simulation,
    draw_workspace,
)
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.scene.part_style import IDLE
from hybrid_dynamics_core.scene.style import RED
from hybrid_dynamics_core.simulation import simulate
from tests.generated.case import Case
from tests.generated.class_three import class_three
from tests.generated.robots import examples, moved
from tests.sampling import swept

from .conftest import artists_of

AXES = ["x", "y", "z", "-x", "-y", "-z"]


@st.composite
def right_angled(draw_value: st.DrawFn) -> Robot:
    """Slides and hinges along the base axes in a row, some of them at one place, some idle."""
    count = draw_value(st.integers(1, 4))
    links, joints, names = ["base: {}"], [], []
    parent = "base"
    for k in range(count):
        kind = draw_value(st.sampled_from(["prismatic", "revolute"]))
        axis = draw_value(st.sampled_from(AXES))
        place = draw_value(st.lists(st.sampled_from([0.0, 0.3]), min_size=3, max_size=3))
        low, high = draw_value(st.sampled_from([(0.0, 1.0), (-1.0, 1.0)]))
        joints.append(
            f"q{k}: {{type: {kind}, parent: {parent}, child: l{k}, axis: {axis},"
            f" origin: {{xyz: {place}}}, limits: [{low}, {high}]}}"
        )
        parent = f"l{k}"
        links.append(f"{parent}: {{mass: 1, inertia: {{sphere: {{radius: 0.1}}}}}}")
        names.append(f"q{k}")
    idle = draw_value(st.integers(0, count - 1))
    driven = count - idle
    tool = draw_value(st.lists(st.sampled_from([0.0, 0.2]), min_size=3, max_size=3))
    text = "\n  ".join(["format: 1\nname: right_angled\nlinks:", *links])
    text += "\n" + "\n  ".join(["joints:", *joints])
    text += f"\nactive: [{', '.join(names[:driven])}]\nidle: [{', '.join(names[driven:])}]"
    text += f"\nend_effector: {{link: {parent}, xyz: {tool}}}\n"
    return Robot(parse_description(text))


def draw_all(robot: Robot) -> list[Figure]:
    """Every drawing that there is."""
    workspace = robot.workspace(60)
    motion = simulate(robot, robot.reference, t_span=(0.0, 0.01))
    figures = [draw(robot, names="all"), draw_workspace(robot, workspace)]
    if not robot.follows:  # else the search for all modes takes long
        figures.append(draw_modes(robot))
    figures.append(draw_simulation(robot, motion))
    if len(robot.active) > 1:
        figures.append(draw_margins(robot, (robot.active[0], robot.active[-1])))
    return figures


@examples(18)
@given(right_angled())
def test_slides_and_hinges_along_the_view(robot: Robot) -> None:
    assert all(figure.axes for figure in draw_all(robot))


@examples(4)
@given(class_three(max_links=4, max_loops=2), st.permutations([0, 1, 2]))
def test_robots_with_loops_turned_by_right_angles(case: Case, order: list[int]) -> None:
    rotation = np.eye(3)[order]
    turned = moved(case.description, np.linalg.det(rotation) * rotation, np.zeros(3))
    assert all(figure.axes for figure in draw_all(Robot(turned)))


@examples(12)
@given(right_angled())
def test_vermilion_is_what_is_driven_and_grey_what_is_idle(robot: Robot) -> None:
    figure = draw(robot)
    lines = artists_of(figure, Line2D, "drive:")
    arrows = {line.get_gid().removeprefix("drive:") for line in lines}
    assert {name.partition(".")[0] for name in arrows} == set(robot.drives)
    for patch in artists_of(figure, Polygon, "joint:"):
        name = patch.get_gid().removeprefix("joint:")
        if name in robot.active and robot.joint_types[name] == "revolute":
            colour = IDLE if name in robot.idle else RED
            assert to_hex(patch.get_facecolor()) == colour
    pills = {text.get_text(): text for text in artists_of(figure, Text, "name:")}
    for name in robot.drives:
        assert name in pills


def anchors_of(figure: Figure) -> dict[str, np.ndarray]:
    """What each name stands for [px]."""
    names = artists_of(figure, Annotation, "name:")
    return {text.get_gid(): text.axes.transData.transform(text.xy) for text in names}


@pytest.mark.parametrize("name", swept(shipped_robots(), ["gough", "staicu2015", "palletizer"]))
def test_names_stand_by_what_they_name(name: str) -> None:
    """Each is nearer to its own place than to that of another one, or a line leads to it."""
    figure = draw(load(name))
    figure.draw_without_rendering()
    anchors = anchors_of(figure)
    led = {line.get_gid().removeprefix("leader:") for line in artists_of(figure, Line2D, "leader:")}
    for text in artists_of(figure, Annotation, "name:"):
        box = text.get_window_extent()
        middle, half = box.get_points().mean(axis=0), np.array(box.size) / 2.0
        away: dict[str, float] = {}
        for gid, place in anchors.items():
            outside = np.maximum(np.abs(place - middle) - half, 0.0)
            away[gid] = float(np.linalg.norm(outside))
        own = text.get_gid()
        assert own in led or away[own] <= min(away.values()) + 6.0


def test_what_is_seen_edge_on_is_a_line() -> None:
    """With one of three slides held, two views show the square from its edges."""
    text = "format: 1\nname: gantry\nlinks: {base: {}, a: {mass: 1}, b: {mass: 1}, c: {mass: 1}}\n"
    text += "joints:\n"
    for name, parent, child in (("x", "base", "a"), ("y", "a", "b"), ("z", "b", "c")):
        text += f"  {name}: {{type: prismatic, parent: {parent}, child: {child}, axis: {name},"
        text += " limits: [0, 1]}\n"
    text += "active: [x, y, z]\nend_effector: {link: c}\n"
    robot = Robot(parse_description(text))
    figure = draw_workspace(robot, robot.workspace(200, held={"z": 0.5}))
    counts = []
    for axes in figure.axes[:3]:
        lines = [artist for artist in axes.collections if type(artist) is LineCollection]
        segments = [segment for line in lines for segment in line.get_segments()]
        counts.append(len(segments))
        assert all((segment[:, 1] == 0.5).all() for segment in segments)
    assert counts[0] > 100
    assert counts[1] > 100
    assert counts[2] == 0


def test_drawn_energies_add_up() -> None:
    robot = load("five_bar")
    motion = simulate(robot, robot.reference, t_span=(0.0, 0.1))
    axes = draw_simulation(robot, motion).axes[-1]
    curves = {line.get_label(): np.asarray(line.get_ydata(), float) for line in axes.lines}
    potential = curves["potential, from the start"]
    assert potential[0] == 0.0
    total = curves["kinetic"] + potential - curves["work of efforts and friction"]
    np.testing.assert_allclose(total, 0.0, atol=1e-4 * np.abs(potential).max())
