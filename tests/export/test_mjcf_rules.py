"""Every rule of MJCF in a small file: MuJoCo's mass matrix and forces are the robot's."""

from __future__ import annotations

import os
import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import DescriptionError, Robot
from hybrid_dynamics_core.formats.mjcf.compiler.process import WORKERS
from hybrid_dynamics_core.formats.reader import read_description

mujoco = pytest.importorskip("mujoco")
NEAR = 1e-9  # relative, of numbers that go through quaternions and angles

GEOM = '<geom type="box" size=".1 .05 .03" pos=".1 .02 0"/>'


def model(inside: str = "", *, head: str = "", tail: str = "", joint: str = "") -> str:
    """Two bodies on hinges that lean, with more in the second one, before and behind them."""
    return f"""<mujoco>{head}<worldbody>
      <body name="one" euler="10 20 30">
        <joint name="a" axis="0 1 .2" ref="20" range="-90 90"/>{GEOM}<site name="s" pos="0 0 .1"/>
        <body name="two" pos=".2 0 .1"><joint name="b" axis="1 .1 0" pos=".02 0 0" {joint}/>{GEOM}
          {inside}</body>
      </body></worldbody>{tail}</mujoco>"""


BODY = '<body name="three" pos=".3 0 0"><joint name="c" type="slide"/><geom size=".05"/></body>'
TREES = {
    "degrees and a ref": model(),
    "fixed angles": model(head='<compiler eulerseq="ZYX"/>'),
    "a class": model(
        head='<default><joint damping=".3"/><default class="k"><joint armature=".2"/></default>'
        "</default>",
        joint='class="k"',
    ),
    "a spring by time": model(joint='springdamper=".5 1"'),
    "a spring with its rest": model(joint='stiffness="3" springref="40"'),
    "a frame in a frame": model(f'<frame pos="0 1 0"><frame euler="0 0 9">{BODY}</frame></frame>'),
    "replicated": model(
        '<replicate count="3" offset="0 .1 0" euler="0 0 7"><body><joint/><geom size=".1"/></body>'
        "</replicate>"
    ),
    "a total mass": model(head='<compiler settotalmass="7"/>'),
    "shells": model('<geom size=".1" mass="1" shellinertia="true"/>'),
    "inertia from shapes": model(
        '<inertial pos="1 1 1" mass="9" diaginertia="1 1 1"/>',
        head='<compiler inertiafromgeom="true"/>',
    ),
    "groups": model('<geom size=".1" group="4"/>', head='<compiler inertiagrouprange="0 2"/>'),
    "rotors of actuators": model(
        tail='<actuator><motor joint="a" gear="3" armature=".1" damping=".2"/></actuator>'
    ),
    "no gravity": model(head='<option><flag gravity="disable"/></option>'),
    "no springs": model(
        joint='stiffness="3" damping="2"',
        head='<option><flag spring="disable" damper="disable"/></option>',
    ),
    "half of the weight": model().replace("<body ", '<body gravcomp=".5" '),
    "the weight of some": model(BODY.replace("<body ", '<body gravcomp="1.5" ')),
    "several joints in one body": model(
        '<body name="three"><joint name="c" type="slide" axis="1 1 0"/>'
        '<joint name="d" pos="0 1 0"/>'
        '<joint name="e" axis="1 0 0"/><geom size=".05"/></body>'
    ),
}


def name_of(compiled, number: int) -> str:
    return compiled.joint(number).name or f"joint{number}"


def compared(text: str, folder: Path) -> None:
    """Mass matrix and efforts of the tree at a random state."""
    file = folder / "model.xml"
    file.write_text(text, encoding="utf-8")
    compiled = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(compiled)
    description = read_description(file)
    names = tuple(name_of(compiled, number) for number in range(compiled.njnt))
    robot = Robot(replace(description, active=names, active_set="exact"))
    rng = np.random.default_rng(7)
    q, v, a = rng.uniform(-0.5, 0.5, (3, compiled.nv))
    data.qpos[:], data.qvel[:] = q, v
    mujoco.mj_forward(compiled, data)
    mass = np.zeros((compiled.nv, compiled.nv))
    mujoco.mj_fullM(compiled, data, mass)
    state = robot.close(q, v)
    assert robot.minimal_form(state)[0] == pytest.approx(mass, rel=NEAR, abs=1e-12)
    expected = mass @ a + data.qfrc_bias - data.qfrc_passive
    assert robot.inverse_dynamics(state, a) == pytest.approx(expected, rel=NEAR, abs=1e-10)


