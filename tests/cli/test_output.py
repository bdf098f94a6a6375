"""What the command prints of a robot: parts, limits that are cut, values beyond them, tables."""

from __future__ import annotations

import io
import json
import re
from pathlib import Path
from types import SimpleNamespace

import pytest

from hybrid_dynamics_cli.output import line_width, table
from hybrid_dynamics_cli.verbs.view import acceleration_note
from hybrid_dynamics_core import load
from tests.cli.calling import call, data_of
from tests.sampling import swept

LIFT = """\
format: 1
name: lift
links:
  base: {}
  crank: {mass: 10, com: [0.4, 0, 0], inertia: {rod: {axis: x, length: 0.8}}}
  barrel: {mass: 4, com: [0.2, 0, 0], inertia: {rod: {axis: x, length: 0.4}}}
  rod: {mass: 2, com: [-0.2, 0, 0], inertia: {rod: {axis: x, length: 0.4}}}
  bucket: {mass: 1, inertia: {sphere: {radius: 0.1}}}
  cap: {}
joints:
  q1: {type: revolute, parent: base, child: crank, origin: {rpy: [pi/2, 0, 0]}, axis: z}
  q2: {type: revolute, parent: base, child: barrel,
       origin: {xyz: [0.3, 0, -0.5], rpy: [pi/2, 0, 0]}, axis: z, limits: [0, 1.1]}
  stroke: {type: prismatic, parent: barrel, child: rod, origin: {xyz: [0.4, 0, 0]}, axis: x,
           limits: [0, 0.95]}
  mount: {type: fixed, parent: crank, child: bucket, origin: {xyz: [0.8, 0, 0]}}
  lid: {type: fixed, parent: bucket, child: cap}
loops:
  lift: {type: A, base: base, arm: crank, k1: barrel, k2: rod,
         pin: {rod: [0, 0, 0], crank: [0.6, 0, 0]}, assembly: clockwise}
active: [stroke]
end_effector: {link: bucket}
reference: {stroke: 0.1}
"""

PLAIN = """\
format: 1
name: plain
links:
  base: {}
  bar: {mass: 1, com: [0.2, 0, 0]}
joints:
  q: {type: revolute, parent: base, child: bar, axis: z, limits: [-2, 2]}
active: [q]
end_effector: {link: bar}
"""


@pytest.fixture
def lift(tmp_path: Path) -> str:
    place = tmp_path / "lift.yaml"
    place.write_text(LIFT, encoding="utf-8")
    return str(place)


@pytest.mark.parametrize("verb", ["check", "info"])
def test_links_fixed_to_others_are_reported(verb: str, lift: str) -> None:
    output = call(verb, lift).output
    assert "6 links in 4 bodies" in output
    assert "bucket, cap (without a mass) are part of crank" in output
    parts = data_of(verb, lift)["parts"]
    assert parts == {
        "bucket": {"part_of": "crank", "mass": 1.0},
        "cap": {"part_of": "crank", "mass": 0.0},
    }
    assert "6 links," in call(verb, "five_bar").output


