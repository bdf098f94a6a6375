"""What ties or loads joints of SDFormat, and what older and other files say in their words."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from hybrid_dynamics_core import DescriptionError, Robot, load
from hybrid_dynamics_core.export import to_sdf

INERTIAL = (
    "<inertial><pose>0.1 0.05 0 0 0 0</pose><mass>2</mass>"
    "<inertia><ixx>0.02</ixx><iyy>0.03</iyy><izz>0.04</izz></inertia></inertial>"
)
HINGES = f"""<link name="base"/><joint name="w" type="fixed"><parent>world</parent>
<child>base</child></joint>
<link name="wheel"><pose>0.3 0 0 0 0 0.4</pose>{INERTIAL}</link>
<link name="arm"><pose>-0.2 0 0.1 0.2 0 0</pose>{INERTIAL}</link>
<joint name="p" type="revolute"><parent>base</parent><child>wheel</child>
<axis><xyz expressed_in="__model__">1 0 0</xyz></axis></joint>
<joint name="q" type="revolute"><pose relative_to="arm"/>
<parent>{{ends[0]}}</parent><child>{{ends[1]}}</child>
<axis><xyz expressed_in="__model__">0 -1 0</xyz></axis></joint>"""
GEARBOX = """<joint name="g" type="gearbox"><parent>wheel</parent><child>arm</child>
<gearbox_reference_body>base</gearbox_reference_body><gearbox_ratio>{ratio}</gearbox_ratio>
<axis><xyz expressed_in="__model__">1 0 0</xyz></axis>
<axis2><xyz expressed_in="__model__">0 1 0</xyz></axis2></joint>"""


def model(inside: str, version: str = "1.9") -> str:
    return f'<sdf version="{version}"><model name="m">{inside}</model></sdf>'


def read(folder: Path, text: str) -> Robot:
    file = folder / "model.sdf"
    file.write_text(text, encoding="utf-8")
    return load(file)


TWIN = """<mujoco><compiler angle="radian" eulerseq="XYZ"/><worldbody>
<body pos=".3 0 0" euler="0 0 .4"><joint name="p" axis="{p}"/>
<inertial pos=".1 .05 0" mass="2" diaginertia=".02 .03 .04"/></body>
<body pos="-.2 0 .1" euler=".2 0 0"><joint name="q" axis="{q}"/>
<inertial pos=".1 .05 0" mass="2" diaginertia=".02 .03 .04"/></body></worldbody>
<equality><joint joint1="q" joint2="p" polycoef="0 {multiplier}"/></equality></mujoco>"""


@pytest.mark.parametrize("is_turned", [False, True])
@pytest.mark.parametrize("ratio", [0.5, -3.0])
def test_a_gearbox_is_a_coupling_of_mujoco(ratio: float, is_turned: bool, tmp_path: Path) -> None:
    """theta_2 = -ratio theta_1; the arm's hinge turns against <axis2>, or is written backwards."""
    ends = ("arm", "base") if is_turned else ("base", "arm")
    text = model(HINGES.format(ends=ends) + GEARBOX.format(ratio=ratio))
    robot = read(tmp_path, text)
    assert robot.active == ("p",)
    about = np.array([0.0, 1.0, 0.0]) if is_turned else np.array([0.0, -1.0, 0.0])
    multiplier = -ratio if is_turned else ratio
    in_wheel = [np.cos(0.4), -np.sin(0.4), 0.0]
    in_arm = [0.0, about[1] * np.cos(0.2), -about[1] * np.sin(0.2)]
    axes = {
        "p": " ".join(map(str, in_wheel)),
        "q": " ".join(map(str, in_arm)),
        "multiplier": multiplier,
    }
    twin = mujoco.MjModel.from_xml_string(TWIN.format(**axes))
    data = mujoco.MjData(twin)
    state = robot.close([0.3], [0.7])
    s = dict(zip(robot.coordinates, state.s, strict=True))
    data.qpos[:] = [s["p"], s["q"]]
    assert s["q"] == pytest.approx(multiplier * s["p"], rel=1e-14)
    to_u = np.array([1.0, multiplier])
    data.qvel[:] = 0.7 * to_u
    mujoco.mj_forward(twin, data)
    mass = np.zeros((2, 2))
    mujoco.mj_fullM(twin, data, mass)
    assert robot.minimal_form(state)[0][0] == pytest.approx([to_u @ mass @ to_u], rel=1e-9)
    expected = to_u @ (mass @ to_u * 1.5 + data.qfrc_bias)
    assert robot.inverse_dynamics(state, [1.5]) == pytest.approx([expected], rel=1e-9)
    file = tmp_path / "back.sdf"
    file.write_text(to_sdf(robot), encoding="utf-8")
    assert load(file).inverse_dynamics(load(file).close([0.3], [0.7]), [1.5]) == pytest.approx(
        [expected], rel=1e-9
    )


