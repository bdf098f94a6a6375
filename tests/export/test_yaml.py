"""Any file that loads becomes a description file, and that is the same robot to 1e-12."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given

from hybrid_dynamics_core import Robot, load, shipped_robots
from hybrid_dynamics_core.description.model import RobotDescription
from hybrid_dynamics_core.export import to_urdf, to_yaml
from hybrid_dynamics_core.formats.reader import parse_description
from tests.cli.calling import call
from tests.export.test_round_trip import FORMS, everything, write
from tests.generated.case import Case
from tests.generated.robots import STATES, examples, robots
from tests.generated.test_closure_laws import margin
from tests.sampling import swept

SAME = 1e-12  # relative: link frames are turned back and forth by products of rotations


@pytest.fixture(autouse=True, scope="module")
def _python_kernels() -> Iterator[None]:
    """Each robot is asked a question or two: compiling would take longer."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HYBRID_DYNAMICS_KERNELS", "python")
        yield


def read_back(machine: Robot) -> Robot:
    return Robot(parse_description(to_yaml(machine), file="back.yaml"))


def facts(description: RobotDescription) -> dict:
    """Names, limits, drives, idle joints: what has to be the same to the last letter and digit."""
    joints = {}
    for name, joint in description.joints.items():
        bounds = (joint.effort_limit, joint.velocity_limit, joint.power_limit)
        joints[name] = (joint.type, joint.parent, joint.child, joint.limits, bounds)
    closures = {c.name: (c.kind, c.link_a, c.link_b, c.assembly) for c in description.closures}
    return {
        "name": description.name,
        "base": description.base,
        "joints": joints,
        "order": list(joints),
        "links": {*description.links} - {description.base},
        "frames": {*description.frames},
        "parts": {*description.parts},
        "payloads": {name: on for name, (on, _) in description.payloads.items()},
        "closures": closures,
        "loops": {name: vars(loop) for name, loop in description.loops.items()},
        "active": description.active,
        "idle": description.idle,
        "active_set": description.active_set,
        "mimics": {name: dict(m.multipliers) for name, m in description.mimics.items()},
        "effects": {n: e for n, e in description.effects.items() if e != type(e)()},
        "actuators": dict(description.actuators),
        "reference": dict(description.reference),
    }


def assert_same(one: np.ndarray, other: np.ndarray, tolerance: float = SAME) -> None:
    """To the tolerance, relative to the largest number, or to one where all are smaller."""
    scale = max(1.0, float(np.abs(one).max(initial=0.0)))
    assert np.abs(one - other).max(initial=0.0) <= tolerance * scale


def assert_same_robot(machine: Robot, back: Robot) -> None:
    assert facts(back.description) == facts(machine.description)
    assert (back.drives, back.idle) == (machine.drives, machine.idle)
    du = 0.3 + 0.1 * np.arange(len(machine.active))
    one, other = machine.close(machine.reference, du), back.close(back.reference, du)
    assert_same(one.s, other.s)
    for a, b in zip(machine.minimal_form(one), back.minimal_form(other), strict=True):
        assert_same(a, b)
    M, again = machine.minimal_form(one)[0], back.minimal_form(other)[0]
    assert np.abs(M - again).max() <= SAME * np.abs(M).max()
    a, b = (robot.inverse_dynamics(s, -du) for robot, s in ((machine, one), (back, other)))
    assert_same(a, b)
    a, b = (robot.forward_kinematics(s) for robot, s in ((machine, one), (back, other)))
    assert_same(a.position, b.position)
    assert_same(a.rotation, b.rotation)


@pytest.mark.parametrize("form", ["shipped", "urdf", *FORMS])
@pytest.mark.parametrize("name", swept(shipped_robots(), ("five_bar",)))
def test_a_file_of_any_format_becomes_a_description(name: str, form: str, tmp_path: Path) -> None:
    machine = load(name)
    if form == "urdf":
        file = tmp_path / "tree.urdf"
        file.write_text(to_urdf(machine), encoding="utf-8")
        machine = load(file)
    elif form != "shipped":
        machine = load(write(machine, form, tmp_path))
    assert_same_robot(machine, read_back(machine))