def test_names_of_parts_are_drawn(lift: str, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    place = tmp_path / "lift.svg"
    assert call("check", lift, "--draw", str(place), "--names", "all").exit_code == 0
    assert "crank, bucket, cap" in place.read_text(encoding="utf-8")


def test_masses_are_reported_with_what_is_fixed_to_a_body(lift: str) -> None:
    links = data_of("info", lift)["links"]
    assert links["crank"]["mass"] == 11.0
    assert links["crank"]["com"] == pytest.approx([(10 * 0.4 + 0.8) / 11, 0.0, 0.0])
    assert re.search(r"^crank +11 +0.436364 +0 +0$", call("info", lift).output, re.MULTILINE)


def test_which_links_a_joint_ties_and_inertias_are_reported() -> None:
    answer = data_of("info", "forging_chu2020")
    output = call("info", "forging_chu2020").output
    joints = {entry["name"]: (entry["parent"], entry["child"]) for entry in answer["coordinates"]}
    assert (joints["q12"], joints["q2"]) == (("l11", "l12"), ("l1", "l2"))
    assert re.search(r"^q12 +l11 +l12$", output, re.MULTILINE)
    rod = 50.6 * 0.7**2 / 12  # l2, across its axis
    assert answer["links"]["l2"]["inertia"] == [
        [0, 0, 0],
        [0, pytest.approx(rod), 0],
        [0, 0, pytest.approx(rod)],
    ]
    assert re.search(rf"^l2 +0 +{rod:.6g} +{rod:.6g}$", output, re.MULTILINE)
    assert "Ixy" not in output  # all zero
    assert "inertia" not in call("info", "staicu2015").output


@pytest.mark.parametrize("verb", ["check", "info"])
def test_a_limit_that_the_loop_cuts_is_reported(verb: str, lift: str) -> None:
    text = Path(lift).read_text(encoding="utf-8")
    assert "limits: [0, 1.1]" in text  # of q2, which follows
    free = Path(lift).with_name("free.yaml")
    free.write_text(text.replace("limits: [0, 1.1]", "limits: [-3, 3]"), encoding="utf-8")
    most = load(free).limits[0, 1]  # where crank and cylinder are in line
    closes = f"its loop closes from 0 to {most:.6g} m"
    followed = "limits of joints that follow it leave it from 0 to 0.249827 m"
    for place, reason in ((str(free), closes), (lift, followed)):
        note = f"stroke: the file allows 0 to 0.95 m; {reason}"
        assert f"note: {note}" in call(verb, place).output
        assert note in data_of(verb, place)["notes"]
    assert "the file allows" not in call(verb, "excavator").output


@pytest.mark.parametrize("verb", ["fk", "id", "fd"])
def test_values_beyond_a_limit_are_noted_and_answered(verb: str, lift: str) -> None:
    """Limits bind no model: the answer stays, with a word on stderr, of passive joints too."""
    result = call(verb, lift, "-u", "0.3", "--json")
    assert result.exit_code == 0
    led, follows = result.stderr.splitlines()
    assert led == "note: stroke = 0.3 m is beyond its limit 0.249827 m"
    assert re.fullmatch(r"note: q2 = 1.1\d+ rad is beyond its limit 1.1 rad", follows)
    _, entry = json.loads(result.stdout)["beyond_limits"]
    assert (entry["name"], entry["limit"]) == ("q2", 1.1)
    within = call(verb, lift, "-u", "0.1", "--json")
    assert not within.stderr
    assert json.loads(within.stdout)["beyond_limits"] == []


def test_a_seed_beyond_a_limit_is_noted() -> None:
    result = call("ik", "ankle", "--position", "0", "0", "0", "--axes", "x", "--seed", "q_L=0.7")
    assert "note: q_L = 0.7 rad is beyond its limit 0.6 rad" in result.stderr


def test_modes_without_a_picture_are_refused(lift: str) -> None:
    result = call("check", lift, "--modes")
    assert result.exit_code == 2
    assert "give --draw FILE too" in result.output


def test_modes_tell_where_the_end_effector_is() -> None:
    robot = load("five_bar")
    places = [
        robot.forward_kinematics(mode.state).position.tolist()
        for mode in robot.assembly_modes(robot.reference)
    ]
    assert [mode["position"] for mode in data_of("branches", "five_bar")["modes"]] == places
    assert "x, y, z of end_effector in base" in call("branches", "five_bar").output


@pytest.mark.parametrize("name", ["forging_chu2020", "staicu2015", "excavator", "gough"])
def test_modes_name_the_loops_in_which_they_differ_and_fit_a_terminal(name: str) -> None:
    output = call("branches", name).output
    branches = [mode["branch"] for mode in data_of("branches", name)["modes"]]
    heads = [line for line in output.splitlines() if line.startswith("mode ")]
    head = " ".join(heads).split()
    assert "singularity" in head
    for loop in branches[0]:
        ways = {branch[loop] for branch in branches}
        assert (loop in head) == (len(ways) > 1)
        assert all(way in output for way in ways)
    assert max(map(len, output.splitlines())) <= 80


def test_what_is_the_same_everywhere_is_reported_once() -> None:
    """Across the plane of a planar mechanism a coordinate is constant: no column, no rows of it."""
    modes = call("branches", "excavator").output
    reach = call("workspace", "five_bar", "--samples", "500").output
    assert "y [m]" not in modes
    assert "in all of them: y = 0 m" in modes
    assert "est z" not in reach
    assert "z = 0.04 m everywhere" in reach
    assert "smallest y" in reach
    assert "y [m]" in call("branches", "gough").output


def test_a_wide_table_goes_on_below_beside_its_first_column() -> None:
    columns = [f"column_{k}" for k in range(12)]
    head = ["name", *columns]
    row = ["first", *map(float, range(12))]
    blocks = [block.splitlines() for block in table(head, [row]).split("\n\n")]
    assert len(blocks) > 1
    names = []
    for lines in blocks:
        assert [line.split()[0] for line in lines] == ["name", "-----", "first"]
        assert max(map(len, lines)) <= 80
        names += lines[0].split()[1:]
    assert names == columns
    # What fits is not broken.
    assert table(head[:3], [row[:3]], break_before=2).count("name") == 1


def test_what_goes_on_below_is_no_lone_unit() -> None:
    columns = [f"column_{k}" for k in range(7)]
    head = ["name", *columns]
    row = ["first", *map(float, range(7))]
    assert len(table(head, [row]).split("\n\n")) == 1
    blocks = table([*head, "unit"], [[*row, "N m"]]).split("\n\n")
    heads = [block.splitlines()[0].split() for block in blocks]
    assert heads == [head[:-1], ["name", "column_6", "unit"]]


@pytest.mark.parametrize("name", swept(["forging_chu2020", "excavator", "gough", "staicu2015"]))
def test_efforts_and_their_parts_are_one_table(name: str) -> None:
    still = [f"{joint}=-0.1234567" for joint in load(name).active]
    text = call("id", name, "--du", ",".join(still), "--ddu", ",".join(still)).output
    assert text.count("active joint") == 1
    assert text.splitlines()[0].split()[2:4] == ["effort", "unit"]


@pytest.mark.parametrize(
    ("words", "what"),
    [
        (("check", "--draw", "{}.svg"), "picture of the robot"),
        (("check", "--modes", "--draw", "{}.svg"), "picture of the assembly modes"),
        (("branches", "--draw", "{}.svg"), "picture of the assembly modes"),
        (("workspace", "--samples", "50", "--draw", "{}.svg"), "map"),
        (("simulate", "--seconds", "0.02", "--save", "{}.csv"), "the motion"),
        (("export", "-o", "{}.urdf"), "URDF"),
        (
            ("bag", "make", "{}", "--seconds", "0.02", "--robot"),
            "20 messages on /hybrid_dynamics/active_joint_states",
        ),
    ],
    ids=lambda value: "-".join(value[:2]) if isinstance(value, tuple) else "",
)
def test_a_written_file_is_reported_in_one_form(
    words: tuple[str, ...], what: str, tmp_path: Path
) -> None:
    out = str(tmp_path / "out")
    verb, *more = [word.format(out) for word in words]
    arguments = ["five_bar", *more]
    if verb == "bag":
        arguments = [*more, "five_bar"]
    path = next(word for word in more if word.startswith(out))
    assert f"written: {path} ({what})" in call(verb, *arguments).output.splitlines()


@pytest.mark.parametrize("name", ["forging_chu2020", "staicu2015", "excavator", "gough"])
def test_what_a_robot_is_fits_a_terminal(name: str) -> None:
    assert max(map(len, call("info", name).output.splitlines())) <= 80


def test_the_end_of_a_motion_is_reported_once() -> None:
    output = call("simulate", "excavator", "--seconds", "1").output
    assert output.count("stick_cylinder reached its lower limit 0.32") == 1
    assert "energy error " in output


def test_units_of_a_picture_are_those_of_the_joints(lift: str, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    place = tmp_path / "fall.svg"
    assert call("simulate", lift, "--seconds", "0.05", "--draw", str(place)).exit_code == 0
    text = place.read_text(encoding="utf-8")
    assert all(label in text for label in ("u [m]", "u' [m/s]", "tau [N]"))


def test_one_is_reported_in_the_singular(lift: str) -> None:
    text = LIFT.replace("active: [stroke]", "active: [stroke, q1]")
    Path(lift).write_text(text, encoding="utf-8")
    assert "1 degree of freedom; name 1" in call("check", lift).output


def test_branches_tell_where_and_which_mode_the_robot_is_in() -> None:
    machine = load("forging_chu2020")
    answer = data_of("branches", "forging_chu2020", "-u", "q12=0.2")
    u = [*machine.reference[:1], 0.2, *machine.reference[2:]]
    assert answer["u"] == dict(zip(machine.active, u, strict=True))
    branches = [mode["branch"] for mode in answer["modes"] if mode["own"]]
    state = machine.close(list(answer["u"].values()))
    assert branches == [dict(state.branch)]
    lines = call("branches", "forging_chu2020", "-u", "q12=0.2").output.splitlines()
    assert "q12 = 0.2 m" in lines[0]
    (marked,) = (line for line in lines if line[1:2] == "*")
    assert "counterclockwise  counterclockwise" in marked
    assert [state.branch[loop] for loop in ("theta_1", "theta_2")] == ["counterclockwise"] * 2
    assert any(
        line.startswith("*: the robot's own mode; x, y, z of end_effector in base")
        for line in lines
    )


@pytest.mark.parametrize("verb", ["fk", "id", "fd", "branches"])
def test_values_beyond_a_limit_are_reported_by_every_verb(verb: str, lift: str) -> None:
    arguments = (verb, lift, "-u", "stroke=-0.05")
    assert "note: stroke = -0.05 m is beyond its limit 0 m" in call(*arguments).stderr
    beyond = json.loads(call(*arguments, "--json").stdout)["beyond_limits"]
    assert [entry["name"] for entry in beyond] == ["stroke"]


def test_a_reference_far_from_where_the_named_mode_closes_is_reported(lift: str) -> None:
    path = Path(lift)
    angle = data_of("fk", lift)["coordinates"]["q1"]
    near = LIFT.replace("{stroke: 0.1}", f"{{stroke: 0.1, q1: {angle + 0.5}}}")
    far = LIFT.replace("{stroke: 0.1}", f"{{stroke: 0.1, q1: {angle + 1.5}}}")
    path.write_text(near, encoding="utf-8")
    assert "another assembly mode" not in call("check", lift).output
    path.write_text(far, encoding="utf-8")
    output = " ".join(call("check", lift).output.split())
    note = r"note: q1 is .* rad in the reference, and its loop closes at .* rad"
    assert re.search(f"{note}: is another assembly mode", output)


def test_degrees_beyond_a_limit_are_named_as_they_are_written(lift: str) -> None:
    arm = Path(lift).with_name("arm.yaml")
    arm.write_text(PLAIN, encoding="utf-8")
    note = "beyond its limit 2 rad; 30 degrees are written 30*deg"
    assert note in call("fk", str(arm), "-u", "30").output
    assert "degrees" not in call("fk", str(arm), "-u", "3").output


def test_a_robot_without_loops_is_not_said_to_close_them(lift: str) -> None:
    arm = Path(lift).with_name("arm.yaml")
    arm.write_text(PLAIN, encoding="utf-8")
    last_line = call("check", str(arm)).output.splitlines()[-1]
    assert last_line == "The description is right; it has no loops."


def test_a_file_that_is_named_without_its_suffix_gets_a_hint(
    lift: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(Path(lift).parent)
    result = call("check", "lift")
    assert result.exit_code == 2
    assert "(did you mean 'lift.yaml'?)" in result.output


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            ("id", "--ddu", "stroke=0,1"),
            "decimals are written with a point (did you mean 'stroke=0.1'?)",
        ),
        (
            ("ik", "--position", "0,5", "0", "1"),
            "decimals are written with a point: 0.5, if 0,5 is one number",
        ),
    ],
)
def test_decimal_commas_are_named_as_such(
    arguments: tuple[str, ...], words: str, lift: str
) -> None:
    verb, *others = arguments
    result = call(verb, lift, *others)
    assert result.exit_code == 2
    assert words in " ".join(result.output.split())


