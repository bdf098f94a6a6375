"""A file that names no assembly mode: its modes are shown, and nothing else is computed."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from hybrid_dynamics_core import DescriptionError, UndecidedModeError, load
from hybrid_dynamics_core.library import load_undecided
from tests.cli.calling import call, data_of, shipped_text


@pytest.fixture
def excavator(tmp_path: Path) -> str:
    """The shipped excavator without the reference joints that name the modes of two loops."""
    text = shipped_text("excavator")
    place = tmp_path / "open.yaml"
    place.write_text(
        re.sub(
            r"  (boom_pitch|stick_pitch|boom_barrel_pitch|stick_barrel_pitch): -?[\d.]+\n", "", text
        ),
        encoding="utf-8",
    )
    return str(place)


def test_the_message_says_where_the_joints_are_in_each_mode(excavator: str) -> None:
    with pytest.raises(UndecidedModeError) as caught:
        load(excavator)
    error = caught.value
    shipped = load("excavator")
    mode = shipped.close(shipped.reference).branch[error.loop]
    assert set(error.modes) == {"counterclockwise", "clockwise"}
    assert error.key == f"loops.{error.loop}"
    assert error.line is not None
    ways = dict(re.findall(r"(\w+) \((.*?)\)", error.problem))
    joints = dict(re.findall(r"(\w+) = (-?[\d.]+) rad", ways[mode]))
    assert len(joints) == 2
    state = shipped.close(shipped.reference)
    for name, value in joints.items():  # to four digits
        assert float(value) == pytest.approx(state.s[shipped.coordinates.index(name)], rel=1e-3)


def test_all_open_loops_are_reported_and_the_others_keep_their_mode(excavator: str) -> None:
    robot, undecided = load_undecided(excavator)
    shipped = load("excavator").close(load("excavator").reference).branch
    assert len({error.loop for error in undecided}) == 2
    decided = set(robot.loops) - {error.loop for error in undecided}
    branch = robot.close(robot.reference).branch
    for loop in decided:
        assert branch[loop] == shipped[loop]
    assert load_undecided("excavator")[1] == ()


@pytest.mark.sweep(sample="test_branches_lists_the_modes_without_one_of_its_own")
def test_branches_draws_the_modes_without_one_of_its_own(excavator: str, tmp_path: Path) -> None:
    answer = call("branches", excavator, "--draw", str(tmp_path / "modes.svg"))
    assert answer.exit_code == 0, answer.output
    assert "own" not in (tmp_path / "modes.svg").read_text(encoding="utf-8")


def test_branches_lists_the_modes_without_one_of_its_own(excavator: str) -> None:
    answer = call("branches", excavator)
    assert answer.exit_code == 0, answer.output
    assert answer.output.count("to be decided") == 2
    assert "own mode" not in answer.output
    answer = data_of("branches", excavator)
    assert len(answer["undecided"]) == 2
    assert not any(mode["own"] for mode in answer["modes"])
    assert len(answer["modes"]) == len(data_of("branches", "excavator")["modes"])


@pytest.mark.sweep(sample="test_branches_lists_the_modes_without_one_of_its_own")
def test_check_draws_them_and_yet_ends_with_1(excavator: str, tmp_path: Path) -> None:
    picture = tmp_path / "modes.png"
    answer = call("check", excavator, "--modes", "--draw", str(picture))
    assert answer.exit_code == 1
    assert "name one as assembly" in answer.output
    assert str(picture) in answer.output
    assert picture.stat().st_size > 0


def test_the_other_verbs_refuse_and_name_the_one_that_helps(excavator: str) -> None:
    answer = call("fk", excavator)
    assert answer.exit_code == 1
    assert f"hybrid-dynamics branches {excavator}" in answer.output


CHAIN = """\
format: 1
name: chain
links: {crank: {}, coupler: {}, rocker: {}, d: {}, e: {}}
joints:
  a: {type: revolute, parent: base, child: crank, axis: z}
  b: {type: revolute, parent: crank, child: coupler, axis: z, origin: {xyz: [0.4, 0, 0]}}
  c: {type: revolute, parent: base, child: rocker, axis: z, origin: {xyz: [1, 0, 0]}}
  f: {type: revolute, parent: rocker, child: d, axis: z, origin: {xyz: [0.4, 0, 0]}}
  g: {type: revolute, parent: base, child: e, axis: z, origin: {xyz: [1.3, -0.6, 0]}}
closures:
  first: {kind: planar, between: {coupler: [1.1, 0, 0], rocker: [0.8, 0, 0]}}
  second: {kind: planar, between: {d: [0.3, 0, 0], e: [0.3, 0, 0]}}
active: [a]
end_effector: {link: d, xyz: [0.3, 0, 0]}
"""


def test_a_loop_that_closes_in_one_mode_of_another_alone_is_shown_there(tmp_path: Path) -> None:
    """The first mode of the first loop takes the second out of reach: no fault of the geometry."""
    place = tmp_path / "chain.yaml"
    place.write_text(CHAIN, encoding="utf-8")
    robot, undecided = load_undecided(place)
    assert [error.loop for error in undecided] == ["first", "second"]
    assert robot.close(robot.reference).branch["first"] == undecided[0].modes[1]
    place.write_text(CHAIN.replace("-0.6, 0]", "-6, 0]"), encoding="utf-8")
    with pytest.raises(DescriptionError, match="second: does not close"):
        load_undecided(place)


TWO_LOOPS = """\
format: 1
name: two
links: {{base: {{}}, crank: {{}}, coupler: {{}}, rocker: {{}}, bar: {{}}, lever: {{}}}}
joints:
  q1: {{type: revolute, parent: base, child: crank, axis: z}}
  q2: {{type: revolute, parent: crank, child: coupler, origin: {{xyz: [0.3, 0, 0]}}, axis: z}}
  q3: {{type: revolute, parent: base, child: rocker, origin: {{xyz: [1, 0, 0]}}, axis: z}}
  q4: {{type: revolute, parent: rocker, child: bar, origin: {{xyz: [0.3, 0, 0]}}, axis: z}}
  q5: {{type: revolute, parent: base, child: lever, origin: {{xyz: [3, 0, 0]}}, axis: z}}
closures:
  first: {{kind: planar, between: {{coupler: [0.9, 0, 0], rocker: [0.8, 0, 0]}}}}
  second: {{kind: planar, between: {{bar: [{bar}, 0, 0], lever: [1.2, 0, 0]}}}}
active: [q1]
end_effector: {{link: rocker}}
reference: {{q1: 1}}
"""


def test_a_loop_that_closes_in_no_mode_comes_before_modes_to_decide(tmp_path: Path) -> None:
    """Naming the modes of the first loop would be no help."""
    file = tmp_path / "two.yaml"
    file.write_text(TWO_LOOPS.format(bar=0.2), encoding="utf-8")
    answer = call("check", str(file))
    assert answer.exit_code == 1
    assert f"{file}:12: closures.second: does not close at the reference" in answer.stderr
    assert "more than one way" not in answer.output
    file.write_text(TWO_LOOPS.format(bar=2.2), encoding="utf-8")
    assert "closures.first: closes in more than one way" in call("check", str(file)).stderr