WRONG_GEARS = {
    "no reference": ("<gearbox_reference_body>base</gearbox_reference_body>", "", "has no <gear"),
    "no hinge": (
        "<gearbox_reference_body>base",
        "<gearbox_reference_body>wheel",
        "expected a hinge about its <axis>",
    ),
    "another axis": ('"__model__">0 1 0</xyz></axis2>', '"__model__">0 1 1</xyz></axis2>', "axis2"),
    "ratio": ("<gearbox_ratio>2<", "<gearbox_ratio>0<", "has a ratio of 0"),
    "friction": ("</axis2>", "</axis2>", "has friction; give it to a hinge"),
}


@pytest.mark.parametrize(("old", "new", "words"), WRONG_GEARS.values(), ids=WRONG_GEARS.keys())
def test_a_gearbox_without_hinges_is_refused(
    old: str, new: str, words: str, tmp_path: Path
) -> None:
    gearbox = GEARBOX.format(ratio=2).replace(old, new)
    if "friction" in words:
        friction = "<dynamics><friction>1</friction></dynamics></axis>"
        gearbox = gearbox.replace("</axis>", friction)
    text = model(HINGES.format(ends=("base", "arm")) + gearbox)
    with pytest.raises(DescriptionError, match=r"joints\.g: ") as error:
        read(tmp_path, text)
    assert words in str(error.value)
    assert error.value.line == 9


# -- damping of ball joints

BALL = """<link name="base"/><joint name="w" type="fixed"><parent>world</parent>
<child>base</child></joint><link name="bob"><pose>0.1 0 0.2 0 0 0</pose>{inertial}</link>
<joint name="b" type="ball"><pose>0 0 0.1 0.3 0.2 0.1</pose><parent>{ends[0]}</parent>
<child>{ends[1]}</child><axis><dynamics><damping>0.7</damping></dynamics></axis></joint>"""


@pytest.mark.parametrize("ends", [("base", "bob"), ("bob", "base")])
def test_damping_of_a_ball_takes_the_power_of_its_angular_velocity(ends, tmp_path: Path) -> None:
    """Whatever the angles are: d times the square of the angular velocity."""
    text = model(BALL.format(inertial=INERTIAL, ends=ends))
    damped = read(tmp_path, text)
    plain = read(tmp_path, text.replace("0.7<", "0<"))
    rng = np.random.default_rng(2)
    for _ in range(4):
        u, du = rng.uniform(-1.2, 1.2, (2, 3))
        state = damped.close(u, du)
        taken = damped.inverse_dynamics(state, np.zeros(3))
        taken = taken - plain.inverse_dynamics(plain.close(u, du), np.zeros(3))
        turning = damped.joint_twist(state, "b")
        assert du @ taken == pytest.approx(0.7 * turning @ turning, rel=1e-9)


