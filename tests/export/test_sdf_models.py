"""SDFormat files of several models: in each other, included, in worlds; and what holds them."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given

from hybrid_dynamics_core import DescriptionError, InputError, Robot, load
from hybrid_dynamics_core.description.geometry import rotation_about, unit_axis
from hybrid_dynamics_core.export import to_sdf
from tests.export.test_sdf_joints import BODY, legs, same
from tests.generated.case import Case
from tests.generated.robots import STATES, examples, robots
from tests.generated.test_closure_laws import close_to, margin

NESTED = "inner::"
LEG = """<joint name="b" type="revolute"><parent>leg</parent><child>platform</child>
<axis><xyz>0 1 0</xyz></axis></joint>"""


def read(folder: Path, text: str, **options: object) -> Robot:
    file = folder / "robot.sdf"
    file.write_text(text, encoding="utf-8")
    return load(file, **options)


def spread(text: str, folder: Path) -> tuple[str, str, str]:
    """The model of a file alone, inside another model, and included there from a folder."""
    model = ElementTree.fromstring(text).find(".//model")
    for child in list(model):
        if "hybrid_dynamics" in child.tag or child.tag == "pose":
            model.remove(child)
    model.set("name", "inner")
    words = ElementTree.tostring(model, encoding="unicode")
    alone = f'<sdf version="1.11">{words}</sdf>'
    beside = folder / "part"
    beside.mkdir()
    (beside / "model.sdf").write_text(alone.replace('name="inner"', 'name="part"', 1))
    opening, rest = words.split(">", 1)
    place = '<pose relative_to="f"/>'
    include = f"<include><uri>model://part</uri><name>inner</name>{place}</include>"
    around = '<sdf version="1.7"><model name="outer"><frame name="f"><pose>0.3 -0.2 0.1 0.4 0.5 0.6'
    around += "</pose></frame>INNER</model></sdf>"
    nested = around.replace("INNER", f"{opening}>{place}{rest}")
    return alone, nested, around.replace("INNER", include)


@examples(5)
@given(robots(), STATES)
def test_a_model_in_a_model_is_the_same_robot_on_another_base(case: Case, seed: int) -> None:
    """M-bar and the rates' forces are those of the model alone, whether nested or included."""
    text = to_sdf(case.robot)
    with tempfile.TemporaryDirectory() as folder:
        texts = spread(text, Path(folder))
        plain, inside, from_file = (read(Path(folder), text) for text in texts)
    names = [f"{NESTED}{name}" for name in plain.coordinates]
    assert list(inside.coordinates) == list(from_file.coordinates) == names
    rng = np.random.default_rng(seed)
    n = len(plain.active)
    u = plain.reference + 1e-3 * rng.uniform(-1, 1, n)  # loops may close in a narrow range
    du = rng.uniform(-1, 1, n)
    start = plain.close(u, du)
    m = margin(case, case.start)
    mass, rates, _ = plain.minimal_form(start)
    state = inside.close(u, du)
    assert close_to(start.s, state.s, 1e-9 / m)
    other_mass, other_rates, _ = inside.minimal_form(state)
    for one, two in ((mass, other_mass), (rates, other_rates)):
        assert close_to(one, two, 1e-9 / m**3 * max(1.0, abs(one).max()))
    for part in ("links", "joints", "frames", "effects"):
        one, two = vars(inside.description)[part], vars(from_file.description)[part]
        assert same(one, two)


def moved(text: str, old: str, new: str) -> str:
    assert old in text
    return text.replace(old, new, 1)


def test_a_model_is_placed_by_the_frame_that_it_names(tmp_path: Path) -> None:
    """By hand: the leg, 0.2 m above its model's origin, is what stands at the given pose."""
    inner = legs(LEG).split("\n", 1)[1]
    inner = inner[: inner.rindex("</sdf>")]
    inner = '<model name="rev" placement_frame="leg"><pose>1 2 3 0 0 0.5</pose>' + inner
    robot = read(tmp_path, f'<sdf version="1.9"><model name="outer">{inner}</model></sdf>')
    poses = [robot.forward_kinematics(robot.close([0, 0]), f"rev::{n}") for n in ("base", "leg")]
    assert poses[1].position - poses[0].position == pytest.approx([0, 0, 0.2], abs=1e-12)
    assert robot.description.base == "rev::base"
    weld = moved(inner, 'name="w" type="fixed"', 'name="w" type="revolute"')
    robot = read(tmp_path, f'<sdf version="1.9"><model name="outer">{weld}</model></sdf>')
    pose = robot.forward_kinematics(robot.close(np.zeros(3)), "rev::leg")
    assert pose.position == pytest.approx([1, 2, 3], abs=1e-12)
    assert pose.rotation == pytest.approx(rotation_about(unit_axis("z"), 0.5), abs=1e-12)


