"""The command as people and programs call it: what it prints, what it says of mistakes, how it ends."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from importlib import resources
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from hybrid_dynamics_cli.app import VERBS
from hybrid_dynamics_core import Robot, load, shipped_robots
from tests.cli.calling import call

U = "0,0.10,0.15,30*deg"
BROKEN = "format: 1\nname: broken\nlinks:\n  base: {}\n  arm: {mass: -1}\n"


def told(*arguments: str) -> dict[str, Any]:
    """What a verb prints with --json."""
    result = call(*arguments, "--json")
    assert result.exit_code == 0, result.output
    answer: dict[str, Any] = json.loads(result.stdout)
    return answer


def test_every_verb_is_listed_and_has_help() -> None:
    overview = call("--help").output
    for verb in VERBS:
        assert verb in overview
        if verb == "bag" and find_spec("rosbags") is None:  # says what to install: test_extras.py
            continue
        page = call(verb, "--help")
        assert page.exit_code == 0
        assert "Example" in page.output or "--help" in page.output


@pytest.mark.parametrize("name", shipped_robots())
def test_every_shipped_robot_is_right(name: str) -> None:
    answer = told("check", name)
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
    fk = told("fk", forging.name, "-u", U, "--du", "q1=0.1,q22=0.02")
    assert fk["position"] == forging.forward_kinematics(state).position.tolist()
    assert fk["coordinates"] == dict(zip(forging.coordinates, state.s.tolist(), strict=True))
    assert fk["twist"] == (forging.jacobian(state) @ du).tolist()
    efforts = told("id", forging.name, "-u", U, "--du", "q1=0.1,q22=0.02", "--ddu", "0,0.3,0,0")
    tau = forging.inverse_dynamics(state, ddu)
    assert list(efforts["tau"].values()) == tau.tolist()
    back = told(
        "fd",
        forging.name,
        "-u",
        U,
        "--du",
        "q1=0.1,q22=0.02",
        "--tau",
        ",".join(map(repr, tau.tolist())),
    )
    assert list(back["ddu"].values()) == pytest.approx(ddu.tolist(), abs=1e-9)


def test_inverse_kinematics_finds_back(forging: Robot) -> None:
    target = forging.forward_kinematics(forging.close([0.4, 0.12, 0.16, 0.0])).position
    answer = told("ik", forging.name, "--position", *map(repr, target.tolist()), "--all")
    assert answer["status"] == "SOLVED"
    assert len(answer["solutions"]) == 2
    for solution in answer["solutions"]:
        found = forging.forward_kinematics(forging.close(list(solution.values()))).position
        assert found == pytest.approx(target, abs=1e-9)


def test_no_solution_ends_with_1() -> None:
    result = call("ik", "forging_chu2020", "--position", "5", "5", "5")
    assert result.exit_code == 1
    assert "out of reach: the nearest found is" in result.output


def test_what_is_left_to_a_target_has_its_units() -> None:
    arguments = (
        "ik",
        "forging_chu2020",
        "--position",
        "9",
        "0",
        "0",
        "--quaternion",
        "0",
        "0",
        "0",
        "1",
    )
    assert re.search(
        r"the nearest found is [\d.]+ m and [\d.]+ rad \([\d.]+ deg\) away", call(*arguments).output
    )
    told = json.loads(call(*arguments, "--json").stdout)
    assert told["position_error"] > 1.0
    assert 0.0 < told["angle_error"] <= np.pi
    position = json.loads(call(*arguments[:6], "--json").stdout)
    assert position["angle_error"] is None
    assert position["position_error"] == position["residual"]


def test_the_columns_of_an_effort_add_up(tmp_path: Path) -> None:
    """With friction and a spring; both kinds of output."""
    text = (
        resources.files("hybrid_dynamics_core")
        .joinpath("robots/forging_chu2020.yaml")
        .read_text(encoding="utf-8")
    )
    data = yaml.safe_load(text)
    data["joints"]["q12"]["friction"] = {"viscous": 2000, "coulomb": 300}
    data["joints"]["q1"]["spring"] = {"stiffness": 50, "rest": 0.1}
    (tmp_path / "loaded.yaml").write_text(yaml.safe_dump(data), encoding="utf-8")
    arguments = ("id", str(tmp_path / "loaded.yaml"), "--du", "q12=0.05,q1=0.4", "--ddu", "q12=0.1")
    answer = told(*arguments)
    parts = ("M_ddu", "C_du", "G", "passive")
    for name, tau in answer["tau"].items():
        assert sum(answer[part][name] for part in parts) == pytest.approx(
            tau, rel=1e-12, abs=1e-9
        )  # rounding of sums
    assert all(list(answer[part]) == list(answer["tau"]) == list(answer["M"]) for part in parts)
    assert answer["M"]["q1"]["q12"] == answer["M"]["q12"]["q1"]
    assert answer["passive"]["q12"] == pytest.approx(
        2000 * 0.05 + 300, rel=1e-2
    )  # Coulomb friction is smoothed
    lines = {
        line.split()[0]: line.split()
        for line in call(*arguments).output.splitlines()
        if line.startswith("q")
    }
    effort, *columns = (float(word) for word in [lines["q12"][k] for k in (1, *range(3, 7))])
    assert sum(columns) == pytest.approx(effort, abs=1e-3 * abs(effort))  # six digits each


def test_frame_and_modes() -> None:
    answer = told("fk", "excavator", "--frame", "bucket")
    assert answer["frame"] == "bucket"
    assert len(told("branches", "five_bar")["modes"]) == len(
        load("five_bar").assembly_modes(load("five_bar").reference)
    )


def test_workspace_is_told_and_drawn(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    maps = [tmp_path / "plane.svg", tmp_path / "over.png"]
    answer = told(
        "workspace",
        "five_bar",
        "--samples",
        "2000",
        "--range",
        "q_T=0:30*deg",
        "--draw",
        str(maps[0]),
    )
    found = load("five_bar").workspace(2000, ranges={"q_T": (0.0, np.pi / 6)})
    assert list(answer["extents"].values()) == found.extents.tolist()
    assert answer["shares"] == {"OK": 1.0, "OPEN": 0.0, "SINGULAR": 0.0, "BEYOND": 0.0}
    assert answer["smallest_singularity"]["loop"] == "tip"
    far = answer["extremes"]["y"][1]
    assert far["position"][1] == answer["extents"]["y"][1]
    assert far["limit"] == pytest.approx(0.0, abs=1e-3)  # with both cranks at their limits
    assert far["joint"] in ("q_L", "q_R", "q_T")
    text = call(
        "workspace", "five_bar", "--samples", "500", "--over", "q_L,q_R", "--draw", str(maps[1])
    ).output
    assert "reachable                 100.0 %" in text
    assert "Of the map over q_L and q_R; all other active joints are held." in text
    assert all(place.stat().st_size > 10_000 for place in maps)


def test_a_map_is_told_as_it_is_drawn(tmp_path: Path) -> None:
    """The other joints stay where the map has them, in every sample."""
    pytest.importorskip("matplotlib")
    arguments = ("workspace", "five_bar", "--samples", "500", "--over", "q_L,q_R", "-u", "q_T=0.2")
    answer = told(*arguments, "--plot", str(tmp_path / "over.png"))
    assert answer["held"] == {"q_T": 0.2}
    assert answer["ranges"]["q_T"] == [0.2, 0.2]
    ends = [end for axis in answer["extremes"].values() for end in axis]
    assert ends
    assert all(end["u"]["q_T"] == 0.2 for end in [*ends, answer["smallest_singularity"]])
    slice_ = load("five_bar").workspace(500, held={"q_T": 0.2})
    assert list(answer["extents"].values()) == slice_.extents.tolist()
    mixed = call(*arguments, "--range", "q_T=0:0.3", "--draw", str(tmp_path / "again.png"))
    assert "--held" not in mixed.output
    assert "q_T has a range too" in mixed.output


@pytest.mark.parametrize("verb", ["check", "branches", "workspace", "simulate"])
def test_pictures_are_asked_for_by_one_word_or_the_other(verb: str) -> None:
    page = call(verb, "--help").output
    assert "--draw, --plot FILE" in page
    assert ".pdf" in page


def test_what_is_only_rounding_is_not_printed() -> None:
    """Solutions are settled to 1e-9, the nearest joints of a target out of reach to fewer digits."""
    near = call("ik", "forging_chu2020", "--position", "9", "0", "0").output
    assert re.search(r"nearest: q1 = 0 rad", near)
    reached = call("ik", "forging_chu2020", "--position", "0.32", "0.38", "1.12").output
    assert "left to the target: less than 1e-09 m" in reached
    for output in (near, reached, call("fk", "forging_chu2020", "--du", "q1=1").output):
        assert not re.search(r"-0(?![.\d])|\de-1\d (rad|m)\b", output), output


def test_a_twist_is_called_by_its_parts() -> None:
    text = call("fk", "forging_chu2020", "--du", "q1=1").output
    assert re.search(r"angular velocity +0  0  1  rad/s", text)
    assert re.search(r"linear velocity +\S+  \S+  \S+  m/s", text)


def test_nothing_to_reach_ends_with_1(tmp_path: Path) -> None:
    text = (
        resources.files("hybrid_dynamics_core")
        .joinpath("robots/five_bar.yaml")
        .read_text(encoding="utf-8")
    )
    place = (
        tmp_path / "held.yaml"
    )  # the reference alone is within the limits of p_L, and it is no sample
    place.write_text(
        text.replace(
            "xyz: [crank, 0, 0]}, axis: z}",
            "xyz: [crank, 0, 0]}, axis: z, limits: [-1.3931, -1.3925]}",
            1,
        ),
        encoding="utf-8",
    )
    result = call("workspace", str(place), "--samples", "20", "--json")
    assert result.exit_code == 1
    answer = json.loads(result.stdout)
    assert answer["shares"]["BEYOND"] == 1.0
    assert answer["extremes"] == {}
    assert answer["extents"]["x"] == [None, None]
    assert (
        "beyond a limit or stroke  100.0 %"
        in call("workspace", str(place), "--samples", "20").output
    )


def test_assembly_modes_are_drawn(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    place = tmp_path / "modes.svg"
    answer = told("branches", "type_c", "--draw", str(place))
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
    ("arguments", "code", "words"),
    [
        (("fk", "forging"), 2, "did you mean 'forging_chu2020'?"),
        (("fk", "missing.yaml"), 2, "missing.yaml"),
        (("fk", "forging_chu2020", "-u", "0,1"), 2, "2 values; expected 4, for q1, q12, q22, q4"),
        (
            ("fk", "forging_chu2020", "-u", "q99=1"),
            2,
            "'q99' is not an active joint; they are q1, q12, q22, q4",
        ),
        (("fk", "forging_chu2020", "-u", "q12=much"), 2, "'q12=much'"),
        (("fk", "forging_chu2020", "-u", "q12=0.1,0.2"), 2, "either all values by name, or none"),
        (("fk", "forging_chu2020", "-u", "q12=3"), 1, "theta_1"),
        (("fk", "forging_chu2020", "--frame", "wrist"), 2, "there is no frame 'wrist'"),
        (("fk", "forging_chu2020", "-u", "q12=1e400"), 2, "q12 is inf"),
        (("ik", "forging_chu2020", "--position", "a", "0", "0"), 2, "'a'"),
        (
            (
                "ik",
                "forging_chu2020",
                "--position",
                "0",
                "0",
                "1",
                "--quaternion",
                "1",
                "1",
                "0",
                "0",
            ),
            2,
            "1, 1, 0, 0 has the norm 1.41421; expected 1 to 0.001; divide it by 1.41421",
        ),
        (("check", "ankle", "--draw", "nowhere/a.svg"), 2, "there is no folder nowhere"),
        (("workspace", "ankle", "--range", "q_L"), 2, "expected NAME=LOW:HIGH"),
        (("workspace", "ankle", "--range", "q_L=0:1:2"), 2, "expected NAME=LOW:HIGH"),
        (("workspace", "ankle", "--range", "q_L=-9:9"), 2, "within its limits [-0.6, 0.6]"),
        (("workspace", "ankle", "--over", "q_L,q_R"), 2, "give --draw FILE too"),
        (("workspace", "ankle", "-u", "0,0", "--draw", "a.svg"), 2, "give --over A,B too"),
        (("workspace", "ankle", "--samples", "0"), 2, "0 is not in the range"),
        (
            ("workspace", "ankle", "--samples", "9", "--draw", "a.svg", "--over", "q_L"),
            2,
            "expected two active joints",
        ),
        (("chekc", "ankle"), 2, "No such command"),
    ],
)
def test_mistakes_are_explained(arguments: tuple[str, ...], code: int, words: str) -> None:
    result = call(*arguments)
    assert result.exit_code == code
    assert words in result.output
    assert "Traceback" not in result.output


def test_a_wrong_file_is_told_with_its_line(tmp_path: Path) -> None:
    place = tmp_path / "broken.yaml"
    place.write_text(BROKEN, encoding="utf-8")
    result = call("check", str(place))
    assert result.exit_code == 1
    assert f"{place}:" in result.output


def test_links_without_a_mass_are_listed_and_no_fault(tmp_path: Path) -> None:
    """A forgotten mass is seen; the base, which does not move, needs none."""
    text = (
        resources.files("hybrid_dynamics_core")
        .joinpath("robots/five_bar.yaml")
        .read_text(encoding="utf-8")
    )
    place = tmp_path / "five_bar.yaml"
    given = "bar_L: {mass: 0.25, com: [bar/2, 0, 0], inertia: {box: {size: [bar, 0.02, 0.015]}}}"
    assert given in text
    place.write_text(text.replace(given, "bar_L: {}"), encoding="utf-8")
    assert told("check", "five_bar")["massless"] == []
    assert "without a mass" not in call("check", "five_bar").output
    answer = told("check", str(place))
    assert answer["ok"] is True
    assert answer["massless"] == ["bar_L"]
    output = call("check", str(place)).output
    assert "1 link without a mass" in output
    assert re.search(r"^bar_L +p_L +none: massless in the dynamics$", output, re.MULTILINE)
    assert "right: every loop closes" in output


def test_command_of_its_own() -> None:
    command = [sys.executable, "-m", "hybrid_dynamics_cli", "info", "five_bar"]
    answer = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "five_bar: 3 active of 5 coordinates, 1 loop," in answer.stdout
    assert not answer.stderr


@pytest.mark.parametrize("spelling", ["--draw", "--plot"])
def test_simulation_is_told_saved_and_drawn(spelling: str, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    table, figure = tmp_path / "fall.csv", tmp_path / "fall.png"
    answer = told(
        "simulate", "five_bar", "--seconds", "0.2", "--save", str(table), spelling, str(figure)
    )
    assert answer["relative_energy_error"] < 1e-6
    assert answer["residual"] < 1e-10
    assert table.read_text(encoding="utf-8").count("\n") == answer["samples"] + 1
    assert figure.read_bytes().startswith(b"\x89PNG")


def test_held_weight_stays(forging: Robot) -> None:
    answer = told("simulate", forging.name, "--seconds", "0.5", "--tau", "weight")
    assert list(answer["u"].values()) == pytest.approx(forging.reference.tolist(), abs=1e-8)


def test_export_is_read_by_another_engine(tmp_path: Path) -> None:
    pinocchio = pytest.importorskip("pinocchio")
    place = tmp_path / "excavator.urdf"
    assert call("export", "excavator", "--output", str(place)).exit_code == 0
    assert pinocchio.buildModelFromUrdf(str(place)).nv == len(load("excavator").coordinates)
    assert call("export", "excavator").stdout == place.read_text(encoding="utf-8")


@pytest.mark.parametrize("form", ["urdf+", "mjcf", "sdf", "robot.yaml"])
def test_export_is_taken_back(form: str, tmp_path: Path) -> None:
    """By `load`, whatever the file is called."""
    place = tmp_path / "excavator.yaml"
    assert call("export", "excavator", "--format", form, "-o", str(place)).exit_code == 0
    assert load(place).active == load("excavator").active


@pytest.mark.parametrize("more", [(), ("--overwrite",)])
def test_export_never_replaces_what_the_robot_is_read_from(
    tmp_path: Path, more: tuple[str, ...]
) -> None:
    """A file of one's own, the URDF that it names, and the URDF that is written beside a robot.yaml."""
    own, tree, over = tmp_path / "own.yaml", tmp_path / "tree.urdf", tmp_path / "over.yaml"
    source = resources.files("hybrid_dynamics_core").joinpath("robots/five_bar.yaml")
    own.write_text(source.read_text(encoding="utf-8"), encoding="utf-8")
    assert call("export", str(own), "-o", str(tree)).exit_code == 0
    active = ", ".join(load(tree).active)
    over.write_text(
        f"format: 1\nname: o\nurdf: tree.urdf\nactive: [{active}]\nend_effector: {{link:"
        " end_effector}\n"
    )
    before = [file.read_text(encoding="utf-8") for file in (own, tree, over)]
    (tmp_path / "link.yaml").symlink_to(own)
    for robot, form, output in (
        (own, "robot.yaml", own),
        (own, "sdf", tmp_path / "link.yaml"),
        (over, "mjcf", tree),
        (over, "robot.yaml", tmp_path / "tree.yaml"),
    ):
        result = call("export", str(robot), "--format", form, "-o", str(output), *more)
        assert result.exit_code == 2
        assert (
            "the robot is read from this file, which is not replaced; name another one"
            in result.output
        )
    assert before == [file.read_text(encoding="utf-8") for file in (own, tree, over)]
    assert not (tmp_path / "tree.yaml").exists()  # all files, or none


