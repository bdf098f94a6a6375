"""Parameters of a file get other values in a call: as if the file were written with them."""

from __future__ import annotations

import copy
import json
import pickle
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import InputError, load
from hybrid_dynamics_core.ground.file_options import RobotFile, file_options
from tests.cli.calling import call
from tests.sampling import examples

LENGTHS = st.floats(0.15, 0.25)
ARM = """\
format: 1
name: arm
parameters:
  crank: 0.2
  rod: 2*crank
links:
  base: {}
  a: {mass: 2, com: [crank/2, 0, 0], inertia: {rod: {axis: x, length: crank}}}
  b: {mass: 1, com: [rod/2, 0, 0], inertia: {rod: {axis: x, length: rod}}}
joints:
  p: {type: revolute, parent: base, child: a, axis: y}
  q: {type: revolute, parent: a, child: b, axis: y, origin: {xyz: [crank, 0, 0]}}
active: [p, q]
end_effector: {link: b, xyz: [rod, 0, 0]}
"""


@pytest.fixture(name="arm")
def arm_file(tmp_path: Path) -> Path:
    file = tmp_path / "arm.yaml"
    file.write_text(ARM, encoding="utf-8")
    return file


def holding(robot) -> list[float]:
    state = robot.close([0.3, 0.4])
    return robot.inverse_dynamics(state, [0.1, -0.2]).tolist()


@examples(16)
@given(crank=LENGTHS)
def test_a_value_of_the_call_is_as_good_as_one_of_the_file(
    tmp_path_factory: pytest.TempPathFactory, crank: float
) -> None:
    folder = tmp_path_factory.mktemp("arm")
    file, written = folder / "arm.yaml", folder / "written.yaml"
    file.write_text(ARM, encoding="utf-8")
    written.write_text(ARM.replace("crank: 0.2", f"crank: {crank!r}"), encoding="utf-8")
    assert holding(load(file, parameters={"crank": crank})) == holding(load(written))


def test_expressions_and_numbers_of_numpy_are_values(arm: Path) -> None:
    one = load(arm, parameters={"crank": "30*cm", "rod": "crank + 0.1"})
    other = load(arm, parameters={"crank": np.float64(0.3), "rod": 0.4})
    np.testing.assert_allclose(holding(one), holding(other), rtol=1e-14)
    assert any("30*cm, as given in the call" in note for note in one.description.notes)


def test_shipped_robots_have_parameters_too() -> None:
    robot = load("five_bar", parameters={"crank": 0.2})
    assert load("five_bar").description.frames.keys() == robot.description.frames.keys()
    assert load("five_bar").limits.tolist() == robot.limits.tolist()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"parameters": {"crnk": 1.0}}, "no parameter 'crnk' (did you mean 'crank'?)"),
        ({"parameters": {"crank": None}}, "parameters: crank is None"),
        ({"parameters": ["crank"]}, "expected values by name"),
        ({"xacro_args": {"a": 1}}, "xacro_args: "),
        ({"search_path": "/nowhere/at/all"}, "there is no folder '/nowhere/at/all'"),
    ],
)
def test_what_the_file_does_not_have_is_refused(arm: Path, given: dict, words: str) -> None:
    with pytest.raises(InputError) as caught:
        load(arm, **given)
    assert words in str(caught.value)


def test_other_formats_have_no_parameters(tmp_path: Path) -> None:
    file = tmp_path / "arm.urdf"
    file.write_text('<robot name="a"><link name="base"/></robot>', encoding="utf-8")
    with pytest.raises(InputError, match="description files"):
        load(file, parameters={"crank": 1.0})


def test_a_name_with_options_can_be_copied_and_sent(arm: Path) -> None:
    name = RobotFile(str(arm), file_options({"crank": 0.3}))
    for twin in (copy.copy(name), copy.deepcopy(name), pickle.loads(pickle.dumps(name))):  # noqa: S301
        assert twin == str(arm)
        assert twin.options == name.options
        assert holding(load(twin)) == holding(load(arm, parameters={"crank": 0.3}))


def test_every_verb_sets_parameters(arm: Path) -> None:
    words = ("id", str(arm), "-u", "0.3,0.4", "--json")
    one = call(*words, "--set", "crank=30*cm", "--set", "rod=0.4")
    state = load(arm, parameters={"crank": 0.3, "rod": 0.4}).close([0.3, 0.4])
    tau = load(arm, parameters={"crank": 0.3, "rod": 0.4}).inverse_dynamics(state, [0, 0])
    assert list(json.loads(one.stdout)["tau"].values()) == pytest.approx(tau.tolist(), rel=1e-9)
    assert json.loads(call(*words).stdout) != json.loads(one.stdout)


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["--set", "crank"], "expected NAME=VALUE"),
        (["--set", "crank=1", "--set", "crank=2"], "given twice"),
        (["--set", "crnk=1"], "--set: "),
        (["--xacro-arg", "a=1"], "expected NAME:=VALUE"),
        (["--search-path", "/nowhere/at/all"], "no folder"),
    ],
)
def test_a_wrong_option_is_told(arm: Path, words: list[str], text: str) -> None:
    answer = call("info", str(arm), *words)
    assert answer.exit_code == 2
    assert text in answer.output


def test_a_recording_knows_what_its_robot_was_read_with(arm: Path, tmp_path: Path) -> None:
    pytest.importorskip("rosbags")
    from hybrid_dynamics_ros.bags.provenance import robot_of

    bag = tmp_path / "bag"
    made = call(
        "bag", "make", str(bag), "--robot", str(arm), "--seconds", "1", "--set", "crank=0.3"
    )
    assert made.exit_code == 0, made.output
    assert holding(robot_of(bag)) == holding(load(arm, parameters={"crank": 0.3}))
    answer = call("bag", "report", str(bag), "--set", "crank=0.3")
    assert (answer.exit_code, "name the robot too" in answer.output) == (2, True)