def test_one_of_each_comes_back() -> None:
    assert_same_robot(everything(), read_back(everything()))


@examples(8)
@given(robots(), STATES)
def test_a_random_robot_comes_back(case: Case, seed: int) -> None:
    back = read_back(case.robot)
    assert facts(back.description) == facts(case.robot.description)
    s, du, ddu = case.somewhere(seed), case.rates(seed), case.rates(seed + 1)
    one, other = case.robot.close(s[: case.n], du), back.close(s[: case.n], du)
    m = margin(case, s)
    assume(m > 1e-2)
    assert_same(one.s, other.s, SAME / m)
    a, b = (robot.inverse_dynamics(x, ddu) for robot, x in ((case.robot, one), (back, other)))
    assert_same(a, b, SAME / m**3)


FIXED = """\
<robot name="my robot">
  <link name="base"/>
  <link name="arm one"><inertial><mass value="2"/><origin xyz="0.1 0 0" rpy="0.1 0.2 0.3"/>
    <inertia ixx="0.1" iyy="0.2" izz="0.25" ixy="0.01" ixz="0" iyz="0"/></inertial></link>
  <link name="plate"><inertial><mass value="3"/><origin xyz="0 0.1 0" rpy="0 0 1"/>
    <inertia ixx="0.1" iyy="0.2" izz="0.25" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="true"/>
  <joint name="1e3" type="revolute"><parent link="base"/><child link="arm one"/>
    <origin xyz="0 0 1" rpy="0.4 1.5707963267948966 0.2"/><axis xyz="0 0.6 0.8"/>
    <limit lower="-1" upper="2" effort="60" velocity="3"/></joint>
  <joint name="bolts" type="fixed"><parent link="arm one"/><child link="plate"/>
    <origin xyz="0.2 0 0" rpy="0.3 0 0"/></joint>
  <joint name="pins" type="fixed"><parent link="plate"/><child link="true"/>
    <origin xyz="0 0 0.3"/></joint>
</robot>
"""


def test_fixed_links_and_strange_names_come_back(tmp_path: Path) -> None:
    file, out = tmp_path / "fixed.urdf", tmp_path / "fixed.yaml"
    file.write_text(FIXED, encoding="utf-8")
    answer = call("import", str(file), "-o", str(out))
    assert answer.exit_code == 0, answer.output
    text = out.read_text(encoding="utf-8")
    assert "'my robot' is called my_robot here" in text
    machine, back = load(file), load(out)
    assert set(back.description.parts) == {"plate", "true"}
    assert list(back.description.joints) == ["1e3"]
    for name in ("plate", "true"):
        one, other = machine.description.parts[name], back.description.parts[name]
        assert_same(one.inertia, other.inertia)
        assert one.mass == other.mass
    state, again = machine.close([0.7], [0.3]), back.close([0.7], [0.3])
    assert_same(machine.minimal_form(state)[0], back.minimal_form(again)[0])
    assert_same(machine.inverse_dynamics(state, [2.0]), back.inverse_dynamics(again, [2.0]))


def test_a_written_file_can_be_edited_and_is_not_replaced(tmp_path: Path) -> None:
    out = tmp_path / "edited.yaml"
    assert call("import", "five_bar", "-o", str(out)).exit_code == 0
    text = out.read_text(encoding="utf-8")
    assert max(map(len, text.splitlines())) <= 120
    assert call("import", "five_bar", "-o", str(out)).exit_code == 2
    assert call("import", str(out), "-o", str(out), "--overwrite").exit_code == 2
    assert call("import", "five_bar", "-o", str(out), "--overwrite").exit_code == 0
    written = call("import", "five_bar").stdout
    assert written == text
    assert call("export", str(out), "--format", "yaml").stdout.endswith(text.partition("\n")[2])


def test_numbers_and_texts_keep_every_digit() -> None:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "a.yaml"
        file.write_text(to_yaml(everything()), encoding="utf-8")
        assert load(file).description.source == everything().description.source
