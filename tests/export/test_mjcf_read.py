"""MJCF comes back as this library writes it; everything else is refused with its line."""

from __future__ import annotations

from pathlib import Path

import pytest

from hybrid_dynamics_core import DescriptionError, Robot, load

PENDULUM = """<mujoco model="pendulum">
  <compiler angle="radian"/>
  <option gravity="0 0 -3.7"/>
  <worldbody>
    <site name="mark" pos="1 2 3"/>
    <body name="bob" pos="0 0 1" quat="0.7071067811865476 0.7071067811865476 0 0">
      <inertial pos="0.5 0 0" mass="2" diaginertia="0.1 0.2 0.2"/>
      <joint name="q" type="hinge" axis="0 0 2" range="-1 2" limited="true"
        damping="0.3" armature="0.5"/>
      <geom type="sphere" size="0.1" mass="0"/>
      <body name="tip" pos="1 0 0"/>
    </body>
  </worldbody>
  <actuator><motor name="q" joint="q"/></actuator>
</mujoco>
"""


def read(folder: Path, text: str) -> Robot:
    path = folder / "model.xml"
    path.write_text(text, encoding="utf-8")
    return load(path)


def test_the_words_it_writes_are_enough(tmp_path: Path) -> None:
    machine = read(tmp_path, PENDULUM)
    assert (machine.name, machine.active, machine.description.base) == ("pendulum", ("q",), "world")
    assert machine.limits[0] == pytest.approx([-1, 2])
    assert machine.description.gravity == pytest.approx([0, 0, -3.7])
    state = machine.close([0.4])
    held = machine.inverse_dynamics(state, [0.0])
    assert held == pytest.approx(
        [2 * 3.7 * 0.5 * 0.9210609940028851]
    )  # m g r cos(0.4): the hinge lies level
    pushed = machine.inverse_dynamics(state, [1.0])
    assert pushed - held == pytest.approx(
        [0.2 + 2 * 0.25 + 0.5]
    )  # the bob about its hinge, and the rotor
    assert machine.forward_kinematics(state, "tip").position == pytest.approx(
        [0.921061, 0, 1.389418], abs=1e-6
    )
    assert machine.forward_kinematics(state, "mark").position == pytest.approx([1, 2, 3])


WRONG = {
    "degrees": ('angle="radian"', 'angle="degree"', "counts angles in degrees", 1),
    "defaults": ("<worldbody>", "<default/><worldbody>", "<default> is not covered", 4),
    "free": (
        '<joint name="q" type="hinge"',
        '<joint name="q" type="free"',
        "is 'free'; expected hinge or slide",
        8,
    ),
    "mass of shapes": ('size="0.1" mass="0"', 'size="0.1"', "a <geom> makes up mass", 10),
    "angles": (
        '<body name="tip" pos="1 0 0"/>',
        '<body name="tip" euler="1 0 0"/>',
        "is turned by euler; expected quat",
        11,
    ),
    "offset": ('damping="0.3"', 'ref="0.3"', "ref of <joint> is not covered", 8),
    "two joints": ("<geom ", '<joint name="p"/><geom ', "body 'bob' has 2 joints", 10),
    "position drive": (
        "<motor ",
        "<position ",
        "<position> is not covered; expected <motor joint=...>",
        14,
    ),
    "tied to nothing": (
        "  <actuator>",
        '  <equality><connect name="c" site1="mark" site2="mork"/></equality>\n  <actuator>',
        "ties the site 'mork', which is not there",
        14,
    ),
    "tied to itself": (
        "  <actuator>",
        '  <equality><connect name="c" site1="mark" site2="mark"/></equality>\n  <actuator>',
        "ties two sites of one body",
        14,
    ),
    "two sites": (
        "<geom ",
        '<site name="mark"/><geom ',
        "site.mark: has the name of another site",
        10,
    ),
    "number": ('mass="2"', 'mass="two"', 'mass="two"; expected a number', 7),
}


@pytest.mark.parametrize(("old", "new", "words", "line"), WRONG.values(), ids=WRONG.keys())
def test_what_is_not_covered_is_reported(
    old: str, new: str, words: str, line: int, tmp_path: Path
) -> None:
    assert old in PENDULUM
    with pytest.raises(DescriptionError) as caught:
        read(tmp_path, PENDULUM.replace(old, new, 1))
    assert words in str(caught.value)
    assert caught.value.line == line


