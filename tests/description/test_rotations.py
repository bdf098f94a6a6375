"""A rotation is one, in whichever form a file writes it; SciPy is the oracle."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hybrid_dynamics_core import DescriptionError, load
from hybrid_dynamics_core.description.geometry import rotation_from_quaternion
from hybrid_dynamics_core.formats.reader import parse_description
from tests.sampling import examples

ROUNDING = 1e-14  # of sines and products
COMPONENTS = st.floats(-1.0, 1.0, allow_nan=False).filter(lambda value: abs(value) > 1e-3)
QUATERNIONS = st.tuples(COMPONENTS, COMPONENTS, COMPONENTS, COMPONENTS)


def robot_with(rotation: dict) -> dict:
    """A robot on which every place that can be turned is turned."""
    return {
        "format": 1,
        "name": "turned",
        "links": {
            "base": {},
            "a": {"mass": 1, "inertia": {"principal": [0.1, 0.2, 0.25], "frame": rotation}},
            "b": {"mass": 1},
        },
        "joints": {
            "q": {
                "type": "revolute",
                "parent": "base",
                "child": "a",
                "axis": "z",
                "origin": {"xyz": [0, 0, 1], **rotation},
            },
            "p": {"type": "revolute", "parent": "base", "child": "b", "axis": "z"},
        },
        "closures": {"weld": {"kind": "frame", "between": {"a": rotation, "b": [rotation]}}},
        "frames": {"mark": {"link": "a", **rotation}},
        "active": ["q"],
        "active_set": "motors",
        "end_effector": {"link": "a", **rotation},
    }


def parsed(rotation: dict):
    return parse_description(yaml.safe_dump(robot_with(rotation)), file="turned.yaml")


def forms_of(rotation: Rotation) -> list[dict]:
    turn = rotation.as_rotvec()
    axis_angle = {"axis": turn.tolist(), "angle": float(np.linalg.norm(turn))}
    return [
        {"rpy": rotation.as_euler("xyz").tolist()},
        {"quat": rotation.as_quat().tolist()},
        {"quat_xyzw": (-rotation.as_quat()).tolist()},
        {"matrix": rotation.as_matrix().tolist()},
        {"axis_angle": axis_angle},
    ]


@examples(24)
@given(QUATERNIONS)
def test_every_form_gives_one_rotation_everywhere(quaternion: tuple) -> None:
    rotation = Rotation.from_quat(quaternion)
    assume(abs(rotation.as_euler("xyz")[1]) < 1.5)  # SciPy warns of gimbal lock
    expected = rotation.as_matrix()
    inertia = expected @ np.diag([0.1, 0.2, 0.25]) @ expected.T
    for form in forms_of(rotation):
        description = parsed(form)
        assert not [note for note in description.notes if "taken: 1" in note]
        turned = [
            description.joints["q"].rotation,
            description.frames["mark"].rotation,
            description.frames["end_effector"].rotation,
            description.closures[0].rotation_a,
            description.closures[0].rotation_b,
        ]
        for matrix in turned:
            np.testing.assert_allclose(matrix, expected, atol=ROUNDING)
        np.testing.assert_allclose(description.links["a"].inertia, inertia, atol=ROUNDING)


def test_the_real_part_of_a_quaternion_is_the_last() -> None:
    rotation = parsed({"quat": [0, 0, 1, 1]}).joints["q"].rotation
    np.testing.assert_allclose(rotation, [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=ROUNDING)


def test_what_was_rounded_becomes_the_nearest_rotation_and_is_noted() -> None:
    matrix = [[0.866, -0.5, 0], [0.5, 0.866, 0], [0, 0, 1]]
    description = parsed({"matrix": matrix})
    rotation = description.joints["q"].rotation
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=ROUNDING)
    np.testing.assert_allclose(rotation, matrix, atol=1e-4)
    notes = [note for note in description.notes if "the nearest rotation is taken" in note]
    assert notes[0].startswith("turned.yaml:")


WRONG = {
    "two forms": ({"rpy": [0, 0, 1], "quat": [0, 0, 0, 1]}, "gives rpy and quat"),
    "no length": ({"quat": [0, 0, 0, 0]}, "has no length; expected [x, y, z, w]"),
    "three numbers": ({"quat": [0, 0, 1]}, "has 3 entries; expected 4"),
    "reflection": ({"matrix": [[0, 1, 0], [1, 0, 0], [0, 0, 1]]}, "is a reflection"),
    "skewed": ({"matrix": [[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]}, "is no rotation"),
    "no angle": ({"axis_angle": {"axis": "z"}}, "missing 'angle'"),
    "another order": ({"quat_wxyz": [1, 0, 0, 0]}, "did you mean 'quat_xyzw'?"),
    "a length": ({"quat": ["1*m", 0, 0, 1]}, "is a length"),
}


@pytest.mark.parametrize(("rotation", "words"), WRONG.values(), ids=WRONG.keys())
def test_what_is_no_rotation_is_refused(rotation: dict, words: str) -> None:
    with pytest.raises(DescriptionError) as caught:
        parsed(rotation)
    assert words in str(caught.value)
    assert caught.value.line


@pytest.mark.parametrize("indent", [None, 2, "\t"])
def test_a_json_file_is_a_description(indent: int | str | None, tmp_path: Path) -> None:
    data = robot_with({"axis_angle": {"axis": "y", "angle": "30*deg"}})
    del data["closures"]
    data["joints"]["q"]["power_limit"] = "2*kW"
    separators = (",", ":") if indent is None else None
    file = tmp_path / "robot.json"
    file.write_text(json.dumps(data, indent=indent, separators=separators), encoding="utf-8")
    robot = load(file)
    assert robot.description.joints["q"].rotation[0, 2] == pytest.approx(0.5)
    assert robot.power_limits.tolist() == [2000.0, math.inf]
    data["joints"]["q"]["power_limit"] = "2*kN"
    file.write_text(json.dumps(data, indent=2), encoding="utf-8")
    with pytest.raises(DescriptionError, match=r"robot.json:\d+: joints.q.power_limit: .*power"):
        load(file)


def test_a_joint_without_a_power_limit_has_none() -> None:
    assert parsed({"rpy": [0, 0, 0]}).joints["q"].power_limit == math.inf


@pytest.mark.parametrize("size", [1e-300, 1e-170, 1e160, 1e300])
def test_a_quaternion_may_have_any_length(size: float) -> None:
    """Neither its squares overflow, nor its inverse."""
    quaternion = np.array([0.1, -0.2, 0.3, 0.4])
    turn = rotation_from_quaternion(size * quaternion)
    expected = Rotation.from_quat(quaternion, scalar_first=True).as_matrix()
    assert turn == pytest.approx(expected, abs=ROUNDING)
