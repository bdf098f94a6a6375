"""Limits of drives in code and units for other programs: exported, or named in a note."""

from __future__ import annotations

import io
import re
import zipfile
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_core.description.model import RobotDescription
from hybrid_dynamics_core.export import to_c, to_fmu, to_gepetto, to_ros2_control, to_urdf
from hybrid_dynamics_core.formats.c.limit_notes import EFFORTS, RATES, TABLES, limits_not_exported
from tests.limits.machines import crane
from tests.sampling import examples

JOINT = "arm_pitch"
ARM = "arm_pitch: {type: revolute,"
ARM_LIMITED = f"{ARM} velocity_limit: 2, acceleration_limit: 3, power_limit: 4000,"
LIFT = "axis: x, limits: [0, 0.6]}\n  barrel_2_pitch"
LIFT_TABLED = LIFT.replace("}", ", effort_table: {rate: [0, 1], effort: [50000, 20000]}}")
BOUNDS = {
    RATES: "velocity_limit",
    EFFORTS: "effort_limit",
    "accelerations": "acceleration_limit",
    "powers": "power_limit",
}


@pytest.fixture(scope="module")
def machine() -> Robot:
    return crane((ARM, ARM_LIMITED), (LIFT, LIFT_TABLED))


def limited(kinds: set[str]) -> RobotDescription:
    """The crane without limits, but for some kinds of one joint."""
    shipped = crane().description
    joint = replace(shipped.joints[JOINT], **{BOUNDS[kind]: 7.0 for kind in kinds})
    joints = {**shipped.joints, JOINT: joint}
    return replace(shipped, joints=joints, actuators={}, pumps={})


@examples(24)
@given(st.sets(st.sampled_from(sorted(BOUNDS))), st.sets(st.sampled_from([RATES, EFFORTS])))
def test_a_limit_stands_in_the_note_unless_it_is_exported(
    kinds: set[str], exported: set[str]
) -> None:
    note = limits_not_exported(limited(kinds), exported)
    for kind in BOUNDS:
        assert (f"{kind} ({JOINT})" in note) == (kind in kinds - exported)
    assert bool(note) == bool(kinds - exported)


def test_what_cylinders_and_pumps_have_stands_there_too(machine: Robot) -> None:
    note = limits_not_exported(machine.description)
    for part in ("lift_cylinder, boom_cylinder", "flows (lift_cylinder)", "pumps (main)"):
        assert part in note
    assert f"{TABLES} (lift_cylinder)" in note


def test_c_has_efforts_within_pressures(machine: Robot) -> None:
    texts = to_c(machine, ["close"])
    pattern = r"crane_effort_ranges\[\w+\]\[2\] = \{(.*?)\};"
    (text,) = re.findall(pattern, texts["crane.c"], re.DOTALL)
    ranges = np.reshape([float(part) for part in re.findall(r"-?\d[\d.e+]*", text)], (-1, 2))
    wanted = [machine.effort_ranges[name] for name in machine.active]
    np.testing.assert_array_equal(ranges, wanted)
    assert np.isfinite(machine.effort_limits).tolist() == [True, False]  # pressures alone


@pytest.mark.parametrize("file", ["header", "package", "unit"])
def test_the_rest_is_named(machine: Robot, file: str) -> None:
    if file == "header":
        text = to_c(machine, ["close"])["crane.h"]
    elif file == "package":
        text = to_ros2_control(machine)["README.md"]
    else:
        with zipfile.ZipFile(io.BytesIO(to_fmu(machine, "inverse_dynamics").content)) as unit:
            root = ElementTree.fromstring(unit.read("modelDescription.xml"))
            text = root.get("description", "")
    words = " ".join(text.split())
    for part in ("accelerations (arm_pitch)", "powers (arm_pitch)", "flows (lift_cylinder)"):
        assert part in words
    assert "pumps (main)" in words
    assert (f"{RATES} (" in words) == (file == "unit")  # elsewhere they are constants


def test_robots_without_such_limits_have_no_note() -> None:
    assert "not exported" not in to_c(load("five_bar"), ["close"])["five_bar.h"]


def test_urdf_has_accelerations(machine: Robot, tmp_path) -> None:
    file = tmp_path / "crane.urdf"
    file.write_text(to_urdf(machine.description))
    assert load(file).description.joints[JOINT].acceleration_limit == 3.0
    text = file.read_text().replace('acceleration="3.0"', 'acceleration="0"')
    file.write_text(text)
    back = load(file).description
    assert back.joints[JOINT].acceleration_limit == np.inf
    assert any("the acceleration 0, taken as not given" in note for note in back.notes)


def test_pairs_of_frames_keep_them(machine: Robot, tmp_path) -> None:
    pair = to_gepetto(machine.description)
    (tmp_path / "robot.yaml").write_text(pair.yaml)
    (tmp_path / "robot.urdf").write_text(pair.urdf)
    back = load(tmp_path / "robot.yaml").description
    one = machine.description
    assert (back.actuators, back.pumps) == (one.actuators, one.pumps)
    assert back.joints["lift_cylinder"].effort_table is not None