def test_damping_of_a_ball_that_closes_a_loop(tmp_path: Path) -> None:
    """Two pendulums on parallel axes, and a rod between them."""
    damping = "<dynamics><damping>0.1</damping></dynamics>"  # so no closure stands for it
    rod = f"""<link name="base"/><joint name="w" type="fixed"><parent>world</parent>
<child>base</child></joint><link name="l">{INERTIAL}</link>
<link name="r"><pose>0.3 1 0 0 0 0</pose>{INERTIAL}</link>
<link name="rod"><pose>0.5 0 0 0 0 0</pose>
{INERTIAL}</link><joint name="p" type="revolute"><parent>base</parent><child>l</child>
<axis><xyz>0 1 0</xyz>{damping}</axis></joint><joint name="q" type="revolute"><parent>base</parent>
<child>r</child><axis><xyz>0 1 0</xyz>{damping}</axis></joint>
<joint name="one" type="universal"><parent>l</parent><child>rod</child>
<axis><xyz>1 0 0</xyz>{damping}</axis>
<axis2><xyz>0 0 1</xyz>{damping}</axis2></joint>
<joint name="two" type="ball"><pose>0.3 1 0.2 0 0 0</pose>
<parent>r</parent><child>rod</child>
<axis><dynamics><damping>0.7</damping></dynamics></axis></joint>"""
    damped = read(tmp_path, model(rod))
    assert damped.description.multi_dof["two"].type == "ball"
    assert "two" in [closure.name for closure in damped.description.closures]
    n = len(damped.active)
    state = damped.close(damped.reference + 0.1, np.ones(n))
    names = damped.coordinates
    viscous = [0.0 if name.startswith("two_") else 0.1 for name in names]
    still = damped.loads.with_effects(viscous=viscous)
    taken = damped.inverse_dynamics(state, np.zeros(n))
    taken = taken - damped.inverse_dynamics(state, np.zeros(n), still)
    turning = damped.joint_twist(state, "two")
    assert state.du @ taken == pytest.approx(0.7 * turning @ turning, rel=1e-9, abs=1e-12)


# -- other words


def test_version_1_2_is_1_3_with_another_root(tmp_path: Path) -> None:
    text = to_sdf(read(tmp_path, model(BALL.format(inertial=INERTIAL, ends=("base", "bob")))))
    assert "1.11" in text
    older = model(BALL.format(inertial=INERTIAL, ends=("base", "bob")), "1.2")
    older = older.replace("<sdf ", "<gazebo ").replace("</sdf>", "</gazebo>")
    newer = older.replace("gazebo", "sdf").replace("1.2", "1.3")
    one, other = read(tmp_path, older), read(tmp_path, newer)
    u, du, ddu = np.random.default_rng(0).uniform(-1, 1, (3, 3))
    efforts = [r.inverse_dynamics(r.close(u, du), ddu) for r in (one, other)]
    assert efforts[0] == pytest.approx(efforts[1], rel=1e-15)


def test_a_fixed_joint_that_says_it_again_is_left_out(tmp_path: Path) -> None:
    again = """<joint name="again" type="fixed"><pose>0 1 0 0 0 0</pose><parent>base</parent>
<child>plate</child></joint>"""
    plate = f"""<link name="plate">{INERTIAL}</link><joint name="first" type="fixed">
<parent>base</parent><child>plate</child></joint>"""
    robot = read(tmp_path, model(HINGES.format(ends=("base", "arm")) + plate + again))
    assert not robot.description.closures
    note = "joint again is left out: nothing moves between its ends"
    assert any(note in text for text in robot.description.notes)


def test_drakes_weld_closes_a_loop_between_frames(tmp_path: Path) -> None:
    """A four-bar whose coupler is welded of two halves; as the same with a fixed joint."""
    bars = ""
    for name, place, parent in (("a", "0 0 0", "base"), ("c", "1 0 0", "base")):
        bars += f"""<link name="{name}"><pose>{place} 0 0 0.9</pose>{INERTIAL}</link>
<joint name="{name}_hinge" type="revolute"><parent>{parent}</parent><child>{name}</child>
<axis><xyz>0 0 1</xyz></axis></joint><link name="{name}_half">
<pose relative_to="{name}">0.6 0 0 0 0 -0.9</pose>{INERTIAL}</link><joint name="{name}_pin"
type="revolute"><parent>{name}</parent><child>{name}_half</child><axis><xyz>0 0 1</xyz></axis>
</joint>"""
    base = """<link name="base"/><joint name="w" type="fixed"><parent>world</parent>
<child>base</child></joint>"""
    frame = '<frame name="f" attached_to="a_half"><pose>1 0 0 0 0 0</pose></frame>'
    weld = "<drake:weld_constraint><parent>f</parent><child>c_half</child></drake:weld_constraint>"
    fixed = """<joint name="k" type="fixed"><parent>a_half</parent><child>c_half</child></joint>"""
    text = model(f"{base}{bars}{frame}{weld}").replace("<sdf ", '<sdf xmlns:drake="drake" ')
    one, other = read(tmp_path, text), read(tmp_path, model(f"{base}{bars}{fixed}"))
    assert one.active == other.active == ("a_hinge",)
    states = [robot.close([0.2], [1.0]) for robot in (one, other)]
    efforts = [one.inverse_dynamics(states[0], [0.5]), other.inverse_dynamics(states[1], [0.5])]
    assert efforts[0] == pytest.approx(efforts[1], rel=1e-9)