def test_what_is_merged_has_names_of_the_model_around_it(tmp_path: Path) -> None:
    part = tmp_path / "part"
    part.mkdir()
    (part / "arm.sdf").write_text(legs(LEG))
    (part / "model.config").write_text(
        '<model><sdf version="1.4">old.sdf</sdf><sdf version="1.9">arm.sdf</sdf></model>'
    )
    include = '<include merge="true"><uri>model://part</uri><pose>0 0 1 0 0 0</pose></include>'
    more = f"""<link name="hand"><pose relative_to="platform">0 0 0.1 0 0 0</pose>{BODY}</link>
<joint name="c" type="prismatic"><parent>platform</parent><child>hand</child>
<axis><xyz expressed_in="base">0 0 1</xyz></axis></joint>"""
    text = f'<sdf version="1.9"><model name="all">{include}{more}</model></sdf>'
    robot = read(tmp_path, text)
    assert robot.coordinates == ("a", "b", "c")
    pose = robot.forward_kinematics(robot.close([0, 0, 0.25]), "hand")
    assert pose.position == pytest.approx([0, 0, 0.4 + 0.1 + 0.25], abs=1e-12)


def world(*models: str) -> str:
    inner = "".join(text[text.index("<model") : text.index("</sdf>")] for text in models)
    return f'<sdf version="1.9"><world name="w"><gravity>0 0 -3</gravity>{inner}</world></sdf>'


def test_several_models_are_one_robot_or_one_is_named(tmp_path: Path) -> None:
    one, two = legs(LEG), legs(LEG).replace('"rev"', '"other"')
    still = '<model name="still"><static>1</static><link name="l"/></model></sdf>'
    assert read(tmp_path, world(one, still)).name == "rev"
    text = world(one, two, still)
    both = read(tmp_path, text)
    notes = "\n".join(both.description.notes)
    assert "2 models with joints (rev, other) are taken together as one robot" in notes
    assert "model still is static and carries nothing; left out" in notes
    without_world = text.replace('<world name="w">', "").replace("</world>", "")
    with pytest.raises(DescriptionError, match=r"2 models with joints \(rev, other\); name one"):
        read(tmp_path, without_world)
    tie = '<joint name="t" type="fixed"><parent>still::l</parent><child>rev</child></joint>'
    with pytest.raises(DescriptionError, match="<static> of <model> is '1'"):
        read(tmp_path, text.replace("</world>", f"{tie}</world>"))
    assert read(tmp_path, text, model="other").name == "other"
    with pytest.raises(InputError, match="has no model 'othe' \\(did you mean 'other'"):
        read(tmp_path, text, model="othe")
    whole = read(tmp_path, text, model="w")
    assert both.coordinates == whole.coordinates
    assert whole.coordinates == ("rev::a", "rev::b", "other::a", "other::b")
    alone = read(tmp_path, text, model="rev")
    mass = whole.minimal_form(whole.close([0.1, 0.2, 0.3, 0.4]))[0]
    assert mass[:2, :2] == pytest.approx(alone.minimal_form(alone.close([0.1, 0.2]))[0], rel=1e-12)
    assert not mass[:2, 2:].any()
    (tmp_path / "r.urdf").write_text("<robot name='r'/>")
    with pytest.raises(InputError, match="has one robot"):
        load(tmp_path / "r.urdf", model="r")


REACHES = {
    "fetched": ("https://fuel.gazebosim.org/1.0/x/models/y", "is not fetched"),
    "above": ("../../secret/model.sdf", "is not below"),
    "away": ("file:///etc/passwd", "is not below"),
    "named": ("model://etc/passwd", "there is no package 'etc'"),
    "no name": ("model://../x", "'..' is no name of a model"),
    "itself": ("robot.sdf", "includes robot.sdf in itself"),
    "a device": ("/dev/zero", "is not below"),
}


@pytest.mark.parametrize(("uri", "words"), REACHES.values(), ids=REACHES)
def test_an_include_reaches_no_further_than_the_folder(
    uri: str, words: str, tmp_path: Path
) -> None:
    text = legs(LEG).replace("<link", f"<include><uri>{uri}</uri></include><link", 1)
    with pytest.raises(DescriptionError, match=words.replace(".", r"\.")) as caught:
        read(tmp_path, text)
    assert caught.value.line == 2


def test_includes_that_double_are_stopped(tmp_path: Path) -> None:
    """Each of thirty files includes the next one twice: 2^30 models."""
    for k in range(30):
        two = "".join(
            f"<include><uri>m{k + 1}.sdf</uri><name>{name}</name></include>" for name in "ab"
        )
        text = f'<sdf version="1.9"><model name="m">{two}<link name="l"/></model></sdf>'
        (tmp_path / f"m{k}.sdf").write_text(text)
    (tmp_path / "m30.sdf").write_text('<sdf version="1.9"><model name="m"/></sdf>')
    with pytest.raises(DescriptionError, match="more than 500 files"):
        load(tmp_path / "m0.sdf")