def test_export_replaces_files_where_that_is_asked_for(tmp_path: Path) -> None:
    urdf, pair = tmp_path / "a.urdf", tmp_path / "a.yaml"
    assert (
        call("export", "excavator", "--format", "urdf+", "-o", str(urdf)).output
        == f"written: {urdf} (URDF+)\n"
    )
    text = urdf.read_text(encoding="utf-8")
    arguments = ("export", "excavator", "--format", "robot.yaml", "-o", str(pair))
    refused = call(*arguments)
    assert refused.exit_code == 2
    assert (
        f"{urdf}: there is a file already; name another one, or give --overwrite" in refused.output
    )
    assert urdf.read_text(encoding="utf-8") == text
    assert not pair.exists()
    assert (
        call(*arguments, "--overwrite").output
        == f"written: {pair} (pairs of frames)\nwritten: {urdf} (URDF)\n"
    )
    assert "<loop" not in urdf.read_text(encoding="utf-8")


def test_a_pair_of_files_needs_a_place(tmp_path: Path) -> None:
    assert (
        "comes with a URDF beside it"
        in call("export", "excavator", "--format", "robot.yaml").output
    )
    wrong = call(
        "export", "excavator", "--format", "robot.yaml", "-o", str(tmp_path / "robot.urdf")
    )
    assert "expected a name that ends in .yaml" in wrong.output
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("term", ["60deg", "60 deg", "0+60deg"])
def test_degrees_without_a_sign_are_told_how_to_write(term: str) -> None:
    result = call("fk", "forging_chu2020", "-u", f"q4={term}")
    assert result.exit_code == 2
    assert f"did you mean '{term.replace(' ', '').replace('60deg', '60*deg')}'?" in " ".join(
        result.output.split()
    )