@pytest.mark.parametrize("text", TREES.values(), ids=TREES.keys())
def test_a_tree_is_what_mujoco_makes_of_it(text: str, tmp_path: Path) -> None:
    compared(text, tmp_path)


# -- loops and couplings: the residual of MuJoCo's equality is none at closed states

FOUR_BAR = """<mujoco><compiler angle="degree"/><worldbody>
  <body name="crank"><joint name="a" axis="0 1 0"/><geom size=".1"/>
    <body name="coupler" pos=".2 0 0"><joint name="b" axis="0 1 0" ref="5"/><geom size=".1"/>
      <site name="s" pos=".5 0 0"/></body></body>
  <body name="rocker" pos=".6 0 -.2"><joint name="c" axis="0 1 0"/><geom size=".1"/>
    <site name="t" pos=".12 0 .21" euler="0 3 0"/></body>
  {more}</worldbody>{tail}<actuator><motor joint="a"/></actuator>
  <keyframe><key name="home" qpos="{key}"/></keyframe></mujoco>"""
THREE = (
    '<body pos="1 0 0"><joint name="d" axis="1 0 0" ref="10"/><geom size=".1"/>'
    '<body><joint name="e"/><geom size=".1"/><body><joint name="f" type="slide"/><geom size=".1"/>'
    "</body></body></body>"
)
TENDONS = (
    '<tendon><fixed name="one"><joint joint="d" coef="2"/><joint joint="e" coef=".5"/></fixed>'
    '<fixed name="two"><joint joint="f" coef="3"/></fixed></tendon>'
)
TIES = {
    "anchor": '<connect body1="coupler" body2="rocker" anchor=".5 0 0"/>',
    "sites": '<connect site1="s" site2="t"/>',
    "joint": '<joint joint1="d" joint2="e" polycoef=".1 2"/>',
    "held": '<joint joint1="d" polycoef=".1"/>',
    "tendon": '<tendon tendon1="one" polycoef=".2"/>',
    "two tendons": '<tendon tendon1="one" tendon2="two" polycoef=".2 -3"/>',
    "weld": '<weld body1="crank" body2="rocker"/>',
}


@pytest.mark.parametrize("tie", TIES.values(), ids=TIES.keys())
def test_a_tie_is_closed_where_mujoco_closes_it(tie: str, tmp_path: Path) -> None:
    is_loop = "body" in tie or "site" in tie
    text = FOUR_BAR.format(
        more="" if is_loop else THREE,
        tail=("" if is_loop else TENDONS) + f"<equality>{tie}</equality>",
        key="0 .087 0" if is_loop else "0 0 0 .17 0 0",
    )
    if "weld" in tie:  # of a planar loop on three hinges: the crank carries the rocker
        text = text.replace('pos=".6 0 -.2"', 'pos=".0 0 0"')
    file = tmp_path / "model.xml"
    file.write_text(text, encoding="utf-8")
    robot = Robot(read_description(file))
    state = robot.close(robot.reference + 0.05)
    compiled = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(compiled)
    data.qpos[:] = compiled.qpos0
    for name, value in zip(robot.coordinates, state.s, strict=True):
        data.qpos[compiled.joint(name).qposadr[0]] = value
    if "held" in tie or 'polycoef=".1"' in tie:
        data.qpos[compiled.joint("d").qposadr[0]] += 0.1
    mujoco.mj_forward(compiled, data)
    rows = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
    assert rows.any()
    assert data.efc_pos[rows] == pytest.approx(0.0, abs=1e-9)


# -- meshes


def stl(folder: Path) -> None:
    """A tetrahedron."""
    corners = np.array([[0, 0, 0], [0.3, 0, 0], [0, 0.2, 0], [0, 0, 0.1]])
    data = b"\0" * 80 + struct.pack("<I", 4)
    for face in ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)):
        data += struct.pack("<12fH", 0, 0, 0, *corners[list(face)].ravel(), 0)
    folder.mkdir(exist_ok=True)
    (folder / "wedge.stl").write_bytes(data)


ASSETS = (
    '<compiler meshdir="meshes"/><asset><mesh file="wedge.stl"/><texture name="t" file="no.png"'
    ' type="2d"/><material name="m" texture="t"/></asset>'
)
MESH = '<geom type="mesh" mesh="wedge" material="m"/>'


