"""Slips on the command line of `bag`.

What is wrong is told, what to do too, and nothing is written or lost.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import load
from hybrid_dynamics_core.simulation import simulate
from tests.bags.calling import run

TOPIC = "hybrid_dynamics.active_joint_states.csv"
pytestmark = pytest.mark.usefixtures("python_kernels")


def made(path: Path, *words: object, robot: str = "five_bar") -> Path:
    run("make", path, "--robot", robot, "--seconds", 2, "--rate", 100, *words)
    return path


def test_a_name_that_is_no_joint_or_link_gets_a_hint_and_the_names_that_there_are(
    tmp_path: Path,
) -> None:
    recording, robot = made(tmp_path / "a"), load("five_bar")
    joint = robot.active[0]
    said = run("identify", recording, "--friction", f"{joint}x", code=2).stderr
    assert f"'{joint}x' is not a joint (did you mean '{joint}'?); they are " in said
    assert all(name in said for name in robot.description.joints)
    told = json.loads(
        run("identify", recording, "--friction", "none_such", "--json", code=2).stdout
    )
    assert told["error"]["kind"] == "InputError"
    said = run("identify", recording, "--links", f"nothing,{robot.description.base}", code=2).stderr
    assert "'nothing' is not a moving link" in said


def test_where_a_motion_shows_too_little_fewer_links_can_be_asked_for(tmp_path: Path) -> None:
    """At rest all efforts are of gravity, and no inertia shows."""
    robot = load("excavator")
    u = np.tile(robot.reference, (200, 1))
    rng = np.random.default_rng(1)
    effort = robot.inverse_dynamics(robot.close(u), np.zeros_like(u)) + rng.normal(
        0.0, 1.0, u.shape
    )
    np.savez(
        tmp_path / "rest.npz",
        time=np.arange(200) * 0.01,
        position=u,
        velocity=0.0 * u,
        effort=effort,
    )
    run("make", tmp_path / "rest", "--robot", "excavator", "--trajectory", tmp_path / "rest.npz")
    said = run("identify", tmp_path / "rest", code=1).stderr
    assert "the motion shows" in said
    name = robot.description.links.keys() - {robot.description.base}
    asked = said.split("as --links ")[1].split(",")[0]
    assert asked in name  # the example can be typed as it stands
    waves = made(tmp_path / "waves", "--noise", "effort=1")
    every = json.loads(run("identify", waves, "--json").stdout)["base"]
    link = next(iter(every)).split(".")[0]
    few = json.loads(run("identify", waves, "--json", "--links", link).stdout)
    assert {part.split(".")[0] for part in few["parameters"]} == {link}
    assert len(few["base"]) < len(every)


def test_tables_of_two_bags_do_not_mix_unless_that_is_said(tmp_path: Path) -> None:
    first, second, tables = (
        made(tmp_path / "a"),
        made(tmp_path / "b", "--seed", 4),
        tmp_path / "tables",
    )
    run("export", first, tables)
    before = (tables / TOPIC).read_bytes()
    assert "--overwrite" in run("export", second, tables, code=2).stderr
    assert (tables / TOPIC).read_bytes() == before
    (tables / "notes.txt").write_text("mine", encoding="utf-8")
    done = run("export", second, tables, "--overwrite")
    assert (tables / TOPIC).read_bytes() != before
    assert "before too: notes.txt" in done.stderr
    assert (tables / "notes.txt").read_text(encoding="utf-8") == "mine"
    assert "is a file" in run("export", second, tables / "notes.txt", code=2).stderr


@pytest.mark.parametrize("smooth", ["causal", "spline"])
def test_a_wrong_robot_ends_with_1_writes_nothing_and_does_not_block_the_right_one(
    tmp_path: Path, smooth: str
) -> None:
    recording, out = made(tmp_path / "a"), tmp_path / "out"
    said = run("process", recording, out, "--robot", "excavator", "--smooth", smooth, code=1).stderr
    assert "none of 200 samples can be used" in said
    assert "boom_cylinder, stick_cylinder, bucket_cylinder not named; named are " in said
    assert "is excavator the robot of this bag?" in said
    assert [entry.name for entry in tmp_path.iterdir()] == ["a"]
    run("process", recording, out, "--robot", "five_bar", "--smooth", smooth)
    assert out.is_dir()


def test_a_failure_names_its_bag_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    said = run("process", "nobag", "out", "--robot", "five_bar", code=2).stderr
    assert said.startswith("Error: nobag: there is no such file or folder; expected a recording")
    assert said.count("nobag") == 1
    Path("none.mcap").write_bytes(b"no recording")
    assert (
        run("process", "none.mcap", "out", "--robot", "five_bar", code=1).stderr.count("none.mcap")
        == 1
    )


def test_columns_that_count_for_nothing_are_counted_and_the_first_named(tmp_path: Path) -> None:
    robot = load("five_bar")
    simulate(robot, robot.reference, [0.4, -0.3, 0.1], None, (0.0, 0.05)).save(tmp_path / "a.csv")
    with (tmp_path / "a.csv").open(encoding="utf-8") as file:
        columns = file.readline().strip().split(",")
    used = [name for name in columns if name.split(".")[0] in ("time", *robot.active)]
    count = len(columns) - len([name for name in used if not name.endswith(".acceleration")])
    said = run(
        "make", tmp_path / "bag", "--robot", "five_bar", "--trajectory", tmp_path / "a.csv"
    ).stderr
    assert f"{count} columns not used: {robot.active[0]}.acceleration, " in said
    assert said.rstrip().endswith(f"and {count - 4} more")