def test_branches_where_nothing_closes_tell_the_range() -> None:
    result = call("branches", "forging_chu2020", "-u", "q12=0.9")
    assert result.exit_code == 1
    assert "0 assembly modes" in result.output
    told_by_fk = call("fk", "forging_chu2020", "-u", "q12=0.9").output
    assert "q12 = 0.9 m is outside of [" in told_by_fk
    assert result.output.endswith(told_by_fk)
    answer = call("branches", "forging_chu2020", "-u", "q12=0.9", "--json")
    assert json.loads(answer.stdout)["modes"] == []


def test_what_fk_prints_ik_takes() -> None:
    pose = json.loads(call("fk", "forging_chu2020", "-u", "0.2,0.1,0.15,0.4", "--json").stdout)
    numbers = [f"{x:.6g}" for x in (*pose["position"], *pose["quaternion"])]
    result = call("ik", "forging_chu2020", "--position", *numbers[:3], "--quaternion", *numbers[3:])
    assert result.exit_code == 0, result.output
    assert re.search(r"left to the target: \S+e-0[678] m and \S+e-0[678] rad", result.output), (
        result.output
    )
    strict = call(
        "ik",
        "forging_chu2020",
        "--position",
        *numbers[:3],
        "--quaternion",
        *numbers[3:],
        "--tolerance",
        "1e-9",
    )
    assert strict.exit_code == 1
    wrong = call("ik", "forging_chu2020", "--position", *numbers[:3], "--tolerance", "-1")
    assert wrong.exit_code == 2
    assert "--tolerance" in wrong.output
    axes = call("ik", "forging_chu2020", "--position", *numbers[:3], "--axes", "x,z,ry")
    assert (axes.exit_code, "no --quaternion is given" in axes.output) == (2, True)
