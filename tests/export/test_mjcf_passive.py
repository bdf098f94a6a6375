"""What pulls, loads or surrounds an MJCF model: MuJoCo's forces, or a note that they are not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import DescriptionError, Robot
from hybrid_dynamics_core.formats.reader import read_description
from tests.export.test_mjcf_rules import BODY, GEOM, model

mujoco = pytest.importorskip("mujoco")
NEAR = 1e-9

SITES = '<worldbody><site name="w" pos=".3 .5 .4"/><site name="v" pos="0 .5 .4"/></worldbody>'
INNER = f'<site name="t" pos=".1 .1 .05"/>{BODY}'


def fixed(words: str, polycoef: str = "") -> str:
    tie = f'<equality><joint joint1="c" {polycoef}/></equality>' if polycoef else ""
    return (
        f'<tendon><fixed name="f" {words}><joint joint="a" coef="2"/><joint joint="c" coef="-.5"/>'
        f"</fixed></tendon>{tie}"
    )


def spatial(words: str, path: str) -> str:
    return f'<tendon><spatial name="p" {words}>{path}</spatial></tendon>{SITES}'


DIRECT = '<site site="w"/><site site="t"/>'
LONG = '<site site="s"/><site site="v"/><site site="w"/><site site="t"/>'
PULLEY = f'{DIRECT}<pulley divisor="2"/><site site="s"/><site site="v"/>'
PULLS = {
    "spring on a sum": fixed('stiffness="30"'),
    "spring on a sum with a rest": fixed('stiffness="30" springlength=".7"'),
    "damper and rotor on a sum": fixed('damping="3" armature=".4"'),
    "spring on a sum with a joint that is held": fixed('stiffness="30"', 'polycoef=".1"'),
    "spring between sites": spatial('stiffness="50" springlength=".2"', DIRECT),
    "damper and rotor between sites": spatial('damping="5" armature=".7"', DIRECT),
    "over several sites": spatial('stiffness="50" damping="5" armature=".3"', LONG),
    "with a pulley": spatial('stiffness="20" armature=".3"', PULLEY),
}


def taken(robot: Robot, compiled, data, state) -> np.ndarray:
    """Put MuJoCo into a state; the map from independent rates to its velocities."""
    rates = np.zeros((compiled.nv, len(robot.coordinates)))
    data.qpos[:] = compiled.qpos0
    for number in range(compiled.njnt):
        name = compiled.joint(number).name
        if name in robot.coordinates:
            column = robot.coordinates.index(name)
            data.qpos[number] = state.s[column]
            rates[number, column] = 1.0
        else:
            data.qpos[number] += 0.1  # it is held
    data.qvel[:] = rates @ state.ds
    mujoco.mj_forward(compiled, data)
    return rates


def agrees(text: str, folder: Path) -> Robot:
    """Mass matrix and inverse dynamics at a random state."""
    file = folder / "model.xml"
    file.write_text(text, encoding="utf-8")
    compiled = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(compiled)
    robot = Robot(read_description(file))
    assert not [note for note in robot.description.notes if note.startswith("springlength")]
    rng = np.random.default_rng(3)
    u, du, ddu = rng.uniform(-0.2, 0.2, (3, len(robot.active)))
    state = robot.close(robot.reference + u, du)
    rates = taken(robot, compiled, data, state)
    mass = np.zeros((compiled.nv, compiled.nv))
    mujoco.mj_fullM(compiled, data, mass)
    to_rates = rates @ state.R
    expected = to_rates.T @ mass @ to_rates
    assert robot.minimal_form(state)[0] == pytest.approx(expected, rel=NEAR, abs=1e-11)
    passive = data.qfrc_passive - data.qfrc_fluid
    forces = mass @ rates @ robot.accelerations(state, ddu) + data.qfrc_bias - passive
    efforts = robot.inverse_dynamics(state, ddu)
    assert efforts == pytest.approx(to_rates.T @ forces, rel=NEAR, abs=1e-10)
    return robot


@pytest.mark.parametrize("tail", PULLS.values(), ids=PULLS.keys())
def test_a_tendon_pulls_as_in_mujoco(tail: str, tmp_path: Path) -> None:
    robot = agrees(model(INNER, tail=tail), tmp_path)
    assert set(robot.active) <= {"a", "b", "c"}


def test_a_fluid_is_left_out_with_its_lines(tmp_path: Path) -> None:
    head = '\n<option density="900" viscosity=".3"/>\n'
    robot = agrees(model(BODY, head=head), tmp_path)
    notes = [note for note in robot.description.notes if "drag of the fluid" in note]
    assert [note.split(": ")[0] for note in notes] == ["model.xml:2", "model.xml:2"]
    assert "density of <option> is 900" in notes[0]


SLACK = spatial('stiffness="5" springlength=".1 .2"', DIRECT)
AROUND = spatial('stiffness="5"', '<site site="w"/><geom geom="g"/><site site="t"/>')
BENT = spatial('stiffness="5 1"', DIRECT)
REFUSED = {
    "slack": (SLACK, "springlength is 0.1 to 0.2"),
    "around a shape": (AROUND, "pulls around a shape"),
    "bent": (BENT, "stiffness of higher degree is 1"),
}


@pytest.mark.parametrize(("tail", "words"), REFUSED.values(), ids=REFUSED.keys())
def test_a_tendon_that_no_spring_stands_for_is_refused(
    tail: str, words: str, tmp_path: Path
) -> None:
    file = tmp_path / "model.xml"
    ball = '<geom name="g" size=".02"/>'
    file.write_text(model(f"{INNER}{ball}", tail=f"\n{tail}"), encoding="utf-8")
    with pytest.raises(DescriptionError, match=r"spatial\.p: ") as error:
        read_description(file)
    assert words in str(error.value)
    assert error.value.line == 7


# -- models in other files

CHILD = f"""<mujoco model="child"><compiler angle="radian"/>
  <default><default class="k"><joint damping=".3"/></default></default>
  <worldbody><body name="arm" pos="0 0 .2"><joint name="j" class="k" axis="0 1 0"/>{GEOM}
    <body name="hand" pos=".2 0 0"><joint name="k" type="slide" axis="1 0 0"/>{GEOM}</body></body>
  </worldbody><actuator><motor joint="j" forcerange="-4 4"/></actuator>
  <keyframe><key qpos="1 1"/></keyframe></mujoco>"""
HEAD = '<asset><model name="m" file="parts/child.xml"/></asset>'
INSIDE = (
    '<frame euler="0 0 20"><attach model="m" body="arm" prefix="left_"/></frame>'
    '<attach model="m" body="arm" prefix="right_"/>'
)


def write_child(folder: Path, text: str = CHILD) -> None:
    (folder / "parts").mkdir(exist_ok=True)
    (folder / "parts/child.xml").write_text(text, encoding="utf-8")


def test_models_are_attached_as_in_mujoco(tmp_path: Path) -> None:
    write_child(tmp_path)
    file = tmp_path / "model.xml"
    file.write_text(model(INSIDE, head=HEAD), encoding="utf-8")
    compiled = mujoco.MjModel.from_xml_path(str(file))
    robot = Robot(read_description(file))
    assert robot.description.motors == ("left_j", "right_j")
    assert robot.description.joints["left_j"].effort_limit == 4.0
    data = mujoco.MjData(compiled)
    names = [compiled.joint(k).name for k in range(compiled.njnt)]
    assert set(names) == set(robot.coordinates)
    state = robot.close(0.1 * np.arange(1, 7), 0.2 * np.arange(1, 7))
    rates = taken(robot, compiled, data, state)
    forces = data.qfrc_bias - data.qfrc_passive
    efforts = robot.inverse_dynamics(state, np.zeros(6))
    assert efforts == pytest.approx((rates @ state.R).T @ forces, rel=NEAR, abs=1e-10)


def test_errors_in_an_attached_model_name_its_file(tmp_path: Path) -> None:
    file = tmp_path / "model.xml"
    file.write_text(model(INSIDE, head=HEAD), encoding="utf-8")
    for text, line, words in (
        (CHILD.replace('axis="0 1 0"', 'axis="0 0 0"'), 3, "axis too small"),
        (CHILD.replace('class="k" ', 'damping="1 2" '), 3, "polynomial"),
    ):
        write_child(tmp_path, text)
        with pytest.raises(DescriptionError, match=words) as error:
            read_description(file)
        assert (Path(error.value.file).name, error.value.line) == ("child.xml", line)


def test_attached_models_stay_below_the_folder_and_end(tmp_path: Path) -> None:
    write_child(tmp_path)
    folder = tmp_path / "inner"
    folder.mkdir()
    file = folder / "model.xml"
    for path, words in (
        ("../parts/child.xml", "is not below"),
        ("none.xml", "which is not there"),
        ("model.xml", "in itself"),
    ):
        text = model(INSIDE, head=HEAD.replace("parts/child.xml", path))
        file.write_text(text, encoding="utf-8")
        with pytest.raises(DescriptionError, match=words):
            read_description(file)


# -- flexes

FLEX = '<flexcomp name="cloth" type="grid" count="3 3 1" spacing=".1 .1 .1" mass="1" radius=".01"/>'


def test_a_flex_on_the_world_is_left_out(tmp_path: Path) -> None:
    cloth = f"<worldbody>\n{FLEX}</worldbody>"
    file = tmp_path / "model.xml"
    file.write_text(model(BODY, tail=cloth), encoding="utf-8")
    description = read_description(file)
    assert any("xml:7: <flexcomp> cloth is left out" in note for note in description.notes)
    file.write_text(model(BODY), encoding="utf-8")
    assert read_description(file).links.keys() == description.links.keys()


def test_a_flex_that_moves_with_a_body_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "model.xml"
    file.write_text(model(f"\n{FLEX}"), encoding="utf-8")
    with pytest.raises(DescriptionError, match="fixed to a body that moves") as error:
        read_description(file)
    assert error.value.line == 6


def test_where_flexes_alone_move_there_is_no_robot(tmp_path: Path) -> None:
    file = tmp_path / "model.xml"
    file.write_text(f"<mujoco><worldbody>\n{FLEX}</worldbody></mujoco>", encoding="utf-8")
    with pytest.raises(DescriptionError, match="there is no robot in this file") as error:
        read_description(file)
    assert error.value.line == 2


def test_a_weld_between_what_stands_still_is_left_out(tmp_path: Path) -> None:
    tail = '<worldbody><body name="post"/></worldbody>\n<equality><weld body1="post"/></equality>'
    file = tmp_path / "model.xml"
    file.write_text(model(tail=tail), encoding="utf-8")
    description = read_description(file)
    assert description.closures == ()
    assert any("nothing moves between its ends" in note for note in description.notes)


def test_a_body_that_nobody_drives_is_a_robot(tmp_path: Path) -> None:
    file = tmp_path / "model.xml"
    body = '<body><freejoint name="f"/><geom size=".1"/></body>'
    text = f"<mujoco><worldbody>{body}</worldbody></mujoco>"
    file.write_text(text, encoding="utf-8")
    robot = Robot(read_description(file))
    assert (robot.description.motors, len(robot.description.idle)) == ((), 6)