def test_a_link_called_world_is_refused(tmp_path: Path) -> None:
    """It is not the world, with which a search for the tree would not end."""
    text = """<link name="world"/><link name="l"/><joint name="j" type="revolute"><parent>l</parent>
<child>world</child><axis><xyz>0 0 1</xyz></axis></joint>"""
    with pytest.raises(DescriptionError, match="world"):
        read(tmp_path, model(text, "1.5"))


# -- masses of collisions

SOLIDS = {
    "<box><size>0.1 0.2 0.3</size></box>": ("box", [0.05, 0.1, 0.15]),
    "<sphere><radius>0.2</radius></sphere>": ("sphere", [0.2]),
    "<cylinder><radius>0.1</radius><length>0.5</length></cylinder>": ("cylinder", [0.1, 0.25]),
    "<capsule><radius>0.1</radius><length>0.5</length></capsule>": ("capsule", [0.1, 0.25]),
    "<ellipsoid><radii>0.1 0.2 0.3</radii></ellipsoid>": ("ellipsoid", [0.1, 0.2, 0.3]),
}


def solid_link(shape: str, words: str = "") -> str:
    """Two solids on a link, one of a density of its own."""
    return f"""<link name="base"/><joint name="w" type="fixed"><parent>world</parent>
<child>base</child></joint><link name="l"><inertial auto="true">{words}<density>700</density>
</inertial><collision name="a"><pose>0.1 0.2 0.3 0.4 0.5 0.6</pose><geometry>{shape}</geometry>
</collision><collision name="b"><density>200</density><pose degrees="true">0 0 0.4 90 0 0</pose>
<geometry><box><size>0.1 0.1 0.4</size></box></geometry></collision></link>
<joint name="q" type="revolute"><parent>base</parent><child>l</child><axis><xyz>0 1 0</xyz></axis>
</joint>"""


@pytest.mark.parametrize("shape", SOLIDS)
def test_collisions_give_the_mass_that_mujoco_gives_to_solids(shape: str, tmp_path: Path) -> None:
    link = read(tmp_path, model(solid_link(shape), "1.11")).description.links["l"]
    kind, sizes = SOLIDS[shape]
    twin = mujoco.MjModel.from_xml_string(f"""<mujoco>
<compiler angle="radian" eulerseq="XYZ"/><worldbody><body name="l"><joint axis="0 1 0"/>
<geom type="{kind}" size="{" ".join(map(str, sizes))}" density="700" pos=".1 .2 .3"
euler=".4 .5 .6"/><geom type="box" size=".05 .05 .2" density="200" pos="0 0 .4"
euler="{np.pi / 2} 0 0"/></body></worldbody></mujoco>""")
    assert link.mass == pytest.approx(twin.body_mass[1], rel=1e-9)
    assert link.com == pytest.approx(twin.body_ipos[1], abs=1e-9)
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, twin.body_iquat[1])
    turn = turn.reshape(3, 3)
    inertia = turn @ np.diag(twin.body_inertia[1]) @ turn.T
    assert link.inertia == pytest.approx(inertia, rel=1e-8, abs=1e-9)


BOX = next(iter(SOLIDS))
NO_MASS = {
    "a mass too": (solid_link(BOX, "<mass>2</mass>"), 'has auto="true" and a <mass>'),
    "another shape": (
        solid_link("<mesh><uri>m.dae</uri></mesh>"),
        "has the shape <mesh>; a mass is computed of box",
    ),
    "no density": (solid_link(BOX).replace("200", "0"), "has a density of 0"),
    "no size": (solid_link(BOX.replace("0.3", "-0.3")), "a size is above zero"),
}


@pytest.mark.parametrize(("inside", "words"), NO_MASS.values(), ids=NO_MASS.keys())
def test_a_mass_that_is_not_computed_is_refused(inside: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match=r"links\.l") as error:
        read(tmp_path, model(inside, "1.11"))
    assert words in str(error.value)
    assert error.value.line in (2, 3, 4)
