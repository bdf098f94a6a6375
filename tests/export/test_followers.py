"""Joints that follow several others: the laws of a linear map, and every format and back."""

from __future__ import annotations

import tempfile
from pathlib import Path

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import DescriptionError, Robot, load
from hybrid_dynamics_core.export import to_mjcf, to_urdf, to_urdf_plus
from hybrid_dynamics_core.formats.reader import parse_description
from tests.export.test_round_trip import FORMS, write
from tests.sampling import examples

TYPES = st.sampled_from(["revolute", "prismatic"])
NUMBER = st.floats(-2.0, 2.0).filter(lambda value: abs(value) > 0.05)
POSE = st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6)
JOINTS = ("a", "b", "c", "d", "e")


@st.composite
def trees(draw: st.DrawFn) -> tuple[str, dict[str, dict[str, float]], dict[str, float]]:
    """A tree of five joints as text, what two of them follow, and their offsets."""
    lines = ["format: 1", "name: tree", "links:"]
    for name in JOINTS:
        moments = "inertia: {xx: 0.02, yy: 0.03, zz: 0.04, xy: 0.001}"
        lines.append(f"  link_{name}: {{mass: 1.5, com: [0.1, 0.2, -0.1], {moments}}}")
    lines.append("joints:")
    multipliers = {
        "c": {"a": draw(NUMBER), "b": draw(NUMBER)},
        "e": {"c": draw(NUMBER), "d": draw(NUMBER), "b": draw(NUMBER)},
    }
    offsets = {"c": draw(NUMBER), "e": draw(NUMBER)}
    parents = ["base"]
    for name in JOINTS:
        x, y, z, *rpy = draw(POSE)
        origin = f"origin: {{xyz: [{x}, {y}, {z}], rpy: {rpy}}}"
        parent = draw(st.sampled_from(parents))
        ends = f"type: {draw(TYPES)}, parent: {parent}, child: link_{name}"
        lines.append(f"  {name}: {{{ends}, axis: [1, 2, 2], {origin}MIMIC_{name}}}")
        parents.append(f"link_{name}")
    lines += ["active: ACTIVE", "end_effector: {link: link_e}"]
    return "\n".join(lines), multipliers, offsets


def tied(tree: tuple[str, dict, dict]) -> Robot:
    text, multipliers, offsets = tree
    for name in JOINTS:
        mimic = ""
        if name in multipliers:
            joints = ", ".join(f"{key}: {value!r}" for key, value in multipliers[name].items())
            mimic = f", mimic: {{joints: {{{joints}}}, offset: {offsets[name]!r}}}"
        text = text.replace(f"MIMIC_{name}", mimic)
    return Robot(parse_description(text.replace("ACTIVE", "[a, b, d]")))


def free(tree: tuple[str, dict, dict]) -> Robot:
    text = tree[0]
    for name in JOINTS:
        text = text.replace(f"MIMIC_{name}", "")
    return Robot(parse_description(text.replace("ACTIVE", f"[{', '.join(JOINTS)}]")))


def rates(tree: tuple[str, dict, dict]) -> np.ndarray:
    """T (5, 3) of s' = T u'."""
    _, multipliers, _ = tree
    T = np.zeros((5, 3))
    T[[0, 1, 3], [0, 1, 2]] = 1.0
    for name in ("c", "e"):
        for source, multiplier in multipliers[name].items():
            T[JOINTS.index(name)] += multiplier * T[JOINTS.index(source)]
    return T


@examples(30)
@given(tree=trees(), seed=st.integers(0, 99))
def test_efforts_are_those_of_the_tree_through_the_map(tree: tuple, seed: int) -> None:
    rng = np.random.default_rng(seed)
    u, du, ddu = rng.uniform(-1.0, 1.0, (3, 3))
    machine, whole, T = tied(tree), free(tree), rates(tree)
    state = machine.close(u, du)
    order = [machine.coordinates.index(name) for name in JOINTS]
    s = state.s[order]
    for name in ("c", "e"):
        followed = sum(m * s[JOINTS.index(k)] for k, m in tree[1][name].items())
        assert s[JOINTS.index(name)] == pytest.approx(followed + tree[2][name], abs=1e-12)
    assert state.ds[order] == pytest.approx(T @ du, abs=1e-12)
    efforts = whole.inverse_dynamics(whole.close(s, T @ du), T @ ddu)
    expected = T.T @ efforts
    scale = max(1.0, float(np.abs(efforts).max()))
    assert machine.inverse_dynamics(state, ddu) == pytest.approx(expected, abs=1e-9 * scale)


@pytest.mark.parametrize("form", FORMS)
@examples(12)
@given(tree=trees())
def test_followers_of_several_come_back(form: str, tree: tuple) -> None:
    machine = tied(tree)
    with tempfile.TemporaryDirectory() as folder:
        back = load(write(machine, form, Path(folder)))
    assert back.active == machine.active
    for name, mimic in machine.description.mimics.items():
        other = back.description.mimics[name]
        assert dict(other.multipliers) == pytest.approx(dict(mimic.multipliers), rel=1e-15)
        assert other.offset == pytest.approx(mimic.offset, abs=1e-15)


ONE = """
{format: 1, name: one, active: [a], reference: {a: 0.3}, end_effector: {link: wheel}, links: {
  base: {}, arm: {mass: 1, com: [0.1, 0, 0]}, wheel: {mass: 1, com: [0, 0.1, 0.1]}}, joints: {
  a: {type: revolute, parent: base, child: arm, axis: y, limits: [-2, 2]},
  c: {type: revolute, parent: arm, child: wheel, axis: x, origin: {xyz: [0, 0, 1]},
    mimic: {joint: a, multiplier: -0.7, offset: 0.4}}}}
"""


