"""Friction, drives and springs of joints, however the joint is written: row, leg, module, URDF."""

from __future__ import annotations

from pathlib import Path

import pytest

from hybrid_dynamics_core import DescriptionError, Robot
from hybrid_dynamics_core.description import RobotDescription
from hybrid_dynamics_core.description.effects import JointEffect
from hybrid_dynamics_core.formats import read_description
from tests.description.robots import HEAD, parse
from tests.description.test_legs import LEGS, NUMBERS, PLATFORM, TAIL
from tests.description.test_modules import UPU, one

EFFECTS = (
    "friction: {viscous: 2*1.5, coulomb: 0.5}, drive: {rotor_inertia: 1e-4, gear_ratio: 100},"
    " spring: {rest: 0.1}"
)
EXPECTED = JointEffect(viscous=3.0, coulomb=0.5, rotor_inertia=1e-4, gear_ratio=100.0, rest=0.1)
ROWS = """\
links:
  base: {}
  upper: {mass: 1}
  lower: {mass: 1}
chain:
  convention: CONVENTION
  rows:
    - {joint: q1, child: upper, a: 0.3}
    - {joint: q2, child: lower, a: 0.2, EFFECTS}
active: [q1, q2]
end_effector: {link: lower}
"""


def rows(convention: str = "standard", effects: str = EFFECTS) -> str:
    return HEAD + ROWS.replace("CONVENTION", convention).replace("EFFECTS", effects)


def legs(effects: str = EFFECTS) -> str:
    slide = "limits: [-0.2, 0.3]"
    assert LEGS.count(slide) == 3
    return HEAD + NUMBERS + PLATFORM + LEGS.replace(slide, f"{slide}, {effects}") + TAIL


def module(name: str = "lambda_<leg>", effects: str = EFFECTS) -> str:
    return one("3-UPU", UPU).replace(
        "    parameters:", f"    joints: {{{name}: {{{effects}}}}}\n    parameters:"
    )


def urdf(folder: Path, dynamics: str) -> RobotDescription:
    joint = (
        '<joint name="q" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0'
        ' 1"/>'
    )
    text = (
        f'<robot name="r"><link name="base"/><link name="arm"/>{joint}\n{dynamics}</joint></robot>'
    )
    (folder / "r.urdf").write_text(text, encoding="utf-8")
    (folder / "r.yaml").write_text(
        HEAD + "urdf: r.urdf\nactive: [q]\nend_effector: {link: arm}\n", encoding="utf-8"
    )
    return read_description(folder / "r.yaml")


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_of_a_denavit_hartenberg_row(convention: str) -> None:
    assert dict(parse(rows(convention)).effects) == {"q2": EXPECTED}


@pytest.mark.parametrize("text", [legs(), module()], ids=["legs", "module"])
def test_of_the_joints_of_legs(text: str) -> None:
    robot = parse(text)
    assert dict(robot.effects) == dict.fromkeys(("lambda_A", "lambda_B", "lambda_C"), EXPECTED)
    effects = Robot(robot).loads.effects
    assert effects.viscous.tolist()[:4] == [3.0, 3.0, 3.0, 0.0]
    assert effects.armature[0] == pytest.approx(1.0)


def test_of_a_module_are_read_in_numbers_of_the_robot() -> None:
    """`height` of the module is not that of the robot, whose expressions mean the robot's."""
    text = module(effects="friction: {viscous: height}")
    robot = parse(text.replace("modules:", "parameters: {height: 11}\nmodules:"))
    assert robot.effects["lambda_B"].viscous == 11.0
    with pytest.raises(DescriptionError, match="height"):
        parse(text)


def test_of_a_urdf(tmp_path: Path) -> None:
    assert dict(urdf(tmp_path, '<dynamics damping="0.7" friction="0.2"/>').effects) == {
        "q": JointEffect(viscous=0.7, coulomb=0.2)
    }
    assert not urdf(tmp_path, "").effects
    with pytest.raises(DescriptionError, match=r"is -1; expected zero or positive") as caught:
        urdf(tmp_path, '<dynamics damping="-1"/>')
    assert (caught.value.line, Path(str(caught.value.file)).name) == (2, "r.urdf")


@pytest.mark.parametrize(
    ("text", "key", "words"),
    [
        (
            rows(effects="friction: {viscous: -1}"),
            "chain.rows[1].friction.viscous",
            "is -1; expected zero or positive",
        ),
        (rows(effects="frictions: {viscous: 1}"), "chain.rows[1].frictions", "unknown key"),
        (rows(effects="drive: {gear_ratio: 5}"), "chain.rows[1].drive", "missing 'rotor_inertia'"),
        (legs("friction: {smoothing: 0}"), "legs.leg_A.joints[2].friction.smoothing", "above zero"),
        (
            module(effects="friction: {coulomb: -1}"),
            "modules.m.joints.lambda_<leg>.friction.coulomb",
            "is -1",
        ),
        (
            module(effects="spring: {stiffness: soft}"),
            "modules.m.joints.lambda_<leg>.spring.stiffness",
            "soft",
        ),
        (module(effects="limits: [0, 1]"), "modules.m.joints.lambda_<leg>.limits", "unknown key"),
        (
            module("lambda_A"),
            "modules.m.joints.lambda_A",
            r"no joint 'lambda_A'.*known: .*lambda_<leg>",
        ),
    ],
)
def test_wrong_entries_name_file_line_and_key(text: str, key: str, words: str) -> None:
    with pytest.raises(DescriptionError, match=words) as caught:
        parse(text)
    assert (caught.value.key, caught.value.file) == (key, "small.yaml")
    line = text.splitlines()[(caught.value.line or 0) - 1]
    assert key.rpartition(".")[2] in line or key.rpartition(".")[2] in ("drive", "rows[1]")
