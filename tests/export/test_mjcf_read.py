"""Files of MJCF: what is read, what is left out with a note, what is refused with its line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import DescriptionError, Robot, load
from hybrid_dynamics_core.formats.reader import read_description

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


MESH = """\
<mujoco>
  <asset><mesh name="m" file="absent.stl"/></asset>
  <worldbody>
    <body name="bob"><joint name="q" axis="0 1 0"/><geom size="0.1" mass="2" pos="1 0 0"/>
      <geom type="mesh" mesh="m" WORDS/></body>
  </worldbody>
  <actuator><motor name="q" joint="q"/></actuator>
</mujoco>
"""


@pytest.mark.parametrize("words", ['mass="0"', 'density="0"', 'mass="0" density="9"'])
def test_a_mesh_without_mass_needs_no_file(words: str, tmp_path: Path) -> None:
    assert read(tmp_path, MESH.replace("WORDS", words)).description.links["bob"].mass == 2.0


@pytest.mark.parametrize("words", ["", 'mass="1"', 'density="9"', 'mass="1" density="0"'])
def test_a_mesh_with_mass_needs_its_file(words: str, tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match=r"absent\.stl"):
        read(tmp_path, MESH.replace("WORDS", words))


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
    "no such class": (
        '<joint name="q"',
        '<joint class="c" name="q"',
        "joints.q: unknown default class name 'c' (MuJoCo ",
        8,
    ),
    "screw": (
        'type="hinge"',
        'type="screw"',
        "joints.q: invalid keyword: 'screw'",
        8,
    ),
    "free in the tree": (
        '<body name="tip" pos="1 0 0"/>',
        '<body name="tip" pos="1 0 0"><freejoint name="f"/><geom size="1"/></body>',
        "links.tip: free joint can only be used on top level",
        11,
    ),
    "mass of a file": (
        '<inertial pos="0.5 0 0" mass="2" diaginertia="0.1 0.2 0.2"/>',
        '<geom type="mesh" mesh="m"/>',
        "geom: mesh 'm' not found",
        7,
    ),
    "two orientations": (
        '<body name="tip" pos="1 0 0"/>',
        '<body name="tip" quat="1 0 0 0" euler="1 0 0"/>',
        "links.tip: multiple orientation specifiers are not allowed",
        11,
    ),
    "unit of angles": ('angle="radian"', 'angle="grad"', "compiler: invalid keyword: 'grad'", 2),
    "tied body": (
        "  <actuator>",
        '  <equality><connect name="c" body1="bub" anchor="0 0 0"/></equality>\n  <actuator>',
        "connects.c: unknown element 'bub' in equality constraint",
        14,
    ),
    "half of two sites": (
        "  <actuator>",
        '  <equality><connect name="c" site1="mark"/></equality>\n  <actuator>',
        "connects.c: one of ('site1', 'site2'), ('body1', 'anchor') must be specified",
        14,
    ),
    "square": (
        '<body name="tip" pos="1 0 0"/>\n    </body>\n  </worldbody>\n',
        (
            '<body name="tip"><joint name="p"/><geom size="1"/></body>\n    </body>\n'
            '  </worldbody>\n  <equality><joint joint1="q" joint2="p" polycoef="0 1 2"/>'
            "</equality>\n"
        ),
        "polycoef is '0 1 2'; expected one of first degree",
        14,
    ),
    "no such follower": (
        "  <actuator>",
        '  <equality><joint joint1="p" joint2="q"/></equality>\n  <actuator>',
        "joint: unknown element 'p' in equality constraint",
        14,
    ),
    "other file": (
        "  <worldbody>",
        '  <include file="a.xml"/><worldbody>',
        "includes 'a.xml', which is not there",
        4,
    ),
    "itself": (
        "  <worldbody>",
        '  <include file="model.xml"/><worldbody>',
        "includes 'model.xml', which is included already",
        4,
    ),
    "tied to nothing": (
        "  <actuator>",
        '  <equality><connect name="c" site1="mark" site2="mork"/></equality>\n  <actuator>',
        "unknown element 'mork' in equality constraint",
        14,
    ),
    "tied to itself": (
        "  <actuator>",
        '  <equality><connect name="c" site1="mark" site2="mark"/></equality>\n  <actuator>',
        "element 'mark' is repeated in equality constraint",
        14,
    ),
    "two sites": (
        "<geom ",
        '<site name="mark"/><geom ',
        "sites.mark: repeated name 'mark' in site",
        10,
    ),
    "number": ('mass="2"', 'mass="two"', "inertial: bad format in attribute 'mass'", 7),
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
# What is no robot of rigid bodies: (what stands there, what is put in its place, words)
CHANGED = {
    "unknown": (
        OPTION,
        f'{OPTION[:-2]} buoyancy="1"/>',
        "option: buoyancy of <option> is not covered; it may change the robot",
    ),
    "led by hand": (BOB, f'{BOB} mocap="true"', "mocap body 'bob' is not a fixed child of world"),
    "slack cable": (
        "  <actuator>",
        (
            '  <tendon><fixed name="t" stiffness="3" springlength="0 1"><joint joint="q" coef="1"/>'
            "</fixed></tendon>\n  <actuator>"
        ),
        "fixed.t: springlength is 0 to 1, between which the spring is slack",
    ),
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


@pytest.mark.parametrize(
    ("given", "taken"), [((1.0, 2.0, 2.5), (1.0, 2.0, 2.5)), ((1.0, 1.0, 2.5), (1.5, 1.5, 1.5))]
)
def test_only_moments_that_no_body_has_are_balanced(
    given: tuple[float, ...], taken: tuple[float, ...], tmp_path: Path
) -> None:
    """The third is larger than the other two together, or it is not."""
    path = tmp_path / "arm.xml"
    moments = " ".join(map(str, given))
    path.write_text(
        '<mujoco><compiler balanceinertia="true"/><worldbody><body name="arm">'
        f'<joint name="q"/><inertial pos="0 0 0" mass="1" diaginertia="{moments}"/>'
        "</body></worldbody></mujoco>",
        encoding="utf-8",
    )
    description = read_description(path)
    np.testing.assert_allclose(description.links["arm"].inertia, np.diag(taken), atol=1e-12)
    assert any("balanced" in note for note in description.notes) == (given != taken)