@pytest.mark.parametrize("form", FORMS)
def test_a_follower_of_one_comes_back_with_its_offset(form: str, tmp_path: Path) -> None:
    machine = Robot(parse_description(ONE))
    back = load(write(machine, form, tmp_path))
    for u in (0.3, -1.0):
        assert back.close([u]).s == pytest.approx(machine.close([u]).s, abs=1e-14)
    mimic = back.description.mimics["c"]
    assert (dict(mimic.multipliers), mimic.offset) == ({"a": -0.7}, pytest.approx(0.4, abs=1e-14))


@examples(12)
@given(tree=trees())
def test_mujoco_holds_the_tendon_where_the_map_does(tree: tuple) -> None:
    machine = tied(tree)
    model = mujoco.MjModel.from_xml_string(to_mjcf(machine))
    data = mujoco.MjData(model)
    state = machine.close([0.3, -0.2, 0.4])
    for name, value in zip(machine.coordinates, state.s, strict=True):
        data.joint(name).qpos = value
    mujoco.mj_forward(model, data)
    assert data.ne == 2
    assert np.abs(data.efc_pos[:2]).max() < 1e-12


LEVEL = """\
<robot name="level"><link name="base"/>
<link name="arm"/><link name="fore"/>
<link name="hand"><inertial><origin xyz=".1 0 0"/><mass value="2"/>
<inertia ixx=".02" iyy=".02" izz=".02" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="wheel"/>
<joint name="q2" type="continuous"><parent link="base"/><child link="arm"/>
<axis xyz="0 1 0"/></joint>
<joint name="q3" type="continuous"><parent link="arm"/><child link="fore"/><origin xyz="0 0 1"/>
<axis xyz="0 1 0"/></joint>
<joint name="q4" type="continuous"><parent link="fore"/><child link="hand"/><origin xyz="1 0 0"/>
<axis xyz="0 1 0"/></joint>
<joint name="w" type="continuous" independent="false"><parent link="base"/><child link="wheel"/>
<axis xyz="0 1 0"/></joint>
<coupling name="tie"><predecessor link="{}"/><successor link="{}"/><ratio value="{}"/></coupling>
</robot>
"""


@pytest.mark.parametrize(
    ("predecessor", "successor", "ratio", "follower", "multipliers"),
    [
        ("fore", "hand", -1.0, "q4", {"q2": -1.0, "q3": -1.0}),  # fore carries hand
        ("fore", "wheel", 6.0, "w", {"q2": 6.0, "q3": 6.0}),  # a belt of generalized_rbda
        ("wheel", "fore", 0.5, "w", {"q2": 2.0, "q3": 2.0}),  # w is not independent
        ("arm", "wheel", -3.0, "w", {"q2": -3.0}),
    ],
)
def test_couplings_of_urdf_plus(
    tmp_path: Path,
    predecessor: str,
    successor: str,
    ratio: float,
    follower: str,
    multipliers: dict[str, float],
) -> None:
    file = tmp_path / "level.urdf"
    file.write_text(LEVEL.format(predecessor, successor, ratio))
    machine = load(file)
    ((name, mimic),) = machine.description.mimics.items()
    assert (name, dict(mimic.multipliers), mimic.offset) == (follower, multipliers, 0.0)
    text = to_urdf_plus(machine.description)
    assert "<coupling" in text
    assert "mimic:" not in text
    assert ("free in this file: " + follower in to_urdf(machine.description)) == (
        len(multipliers) > 1
    )


def test_a_hand_stays_level(tmp_path: Path) -> None:
    file = tmp_path / "level.urdf"
    file.write_text(LEVEL.format("fore", "hand", -1.0))
    machine = load(file)
    state = machine.close([0.3, -0.2, 0.1])
    assert machine.forward_kinematics(state, "hand").rotation == pytest.approx(np.eye(3), abs=1e-15)


WRONG = {
    "both": ("{joint: a, joints: {a: 1}}", "has joint and joints; expected one of them"),
    "none": ("{offset: 1}", "does not say what is followed"),
    "multiplier": ("{joints: {a: 1}, multiplier: 2}", "has joints and a multiplier"),
    "zero": ("{joints: {a: 0, b: 1}}", r"joints\.c\.mimic\.joints\.a: is 0"),
    "unknown": ("{joints: {a: 1, bb: 1}}", r"mimic\.joints\.bb: there is no joint 'bb'"),
    "cycle": ("{joints: {a: 1, e: 1}}", "follows itself"),
}


@pytest.mark.parametrize(("mimic", "words"), WRONG.values(), ids=WRONG.keys())
def test_a_wrong_follower(mimic: str, words: str) -> None:
    lines = ["format: 1", "name: tree", "links:"]
    lines += [f"  link_{name}: {{mass: 1}}" for name in JOINTS]
    lines.append("joints:")
    parent = "base"
    for name in JOINTS:
        tie = {"c": f", mimic: {mimic}", "e": ", mimic: {joint: c}"}.get(name, "")
        ends = f"type: revolute, parent: {parent}, child: link_{name}, axis: y"
        lines.append(f"  {name}: {{{ends}{tie}}}")
        parent = f"link_{name}"
    lines += ["active: [a, b, d]", "end_effector: {link: link_e}"]
    with pytest.raises(DescriptionError, match=words):
        parse_description("\n".join(lines))
