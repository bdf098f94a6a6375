"""Largest efforts and rates of joints: read, shown, and the same after every format."""

from __future__ import annotations

import json
import math
import tempfile
from pathlib import Path

import mujoco
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import DescriptionError, Robot, load
from hybrid_dynamics_core.export import to_mjcf, to_urdf
from hybrid_dynamics_core.formats.reader import parse_description
from tests.cli.calling import call
from tests.export.test_round_trip import FORMS, write
from tests.sampling import examples

ARM = """
format: 1
name: arm
links:
  upper: {{mass: 1, com: [0.1, 0, 0], inertia: {{xx: 0.01, yy: 0.01, zz: 0.01}}}}
  fore: {{mass: 1, com: [0.1, 0, 0], inertia: {{xx: 0.01, yy: 0.01, zz: 0.01}}}}
joints:
  q1: {{type: revolute, parent: base, child: upper, axis: z, effort_limit: {0},
       velocity_limit: {1}}}
  q2: {{type: prismatic, parent: upper, child: fore, axis: x, effort_limit: {2},
       velocity_limit: {3}}}
active: [q1, q2]
end_effector: {{link: fore}}
"""
BOUND = st.floats(1e-3, 1e8) | st.just(math.inf)


def yaml_number(value: float) -> str:
    return ".inf" if math.isinf(value) else repr(value)


def arm(bounds: list[float]) -> Robot:
    return Robot(parse_description(ARM.format(*map(yaml_number, bounds))))


@pytest.mark.parametrize("form", ["urdf", *FORMS])
@examples(24)
@given(bounds=st.lists(BOUND, min_size=4, max_size=4))
def test_bounds_come_back_to_the_last_digit(form: str, bounds: list[float]) -> None:
    machine = arm(bounds)
    with tempfile.TemporaryDirectory() as folder:
        if form == "urdf":
            file = Path(folder) / "arm.urdf"
            file.write_text(to_urdf(machine.description), encoding="utf-8")
        else:
            file = write(machine, form, Path(folder))
        back = load(file)
    assert back.effort_limits.tolist() == bounds[::2]
    assert back.velocity_limits.tolist() == bounds[1::2]


URDF = """\
<robot name="p"><link name="base"/>
<link name="a"><inertial><mass value="1"/><origin xyz="0.1 0 0"/>
<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="60" velocity="12"/></joint></robot>
"""


def of(folder: Path, limit: str) -> Robot:
    file = folder / "p.urdf"
    file.write_text(URDF.replace('lower="-1" upper="1" effort="60" velocity="12"', limit))
    return load(file)


def test_effort_and_velocity_of_a_urdf_are_kept_and_shown(tmp_path: Path) -> None:
    file = tmp_path / "p.urdf"
    file.write_text(URDF)
    machine = load(file)
    assert 'effort="60.0" velocity="12.0"' in to_urdf(machine.description)
    ranges = mujoco.MjModel.from_xml_string(to_mjcf(machine)).jnt_actfrcrange
    assert ranges.tolist() == [[-60.0, 60.0]]
    table = call("info", str(file)).stdout
    assert "j           60              N m  12            rad/s" in table
    shown = json.loads(call("info", str(file), "--json").stdout)
    (entry,) = shown["coordinates"]
    assert (entry["effort_limit"], entry["velocity_limit"]) == (60.0, 12.0)


def test_limits_that_say_nothing_are_noted(tmp_path: Path) -> None:
    machine = of(tmp_path, 'lower="0" upper="0" effort="0" velocity="-1"')
    assert machine.effort_limits.tolist() == [math.inf]
    assert machine.velocity_limits.tolist() == [math.inf]
    assert machine.limits.tolist() == [[-math.inf, math.inf]]
    notes = machine.description.notes
    assert any(
        "p.urdf: joints with the limits 0 and 0" in note and "j (line 5)" in note for note in notes
    )
    assert any(
        "p.urdf: joints with the effort 0, taken as not given: j (line 5)" in note for note in notes
    )
    assert any("with the velocity -1, taken as not given: j (line 5)" in note for note in notes)
    machine = of(tmp_path, 'lower="-1" upper="1" effort="inf" velocity="1e9"')
    assert machine.effort_limits.tolist() == machine.velocity_limits.tolist() == [math.inf]


def test_a_bound_is_above_zero() -> None:
    with pytest.raises(DescriptionError, match=r"joints\.q1\.effort_limit: is 0; expected a num"):
        arm([0.0, 1.0, 1.0, 1.0])
    with pytest.raises(DescriptionError, match=r"joints\.q2\.velocity_limit: is -2; expected"):
        arm([1.0, 1.0, 1.0, -2.0])