COMPILER, OPTION, BOB, MOTOR = (
    '<compiler angle="radian"/>',
    '<option gravity="0 0 -3.7"/>',
    '<body name="bob"',
    "<motor ",
)
# MuJoCo makes another robot of it: (what stands there, what is put in its place, words)
CHANGED = {
    "no weight": (
        OPTION,
        f'{OPTION[:-2]}><flag gravity="disable"/></option>',
        "flag: gravity of <flag> is 'disable'",
    ),
    "no loops": (
        OPTION,
        f'{OPTION[:-2]}><flag equality="disable"/></option>',
        "equality of <flag> is 'disable'",
    ),
    "no limits": (
        OPTION,
        f'{OPTION[:-2]}><flag limit="disable"/></option>',
        "limit of <flag> is 'disable'",
    ),
    "no springs": (
        OPTION,
        f'{OPTION[:-2]}><flag spring="disable"/></option>',
        "spring of <flag> is 'disable'",
    ),
    "no motors": (
        OPTION,
        f'{OPTION[:-2]}><flag actuation="disable"/></option>',
        "actuation of <flag> is 'disable'",
    ),
    "groups of motors": (
        OPTION,
        f'{OPTION[:-2]} actuatorgroupdisable="1"/>',
        "actuatorgroupdisable of <option>",
    ),
    "water": (
        OPTION,
        f'{OPTION[:-2]} density="1000"/>',
        "density of <option> is '1000', which is not covered; expected '0'",
    ),
    "honey": (OPTION, f'{OPTION[:-2]} viscosity="5"/>', "viscosity of <option> is '5'"),
    "wind": (OPTION, f'{OPTION[:-2]} wind="0 1 0"/>', "wind of <option> is '0 1 0'"),
    "unknown": (
        OPTION,
        f'{OPTION[:-2]} buoyancy="1"/>',
        "option: buoyancy of <option> is not covered; of MJCF",
    ),
    "floating": (
        BOB,
        f'{BOB} gravcomp="1"',
        "links.bob: gravcomp of <body> is '1', which is not covered; expected '0'",
    ),
    "led by hand": (BOB, f'{BOB} mocap="true"', "links.bob: mocap of <body> is 'true'"),
    "total mass": (
        COMPILER,
        f'{COMPILER[:-2]} settotalmass="1000"/>',
        "settotalmass of <compiler> is '1000'",
    ),
    "bound of masses": (
        COMPILER,
        f'{COMPILER[:-2]} boundmass="3"/>',
        "boundmass is 3, to which MuJoCo raises lighter",
    ),
    "bound of inertias": (
        COMPILER,
        f'{COMPILER[:-2]} boundinertia="3"/>',
        "boundinertia is 3, to which MuJoCo raises",
    ),
    "even inertias": (
        COMPILER,
        f'{COMPILER[:-2]} balanceinertia="true"/>',
        "balanceinertia of <compiler> is 'true'",
    ),
    "masses of shapes": (
        COMPILER,
        f'{COMPILER[:-2]} inertiafromgeom="true"/>',
        (
            "inertiafromgeom of <compiler> is 'true', which is not covered; expected 'auto' or"
            " 'false'"
        ),
    ),
    "gear": (
        MOTOR,
        f'{MOTOR}gear="50" ',
        "motors.q: gear of <motor> is '50', which is not covered; expected '1'",
    ),
    "site along a line": (
        '<site name="mark" ',
        '<site name="mark" fromto="0 0 0 1 0 0" ',
        "sites.mark: fromto of <site> is not covered",
    ),
    **{
        f"{kind} that does not hold": (
            "  <actuator>",
            f'  <equality><{kind} name="c" active="false"/></equality>\n  <actuator>',
            f"{kind}s.c: active of <{kind}> is 'false', which is not covered; expected 'true'",
        )
        for kind in ("connect", "weld", "joint")
    },
}


@pytest.mark.parametrize(("old", "new", "words"), CHANGED.values(), ids=CHANGED.keys())
def test_what_would_change_the_robot_is_refused_with_its_line(
    old: str, new: str, words: str, tmp_path: Path
) -> None:
    assert old in PENDULUM
    with pytest.raises(DescriptionError) as caught:
        read(tmp_path, PENDULUM.replace(old, new, 1))
    assert words in str(caught.value)
    assert caught.value.line == PENDULUM[: PENDULUM.index(old)].count("\n") + 1


# words that change nothing, values that MuJoCo takes anyway, settings in several places
HARMLESS = {
    COMPILER: (
        '<compiler angle="radian" inertiafromgeom="false" balanceinertia="false" boundmass="1e-9"/>'
        '<compiler autolimits="true" fusestatic="true"/>'
    ),
    OPTION: (
        '<option gravity="0 0 -9" timestep="0.001" density="0"/><option gravity="0 0 -3.7" wind="0'
        ' 0 0"><flag contact="disable" gravity="enable" energy="enable"/></option><option'
        ' solver="CG" iterations="7"/>'
    ),
    BOB: f'{BOB} gravcomp="0.0"',
    MOTOR: f'{MOTOR}gear="1 0 0 0 0 0" ctrlrange="-1 1" ',
}


@pytest.mark.parametrize("words", [{}, *({old: new} for old, new in HARMLESS.items()), HARMLESS])
def test_what_is_read_is_what_mujoco_makes_of_it(words: dict[str, str], tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    text = PENDULUM
    for old, new in words.items():
        text = text.replace(old, new, 1)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[0], data.qacc[0] = 0.4, 1.0
    mujoco.mj_inverse(model, data)
    machine = read(tmp_path, text)
    efforts = machine.inverse_dynamics(machine.close([0.4]), [1.0])
    assert efforts == pytest.approx(
        data.qfrc_inverse, rel=1e-8
    )  # a bound gives the tip, which has no mass, 1e-9 kg


def test_light_bodies_keep_their_mass(tmp_path: Path) -> None:
    """Only what this library writes for no mass, with no inertia to speak of, stands for none."""
    light = PENDULUM.replace(
        'mass="2" diaginertia="0.1 0.2 0.2"', 'mass="1e-6" diaginertia="1e-7 2e-7 2e-7"'
    )
    assert read(tmp_path, light).description.links["bob"].mass == 1e-6
    rotor = PENDULUM.replace('mass="2"', 'mass="1e-9"')
    assert read(tmp_path, rotor).description.links["bob"].inertia[2, 2] == 0.2
    none = PENDULUM.replace(
        'mass="2" diaginertia="0.1 0.2 0.2"', 'mass="1e-09" diaginertia="1e-09 1e-09 1e-09"'
    )
    assert read(tmp_path, none).description.links["bob"].mass == 0.0
