"""Inertias that no body has: told with file, line and by how much, refused by `strict` alone."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import (
    DescriptionError,
    InputError,
    MassSingularityError,
    Payload,
    Robot,
    load,
)
from hybrid_dynamics_core.description.geometry import rotation_from_rpy
from hybrid_dynamics_core.description.rigid_body import impossibility, nearest_possible
from hybrid_dynamics_core.dynamics.parameters import link_of
from hybrid_dynamics_core.export import to_gepetto, to_mjcf, to_sdf, to_urdf, to_urdf_plus
from hybrid_dynamics_core.identification import identify, random_motion
from tests.description.robots import HEAD, parse
from tests.sampling import examples

FOUR_PERCENT = [0.0004, 0.0018, 0.00229]  # [kg m^2] as a public URDF has them
MISSING = (
    "two of them must add up to at least the third, and 9e-05 kg m^2 are missing (3.93 % of it)"
)

moments = st.tuples(*[st.floats(0.0, 1.0)] * 3)
angles = st.tuples(*[st.floats(-3.0, 3.0)] * 3)


def arm(link: str, base: str = "{}") -> str:
    """One link on a joint about y, with an entry for each of its two bodies."""
    return (
        HEAD
        + f"links:\n  base: {base}\n  l: {link}\n"
        + "joints: {q: {type: revolute, parent: base, child: l, axis: y}}\n"
        + "active: [q]\nend_effector: {link: l, xyz: [1, 0, 0]}\n"
    )


def entry(matrix: np.ndarray, mass: float = 1.0) -> str:
    return f"{{mass: {mass}, com: [0.1, 0, 0], inertia: {matrix.tolist()}}}"


def turned(principal: tuple[float, ...], rpy: tuple[float, ...]) -> np.ndarray:
    """A tensor as arithmetic gives it: mirrored entries differ by rounding."""
    rotation = rotation_from_rpy(*rpy)
    return rotation @ np.diag(principal) @ rotation.T


def of_points(numbers: tuple[float, ...]) -> tuple[float, ...]:
    """Moments that a body has, from three numbers that are zero or positive."""
    a, b, c = numbers
    return (b + c, a + c, a + b)


@examples(300)
@given(moments.map(of_points), angles, st.integers(2, 17))
def test_what_bodies_have_loads_however_it_is_rounded(
    principal: tuple[float, ...], rpy: tuple[float, ...], digits: int
) -> None:
    """Printed with n digits it is off by no more than they are, and is told if no body has it."""
    exact = turned(principal, rpy)
    printed = np.array([[float(f"{value:.{digits - 1}e}") for value in row] for row in exact])
    robot = parse(arm(entry(printed)))
    size = max(exact.max(), 1e-300)
    error = 3.0 * size * 10.0 ** (1 - digits)
    assert np.abs(robot.links["l"].inertia - exact).max() <= error
    assert np.array_equal(robot.links["l"].inertia, robot.links["l"].inertia.T)
    assert not impossibility(robot.links["l"].inertia, 9.0 * 10.0 ** (1 - digits))
    told = [note for note in robot.notes if "links.l.inertia" in note]
    assert len(robot.impossible) <= len(told) <= 1
    if digits > 12:
        assert not robot.notes


@examples(300)
@given(st.tuples(*[st.floats(-0.2, 1.0)] * 3), angles, st.integers(0, 99))
def test_no_tensor_that_a_body_has_is_nearer_than_the_nearest(
    principal: tuple[float, ...], rpy: tuple[float, ...], seed: int
) -> None:
    tensor = turned(principal, rpy)
    tensor = (tensor + tensor.T) / 2.0
    nearest = nearest_possible(tensor)
    assert not impossibility(nearest, 0.0)
    distance = float(np.linalg.norm(nearest - tensor))
    if not impossibility(tensor, 1e-9):
        assert distance < 1e-8
    rng = np.random.default_rng(seed)
    for _ in range(20):
        other = of_points(tuple(rng.uniform(0.0, 0.7, 3)))
        candidate = nearest + rng.uniform() * (turned(other, tuple(rng.normal(size=3))) - nearest)
        assert np.linalg.norm(candidate - tensor) >= distance - max(1e-6, 0.15 * distance)


@pytest.mark.parametrize("apart", [1e-18, 1e-9, 3e-6])
def test_an_asymmetry_by_rounding_is_evened_out(apart: float) -> None:
    matrix = np.array([[0.02, 0.001, 0.002], [0.001 + apart, 0.03, 0.003], [0.002, 0.003, 0.04]])
    robot = parse(arm(entry(matrix)))
    inertia = robot.links["l"].inertia
    assert np.array_equal(inertia, inertia.T)
    assert inertia == pytest.approx(matrix, abs=apart)
    told = [note for note in robot.notes if "mirrored entries differ" in note]
    assert len(told) == (apart > 1e-15)
    if told:
        assert told[0].startswith("small.yaml:6: links.l.inertia: ")
        assert f"differ by {apart:.3g} kg m^2" in told[0]


def test_an_asymmetry_beyond_rounding_is_refused_with_its_size() -> None:
    matrix = np.array([[0.02, 0.001, 0.002], [0.0014, 0.03, 0.003], [0.002, 0.003, 0.04]])
    words = r"entry xy is 0\.001, entry yx is 0\.0014 kg m\^2; they differ by 0\.0004, and 4e-06"
    with pytest.raises(DescriptionError, match=rf"small\.yaml:6: links\.l\.inertia: .*{words}"):
        parse(arm(entry(matrix)))


# -- files of every format

TEXTS = {
    "yaml": arm(entry(np.diag(FOUR_PERCENT))),
    "urdf": """\