def test_what_a_world_includes_beside_its_robot_is_noted(tmp_path: Path) -> None:
    ground = "<include><uri>model://ground_plane</uri></include>"
    text = world(legs(LEG)).replace("<model", f"{ground}<model", 1)
    robot = read(tmp_path, text)
    assert robot.description.gravity == pytest.approx([0, 0, -3])
    assert any(
        "<include> is left out: 'model://ground_plane'" in n for n in robot.description.notes
    )


def test_before_1_7_a_link_and_a_joint_may_share_a_name(tmp_path: Path) -> None:
    text = legs(LEG.replace('name="b"', 'name="platform"')).replace("1.9", "1.6")
    same, other = read(tmp_path, text), read(tmp_path, legs(LEG).replace("1.9", "1.6"))
    assert same.coordinates == ("a", "platform")
    poses = [
        robot.forward_kinematics(robot.close([0.2, 0.3]), "platform") for robot in (same, other)
    ]
    assert poses[0].position == pytest.approx(poses[1].position, abs=1e-15)


def test_limits_that_leave_one_place_hold_a_joint_there(tmp_path: Path) -> None:
    limit = "<limit><lower>{0}</lower><upper>{0}</upper></limit></axis></joint>"
    for place in (0.0, 0.4):
        for ends in (("leg", "platform"), ("platform", "leg")):
            text = LEG.replace("</axis></joint>", limit.format(place))
            text = text.replace("<parent>leg", f"<parent>{ends[0]}")
            text = text.replace("<child>platform", f"<child>{ends[1]}")
            free = read(tmp_path, legs(text.replace(f"<lower>{place}", "<lower>-9")))
            held = read(tmp_path, legs(text))
            assert held.coordinates == ("a",)
            pose = held.forward_kinematics(held.close([0.3]), "platform")
            expected = free.forward_kinematics(free.close([0.3, place]), "platform")
            assert pose.position == pytest.approx(expected.position, abs=1e-12)
            assert pose.rotation == pytest.approx(expected.rotation, abs=1e-12)
            words = "robot.sdf:8: joint b is held by its limits; taken as fixed"
            assert words in held.description.notes


def test_a_slide_closes_a_loop_with_its_friction_and_limits(tmp_path: Path) -> None:
    """A slider-crank, crank 0.3 m, rod 0.5 m: x = r cos u + sqrt(l^2 - r^2 sin^2 u)."""
    joint = '<joint name="{}" type="{}"><parent>{}</parent><child>{}</child><axis><xyz>{}</xyz>'
    slide = joint.format("s", "prismatic", "base", "slider", "1 0 0")
    slide += "<dynamics><damping>2</damping></dynamics></axis></joint>"
    hinges = ("k", "base", "crank"), ("r", "crank", "rod"), ("p", "rod", "slider")
    turning = "<dynamics><damping>0.5</damping></dynamics></axis></joint>"
    joints = slide
    for name, parent, child in hinges:
        joints += joint.format(name, "revolute", parent, child, "0 0 1") + turning
    links = f'<link name="base">{BODY}</link>'
    for name, x in (("slider", 0.8), ("crank", 0.0), ("rod", 0.3)):
        links += f'<link name="{name}"><pose>{x} 0 0 0 0 0</pose>{BODY}</link>'
    weld = '<joint name="w" type="fixed"><parent>world</parent><child>base</child></joint>'
    robot = read(
        tmp_path, f'<sdf version="1.9"><model name="m">{links}{weld}{joints}</model></sdf>'
    )
    (name,) = robot.active
    u, r, long = 0.4, 0.3, 0.5
    x = r * math.cos(u) + math.sqrt(long**2 - (r * math.sin(u)) ** 2)
    given = {"k": u, "s": x - 0.8}[name]
    state = robot.close([given])
    pose = robot.forward_kinematics(state, "slider")
    assert pose.position == pytest.approx([x, 0, 0], abs=1e-9)
    assert robot.description.effects["s"].viscous == 2.0


def test_gravity_of_no_link_is_no_gravity(tmp_path: Path) -> None:
    text = legs(LEG)
    for name in ("leg", "platform"):
        text = text.replace(f'<link name="{name}">', f'<link name="{name}"><gravity>0</gravity>')
    assert not read(tmp_path, text).description.gravity.any()


def test_comments_and_declarations_of_other_parsers_pass(tmp_path: Path) -> None:
    text = "\n\n<?xml version='1.0'?>\n<!-- a -- b --- -->" + legs(LEG)
    assert read(tmp_path, text).coordinates == ("a", "b")
    wrong = text.replace("<parent>leg", "<parent>lag")
    with pytest.raises(DescriptionError, match="'lag'") as caught:
        read(tmp_path, wrong)
    assert caught.value.line == wrong[: wrong.index('name="b"')].count("\n") + 1
