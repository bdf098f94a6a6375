"""The command as people and programs call it: results, mistakes, exit codes."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
import yaml

from hybrid_dynamics_cli.app import VERBS
from hybrid_dynamics_core import Robot, load, shipped_robots
from tests.cli.calling import call, call_line, data_of, shipped_text
from tests.sampling import swept

U = "0,0.10,0.15,30*deg"
BROKEN = "format: 1\nname: broken\nlinks:\n  base: {}\n  arm: {mass: -1}\n"


def test_every_verb_is_listed_and_has_help() -> None:
    overview = call("--help").output
    for verb in VERBS:
        assert verb in overview
        if verb == "bag" and find_spec("rosbags") is None:  # says what to install: test_extras.py
            continue
        page = call(verb, "--help")
        assert page.exit_code == 0
        assert "Example" in page.output or "--help" in page.output


@pytest.mark.parametrize("name", swept(shipped_robots()))
def test_every_shipped_robot_is_right(name: str) -> None:
    answer = data_of("check", name)
    robot = load(name)
    assert answer["ok"] is True
    assert answer["active"] == list(robot.active)
    assert [entry["name"] for entry in answer["coordinates"]] == list(robot.coordinates)
    text = call("check", name).output
    for coordinate in robot.coordinates:
        assert coordinate in text


def test_numbers_are_those_of_the_library(forging: Robot) -> None:
    u = np.array([0.0, 0.10, 0.15, np.pi / 6])
    du, ddu = np.array([0.1, 0.0, 0.02, 0.0]), np.array([0.0, 0.3, 0.0, 0.0])
    state = forging.close(u, du)
    fk = data_of("fk", forging.name, "-u", U, "--du", "q1=0.1,q22=0.02")
    assert fk["position"] == forging.forward_kinematics(state).position.tolist()
    assert fk["coordinates"] == dict(zip(forging.coordinates, state.s.tolist(), strict=True))
    assert fk["twist"] == (forging.jacobian(state) @ du).tolist()
    efforts = data_of("id", forging.name, "-u", U, "--du", "q1=0.1,q22=0.02", "--ddu", "0,0.3,0,0")
    tau = forging.inverse_dynamics(state, ddu)
    assert list(efforts["tau"].values()) == tau.tolist()
    values = ",".join(map(repr, tau.tolist()))
    motion = data_of("fd", forging.name, "-u", U, "--du", "q1=0.1,q22=0.02", "--tau", values)
    assert list(motion["ddu"].values()) == pytest.approx(ddu.tolist(), abs=1e-9)


def test_inverse_kinematics_finds_back(forging: Robot) -> None:
    target = forging.forward_kinematics(forging.close([0.4, 0.12, 0.16, 0.0])).position
    answer = data_of("ik", forging.name, "--position", *map(repr, target.tolist()), "--all")
    assert answer["status"] == "SOLVED"
    assert len(answer["solutions"]) == 2
    for solution in answer["solutions"]:
        state = forging.close(list(solution.values()))
        position = forging.forward_kinematics(state).position
        assert position == pytest.approx(target, abs=1e-9)


def test_no_solution_ends_with_1() -> None:
    result = call_line("ik forging_chu2020 --position 5 5 5")
    assert result.exit_code == 1
    assert "out of reach: the nearest found is" in result.output


def test_the_distance_to_a_target_has_its_units() -> None:
    position = "ik forging_chu2020 --position 9 0 0"
    pose = f"{position} --quaternion 0 0 0 1"
    distance = r"the nearest found is [\d.]+ m and [\d.]+ rad \([\d.]+ deg\) away"
    assert re.search(distance, call_line(pose).output)
    answer = json.loads(call_line(f"{pose} --json").stdout)
    assert answer["position_error"] > 1.0
    assert 0.0 < answer["angle_error"] <= np.pi
    answer = json.loads(call_line(f"{position} --json").stdout)
    assert answer["angle_error"] is None
    assert answer["position_error"] == answer["residual"]


def test_the_columns_of_an_effort_add_up(tmp_path: Path) -> None:
    """With friction and a spring; both kinds of output."""
    text = shipped_text("forging_chu2020")
    data = yaml.safe_load(text)
    data["joints"]["q12"]["friction"] = {"viscous": 2000, "coulomb": 300}
    data["joints"]["q1"]["spring"] = {"stiffness": 50, "rest": 0.1}
    (tmp_path / "loaded.yaml").write_text(yaml.safe_dump(data), encoding="utf-8")
    arguments = ("id", str(tmp_path / "loaded.yaml"), "--du", "q12=0.05,q1=0.4", "--ddu", "q12=0.1")
    answer = data_of(*arguments)
    parts = ("M_ddu", "C_du", "G", "passive")
    for name, tau in answer["tau"].items():
        total = sum(answer[part][name] for part in parts)
        assert total == pytest.approx(tau, rel=1e-12, abs=1e-9)  # rounding of sums
    for key in ("M", *parts):
        assert list(answer[key]) == list(answer["tau"])
    assert answer["M"]["q1"]["q12"] == answer["M"]["q12"]["q1"]
    friction = 2000 * 0.05 + 300
    assert answer["passive"]["q12"] == pytest.approx(friction, rel=1e-2)  # Coulomb: smoothed
    row = re.search(r"^q12 .*$", call(*arguments).output, re.MULTILINE)
    assert row is not None
    _, effort, _, *columns = row[0].split()
    total = sum(map(float, columns))
    assert total == pytest.approx(float(effort), abs=1e-3 * abs(float(effort)))  # six digits each


def test_frame_and_modes() -> None:
    answer = data_of("fk", "excavator", "--frame", "bucket")
    assert answer["frame"] == "bucket"
    robot = load("five_bar")
    modes = robot.assembly_modes(robot.reference)
    assert len(data_of("branches", "five_bar")["modes"]) == len(modes)


@pytest.mark.parametrize("verb", ["check", "branches", "workspace", "simulate"])
def test_pictures_are_asked_for_by_one_word_or_the_other(verb: str) -> None:
    page = call(verb, "--help").output
    assert "--draw, --plot FILE" in page
    assert ".pdf" in page


def test_what_is_only_rounding_is_not_printed() -> None:
    """Solutions are settled to 1e-9, the nearest joints of a target out of reach to fewer."""
    near = call_line("ik forging_chu2020 --position 9 0 0").output
    assert re.search(r"nearest: q1 = 0 rad", near)
    reached = call_line("ik forging_chu2020 --position 0.32 0.38 1.12").output
    assert "left to the target: less than 1e-09 m" in reached
    for output in (near, reached, call("fk", "forging_chu2020", "--du", "q1=1").output):
        assert not re.search(r"-0(?![.\d])|\de-1\d (rad|m)\b", output), output


def test_a_twist_is_called_by_its_parts() -> None:
    text = call("fk", "forging_chu2020", "--du", "q1=1").output
    assert re.search(r"angular velocity +0  0  1  rad/s", text)
    assert re.search(r"linear velocity +\S+  \S+  \S+  m/s", text)


def test_assembly_modes_are_drawn(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    place = tmp_path / "modes.svg"
    answer = data_of("branches", "type_c", "--draw", str(place))
    text = place.read_text(encoding="utf-8")
    assert answer["picture"] == str(place)
    assert len(answer["modes"]) == 2
    assert "luffing: clockwise" in text
    assert "luffing: counterclockwise" in text


def test_picture_is_drawn(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    place = tmp_path / "ankle.svg"
    assert call("check", "ankle", "--draw", str(place)).exit_code == 0
    assert place.read_text(encoding="utf-8").startswith("<?xml")


@pytest.mark.parametrize(
    ("line", "code", "words"),
    [
        ("fk forging", 2, "did you mean 'forging_chu2020'?"),
        ("fk missing.yaml", 2, "missing.yaml"),
        ("fk forging_chu2020 -u 0,1", 2, "2 values; expected 4, for q1, q12, q22, q4"),
        (
            "fk forging_chu2020 -u q99=1",
            2,
            "'q99' is not an active joint; they are q1, q12, q22, q4",
        ),
        ("fk forging_chu2020 -u q12=much", 2, "'q12=much'"),
        ("fk forging_chu2020 -u q12=0.1,0.2", 2, "either all values by name, or none"),
        ("fk forging_chu2020 -u q12=3", 1, "theta_1"),
        ("fk forging_chu2020 --frame wrist", 2, "there is no frame 'wrist'"),
        ("fk forging_chu2020 -u q12=1e400", 2, "q12 is inf"),
        ("ik forging_chu2020 --position a 0 0", 2, "'a'"),
        (
            "ik forging_chu2020 --position 0 0 1 --quaternion 1 1 0 0",
            2,
            "1, 1, 0, 0 has the norm 1.41421; expected 1 to 0.001; divide it by 1.41421",
        ),
        ("check ankle --draw nowhere/a.svg", 2, "there is no folder nowhere"),
        ("workspace ankle --range q_L", 2, "expected NAME=LOW:HIGH"),
        ("workspace ankle --range q_L=0:1:2", 2, "expected NAME=LOW:HIGH"),
        ("workspace ankle --range q_L=-9:9", 2, "within its limits [-0.6, 0.6]"),
        ("workspace ankle --over q_L,q_R", 2, "give --draw FILE too"),
        ("workspace ankle -u 0,0 --draw a.svg", 2, "give --over A,B too"),
        ("workspace ankle --samples 0", 2, "0 is not in the range"),
        ("workspace ankle --samples 9 --draw a.svg --over q_L", 2, "expected two active joints"),
        ("chekc ankle", 2, "No such command"),
    ],
)
def test_mistakes_are_explained(line: str, code: int, words: str) -> None:
    result = call_line(line)
    assert result.exit_code == code
    assert words in result.output
    assert "Traceback" not in result.output


def test_a_wrong_file_is_reported_with_its_line(tmp_path: Path) -> None:
    place = tmp_path / "broken.yaml"
    place.write_text(BROKEN, encoding="utf-8")
    result = call("check", str(place))
    assert result.exit_code == 1
    assert f"{place}:" in result.output


def test_links_without_a_mass_are_listed_and_no_fault(tmp_path: Path) -> None:
    """A forgotten mass is seen; the base, which does not move, needs none."""
    text = shipped_text("five_bar")
    place = tmp_path / "five_bar.yaml"
    given = "bar_L: {mass: 0.25, com: [bar/2, 0, 0], inertia: {box: {size: [bar, 0.02, 0.015]}}}"
    assert given in text
    place.write_text(text.replace(given, "bar_L: {}"), encoding="utf-8")
    assert data_of("check", "five_bar")["massless"] == []
    assert "without a mass" not in call("check", "five_bar").output
    answer = data_of("check", str(place))
    assert answer["ok"] is True
    assert answer["massless"] == ["bar_L"]
    output = call("check", str(place)).output
    assert "1 link without a mass" in output
    assert re.search(r"^bar_L +p_L +none: massless in the dynamics$", output, re.MULTILINE)
    assert "right: every loop closes" in output


def test_the_command_runs_as_a_process() -> None:
    command = [sys.executable, "-m", "hybrid_dynamics_cli", "info", "five_bar"]
    answer = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "five_bar: 3 active of 5 coordinates, 1 loop," in answer.stdout
    assert not answer.stderr


@pytest.mark.parametrize("spelling", ["--draw", "--plot"])
def test_simulation_is_reported_saved_and_drawn(spelling: str, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    table = tmp_path / "fall.csv"
    figure = tmp_path / "fall.png"
    files = ("--save", str(table), spelling, str(figure))
    answer = data_of("simulate", "five_bar", "--seconds", "0.2", *files)
    assert answer["relative_energy_error"] < 1e-6
    assert answer["residual"] < 1e-10
    assert table.read_text(encoding="utf-8").count("\n") == answer["samples"] + 1
    assert figure.read_bytes().startswith(b"\x89PNG")


FOLDING = """
format: 1
name: folding
links:
  base: {}
  crank: {mass: 1, inertia: {xx: 1, yy: 1, zz: 1}}
  coupler: {mass: 1}
  rocker: {mass: 1}