def test_a_mesh_gives_the_mass_that_mujoco_gives_it(tmp_path: Path) -> None:
    stl(tmp_path / "meshes")
    file = tmp_path / "model.xml"
    text = model(MESH, head=ASSETS)
    file.write_text(text, encoding="utf-8")
    plain = (
        text.replace(' material="m"', "")
        .replace("<texture", "<!--")
        .replace('"t"/></', '"t"/>--></')
    )
    asset = {"wedge.stl": (tmp_path / "meshes/wedge.stl").read_bytes()}
    compiled = mujoco.MjModel.from_xml_string(plain.replace('meshdir="meshes"', ""), asset)
    link = read_description(file).links["two"]
    assert link.mass == pytest.approx(compiled.body("two").mass[0], rel=1e-12)
    assert np.linalg.eigvalsh(link.inertia)[::-1] == pytest.approx(
        compiled.body("two").inertia, rel=NEAR
    )


def test_a_mesh_that_is_not_there_is_no_obstacle_where_the_inertia_is_given(tmp_path: Path) -> None:
    file = tmp_path / "model.xml"
    inertial = '<inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/>'
    file.write_text(model(inertial + MESH, head=ASSETS), encoding="utf-8")
    assert read_description(file).links["two"].mass == 2.0
    file.write_text(model(MESH, head=ASSETS), encoding="utf-8")
    with pytest.raises(
        DescriptionError, match=r"links\.two: its mass is that of the mesh"
    ) as error:
        read_description(file)
    assert error.value.line == 5
    assert "give the body an <inertial>" in str(error.value)


# -- what a program does, what is refused


def test_a_body_that_a_program_moves_ties_nothing(tmp_path: Path) -> None:
    text = model(
        tail='<worldbody><body name="hand" mocap="true"/></worldbody>'
        '<equality><weld body1="hand" body2="two"/></equality>'
    )
    file = tmp_path / "model.xml"
    file.write_text(text, encoding="utf-8")
    description = read_description(file)
    assert description.closures == ()
    assert any("a program moves its end (mocap)" in note for note in description.notes)


REFUSED = {
    "a weight that some drives hold": (
        model(joint='actuatorgravcomp="true"').replace("<body ", '<body gravcomp="1" '),
        4,
    ),
    "a polynomial": (model(joint='damping="1 2"'), 4),
    "a spring that yields": (model(joint='stiffness="1" springyield="1"'), 4),
    "a cable that is held": (
        model(
            tail='\n<tendon><spatial name="t"><site site="s"/><site site="w"/></spatial></tendon>'
            '<equality><tendon tendon1="t"/></equality><worldbody><site name="w"/></worldbody>'
        ),
        7,
    ),
    "a size beyond all": (model('<geom type="box" size="1e200 1 1e200"/>'), 4),
}


@pytest.mark.parametrize(("text", "line"), REFUSED.values(), ids=REFUSED.keys())
def test_what_changes_the_mechanics_is_refused(text: str, line: int, tmp_path: Path) -> None:
    file = tmp_path / "model.xml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(DescriptionError) as error:
        read_description(file)
    assert error.value.line == line


# -- files of strangers


def test_files_outside_are_not_read(tmp_path: Path) -> None:
    (tmp_path / "secret.xml").write_text("<mujoco/>", encoding="utf-8")
    stl(tmp_path)
    inside = tmp_path / "robot"
    inside.mkdir()
    file = inside / "model.xml"
    for head, inner in (
        ('<include file="../secret.xml"/>', ""),
        (
            '<asset><mesh name="wedge" file="../wedge.stl"/></asset>',
            MESH.replace(' material="m"', ""),
        ),
        ('<asset><mesh name="wedge" file="/dev/zero"/></asset>', MESH.replace(' material="m"', "")),
    ):
        file.write_text(model(inner, head=head), encoding="utf-8")
        with pytest.raises(DescriptionError, match="is not below"):
            read_description(file)


def test_a_model_without_end_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "model.xml"
    bomb = (
        '<replicate count="9999"><replicate count="9999"><geom size="1"/></replicate></replicate>'
    )
    file.write_text(model(bomb), encoding="utf-8")
    with pytest.raises(DescriptionError, match="makes 99980001 copies"):
        read_description(file)
    compared(TREES["shells"], tmp_path)  # the next one is read


def test_a_process_that_is_gone_is_replaced(tmp_path: Path) -> None:
    compared(TREES["shells"], tmp_path)
    assert WORKERS.worker is not None
    os.kill(WORKERS.worker.process.pid, 9)
    compared(TREES["shells"], tmp_path)