<robot name="small"><link name="base"/>
<link name="l"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>
<inertia ixx="0.0004" iyy="0.0018" izz="0.00229" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="q" type="continuous"><parent link="base"/><child link="l"/><axis xyz="0 1 0"/></joint>
</robot>""",
    "mjcf": """\
<mujoco model="small"><compiler angle="radian"/><worldbody>
<body name="l"><inertial pos="0.1 0 0" mass="1" diaginertia="0.0004 0.0018 0.00229"/>
<joint name="q" type="hinge" axis="0 1 0"/></body></worldbody>
<actuator><motor joint="q"/></actuator></mujoco>""",
    "sdf": """\
<sdf version="1.11"><model name="small"><link name="base"><inertial><mass>1</mass></inertial></link>
<joint name="f" type="fixed"><parent>world</parent><child>base</child></joint>
<link name="l"><inertial><pose>0.1 0 0 0 0 0</pose><mass>1</mass>
<inertia><ixx>0.0004</ixx><iyy>0.0018</iyy><izz>0.00229</izz></inertia></inertial></link>
<joint name="q" type="revolute"><parent>base</parent><child>l</child><axis><xyz>0 1 0</xyz></axis>
</joint></model></sdf>""",
}
LINES = {"yaml": 6, "urdf": 2, "mjcf": 2, "sdf": 3}


@pytest.mark.parametrize(("form", "text"), TEXTS.items(), ids=TEXTS.keys())
def test_every_format_tells_and_goes_on(tmp_path: Path, form: str, text: str) -> None:
    """The joint turns about y, to which the moment that is wrong does not matter."""
    path = tmp_path / f"small.{form}"
    path.write_text(text)
    robot = load(path)
    (note,) = [note for note in robot.description.notes if "no rigid body" in note]
    assert note.startswith(f"{path}:{LINES[form]}: links.l.inertia: no rigid body has principal")
    assert MISSING in note
    state = robot.close([0.0])
    acceleration = robot.forward_dynamics(state, [0.0])
    assert acceleration == pytest.approx([0.981 / 0.0118], rel=1e-12)
    with pytest.raises(DescriptionError, match=r"3\.93 %") as caught:
        load(path, strict=True)
    assert caught.value.line == LINES[form]


def returned(robot: Robot, folder: Path) -> dict[str, Robot]:
    """The robot out of the files of every format."""
    pair = to_gepetto(robot.description)
    texts = {
        "tree.urdf": to_urdf(robot.description),
        "plus.urdf": to_urdf_plus(robot.description),
        "small.sdf": to_sdf(robot),
        "small.xml": to_mjcf(robot),
        "pair.urdf": pair.urdf,
        "pair.yaml": pair.yaml.replace("small.urdf", "pair.urdf"),
    }
    for name, text in texts.items():
        (folder / name).write_text(text)
    return {name: load(folder / name) for name in texts if name != "pair.urdf"}


WRONG = {
    "triangle": "{mass: 1, inertia: {principal: [0.0004, 0.0018, 0.00229]}}",
    "negative": "{mass: 2, com: [0.3, 0, 0], inertia: {xx: -0.001, yy: 0.02, zz: 0.02}}",
    "no mass": "{mass: 0, inertia: {xx: 0.1, yy: 0.1, zz: 0.1}}",
    "plate": "{mass: 1, inertia: {principal: [1, 1, 2], frame: {rpy: [0.3, 0.2, 1.1]}}}",
}


@pytest.mark.parametrize("link", WRONG.values(), ids=WRONG.keys())
def test_exports_keep_what_no_body_has_and_other_programs_take_them(
    tmp_path: Path, link: str
) -> None:
    path = tmp_path / "small.yaml"
    path.write_text(arm(link))
    robot = load(path)
    expected = robot.description.links["l"]
    for name, back in returned(robot, tmp_path).items():
        body = back.description.links["l"]
        assert body.mass == expected.mass, name
        assert np.array_equal(body.inertia, expected.inertia), name
        assert bool(back.description.impossible) == bool(robot.description.impossible), name
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "small.xml"))
    assert model.nbody == 2


def test_efforts_without_a_positive_mass_matrix_are_refused() -> None:
    robot = Robot(parse(arm("{mass: 1, inertia: {xx: 0.04, yy: -0.1, zz: 0.05}}")))
    state = robot.close([0.3])
    assert robot.forward_kinematics(state).position == pytest.approx(
        [np.cos(0.3), 0.0, -np.sin(0.3)]
    )
    assert robot.inverse_dynamics(state, [2.0]) == pytest.approx([-0.2])
    with pytest.raises(MassSingularityError, match="not positive definite: a link has an inertia"):
        robot.forward_dynamics(state, [0.0])


def test_payloads_of_files_are_told_and_those_of_calls_refused() -> None:
    payload = "payloads: {tool: {on: l, mass: 1, inertia: {principal: [0.0004, 0.0018, 0.00229]}}}"
    description = parse(arm("{mass: 1, com: [0.1, 0, 0]}") + payload)
    (key,) = description.impossible
    assert key == "payloads.tool.inertia"
    assert any(note.startswith("small.yaml:10: payloads.tool") for note in description.notes)
    with pytest.raises(InputError, match="payload: no rigid body has principal moments"):
        Payload(1.0, inertia=np.diag(FOUR_PERCENT))


# -- what cannot move

BASES = {
    "nothing": "{}",
    "mass": "{mass: 300}",
    "impossible": "{mass: 300, inertia: {principal: [1, 1, 9]}}",
}


@pytest.mark.parametrize("base", BASES.values(), ids=BASES.keys())
def test_a_base_that_cannot_move_needs_no_inertia(tmp_path: Path, base: str) -> None:
    path = tmp_path / "small.yaml"
    path.write_text(arm("{mass: 1, com: [0.1, 0, 0], inertia: {sphere: {radius: 0.1}}}", base))
    robot = load(path, strict=True)
    assert robot.description.notes == ()
    for name, back in returned(robot, tmp_path).items():
        assert not back.description.impossible, name


def test_a_urdf_whose_root_has_a_body_and_no_inertia(tmp_path: Path) -> None:
    path = tmp_path / "small.urdf"
    for inertia in ("", '<inertia ixx="1" iyy="1" izz="9" ixy="0" ixz="0" iyz="0"/>'):
        base = f'<link name="base"><inertial><mass value="5"/>{inertia}</inertial></link>'
        text = TEXTS["urdf"].replace('<link name="base"/>', base).replace("0.00229", "0.002")
        path.write_text(text)
        notes = load(path, strict=True).description.notes
        assert not any("inertia" in note for note in notes)


def test_a_body_fixed_to_the_base_cannot_move_either() -> None:
    text = arm("{mass: 1, inertia: {sphere: {radius: 1}}}").replace(
        "joints: {",
        "  foot: {mass: 9, inertia: {xx: 1, yy: 1, zz: 9}}\njoints: {f: "
        "{type: fixed, parent: base, child: foot}, ",
    )
    assert parse(text).notes == ()


def test_identification_goes_on_from_an_inertia_that_no_body_has() -> None:
    """It ends with one that a body has, and with the efforts that were measured."""
    robot = Robot(parse(arm(entry(np.diag([0.0004, 0.0018, 0.05])))))
    state, ddu = random_motion(robot, 40, seed=1)
    result = identify(robot, state, ddu, robot.inverse_dynamics(state, ddu))
    link = link_of("l", result.values[:10])
    assert not impossibility(link.inertia, 1e-9)
    about_axis = link.inertia[1, 1] + link.mass * (link.com[0] ** 2 + link.com[2] ** 2)
    assert about_axis == pytest.approx(0.0118, rel=1e-3)