joints:
  q1: {type: revolute, parent: base, child: crank, axis: z}
  q2: {type: revolute, parent: crank, child: coupler, axis: z, origin: {xyz: [0.1, 0, 0]}}
  q3: {type: revolute, parent: base, child: rocker, axis: z, origin: {xyz: [0.3, 0, 0]}}
closures:
  bar: {kind: planar, between: {coupler: [0.3, 0, 0], rocker: [0.1, 0, 0]}}
active: [q1]
end_effector: {link: rocker}
reference: {q1: 1, q2: -1, q3: 1}
"""


def test_simulation_passes_change_points_where_asked(tmp_path: Path) -> None:
    file = tmp_path / "folding.yaml"
    file.write_text(FOLDING, encoding="utf-8")
    words = ("simulate", str(file), "--seconds", "0.6", "--du", "q1=-3")
    assert not data_of(*words)["completed"]
    answer = data_of(*words, "--through-change-points")
    assert answer["completed"]
    (event,) = answer["events"]
    assert event["kind"] == "passage"
    passage = event["passage"]
    assert passage["kind"] == "change point"
    assert passage["rates"]["q3"] == pytest.approx(-3.0, abs=1e-6)
    assert passage["other_rates"][0]["q3"] == pytest.approx(6.0, abs=1e-6)
    text = call(*words, "--through-change-points").output
    assert "loop 'bar' passed a change point, from mode" in text


def test_held_weight_stays(forging: Robot) -> None:
    answer = data_of("simulate", forging.name, "--seconds", "0.5", "--tau", "weight")
    assert list(answer["u"].values()) == pytest.approx(forging.reference.tolist(), abs=1e-8)


@pytest.mark.parametrize("term", ["60deg", "60 deg", "0+60deg"])
def test_degrees_without_a_sign_get_a_hint(term: str) -> None:
    result = call("fk", "forging_chu2020", "-u", f"q4={term}")
    assert result.exit_code == 2
    right = term.replace(" ", "").replace("60deg", "60*deg")
    assert f"did you mean '{right}'?" in " ".join(result.output.split())


def test_branches_where_nothing_closes_tell_the_range() -> None:
    result = call("branches", "forging_chu2020", "-u", "q12=0.9")
    assert result.exit_code == 1
    assert "0 assembly modes" in result.output
    fk_output = call("fk", "forging_chu2020", "-u", "q12=0.9").output
    assert "q12 = 0.9 m is outside of [" in fk_output
    assert result.output.endswith(fk_output)
    answer = call("branches", "forging_chu2020", "-u", "q12=0.9", "--json")
    assert json.loads(answer.stdout)["modes"] == []


def test_what_fk_prints_ik_takes() -> None:
    pose = json.loads(call("fk", "forging_chu2020", "-u", "0.2,0.1,0.15,0.4", "--json").stdout)
    numbers = [f"{x:.6g}" for x in (*pose["position"], *pose["quaternion"])]
    position_arguments = ("ik", "forging_chu2020", "--position", *numbers[:3])
    pose_arguments = (*position_arguments, "--quaternion", *numbers[3:])
    result = call(*pose_arguments)
    assert result.exit_code == 0, result.output
    errors = r"left to the target: \S+e-0[678] m and \S+e-0[678] rad"
    assert re.search(errors, result.output), result.output
    strict = call(*pose_arguments, "--tolerance", "1e-9")
    assert strict.exit_code == 1
    wrong = call(*position_arguments, "--tolerance", "-1")
    assert wrong.exit_code == 2
    assert "--tolerance" in wrong.output
    axes = call(*position_arguments, "--axes", "x,z,ry")
    assert axes.exit_code == 2
    assert "no --quaternion is given" in axes.output