def test_joints_that_a_target_leaves_open_are_named() -> None:
    position = ("ik", "five_bar", "--position", "-0.05", "0.3", "0", "--axes", "x,y")
    assert "left near the seed: q_T" in call(*position).output
    assert "left near the seed" not in call("ik", "type_c", "--position", "0.9", "0", "1.6").output


@pytest.mark.parametrize("is_causal", [True, False])
def test_a_lag_is_in_milliseconds(is_causal: bool) -> None:
    track = SimpleNamespace(is_causal=is_causal, causal_lag=0.0995, smoother="a spline")
    note = acceleration_note(track)  # type: ignore[arg-type]  # of a recording
    assert "99.5 ms" in note


class Terminal(io.StringIO):
    """A terminal that is written to."""

    def isatty(self) -> bool:
        """It is one."""
        return True


@pytest.mark.parametrize(("columns", "expected"), [("130", 130), ("40", 80)])
def test_tables_have_the_width_of_the_terminal(
    columns: str, expected: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file or another program gets lines of 80 letters at any time."""
    monkeypatch.setenv("COLUMNS", columns)
    assert line_width() == 80
    monkeypatch.setattr("sys.stdout", Terminal())
    assert line_width() == expected
    head = [f"column {k}" for k in range(12)]
    wide = table(head, [[0.5] * len(head)])
    assert wide.count("\n\n") == (expected == 80)
