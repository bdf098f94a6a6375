"""The design procedure: robots from a few words are those of the papers; wrong words, one line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hybrid_dynamics_core import InputError, Robot, load
from hybrid_dynamics_core.design.procedure import (
    outcome_of,
    report_text,
    robot_text,
    usual_cycle,
)
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.kernels.run import VARIABLE
from hybrid_dynamics_core.sizing import read_catalogue, read_duty
from tests.cli.calling import call

FORGING_LINKS = (
    "yaw: length=0.3 mass=81.3; pitch: length=0.7 mass=50.6 at=135.56*deg;"
    " pitch: length=0.6 tail=0.2 mass=58.4 on=l2 at=-93.56*deg;"
    " roll: length=0.2 mass=73.1 radius=0.1"
)
FORGING_LOOPS = (
    "A: joint=q2 pivot=-0.7,0.3 pin=0.4,0 barrel=0.4 masses=25.6,5.7;"
    " A: joint=q3 pivot=0.2,0 pin=-0.2,0 barrel=0.4 masses=25.6,5.7;"
    " B: joint=q2 pivot=-0.2,0.3 masses=7.2,12.9;"
    " B: joint=q3 base=l32 pivot=0,0.2 carrier=0.2 masses=6.5,37.7"
)
CRANE = {"links": "yaw: length=0.5; pitch: length=0.6 at=40*deg", "name": "crane"}
LIFT = "A: joint=q2 pivot=0.3,0.1 pin=0.4,-0.1 barrel=0.45"


@pytest.fixture(autouse=True, scope="module")
def _without_compiler() -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(VARIABLE, "python")
        yield


def robot_of(*arguments: str, **parts: str) -> Robot:
    return Robot(parse_description(robot_text(*arguments, **parts)))


def test_the_forging_robot_comes_out_of_its_own_numbers() -> None:
    """Links, loops, dimensions and masses of Tables 1 and 2 give the shipped robot.

    Efforts are of 1e4 N; rounding of twelve written digits is left.
    """
    made = robot_of("III", FORGING_LINKS, FORGING_LOOPS)
    shipped = load("forging_chu2020")
    assert made.active == shipped.active
    assert {loop.type for loop in made.description.loops.values()} == {"A", "B"}
    rng = np.random.default_rng(1)
    for _ in range(3):
        u = shipped.reference + rng.uniform(-0.05, 0.05, 4)
        du, ddu = rng.normal(size=(2, 4))
        one, other = made.close(u, du), shipped.close(u, du)
        poses = [
            robot.forward_kinematics(state) for robot, state in ((made, one), (shipped, other))
        ]
        assert np.allclose(poses[0].position, poses[1].position, atol=1e-12)
        efforts = made.inverse_dynamics(one, ddu), shipped.inverse_dynamics(other, ddu)
        assert np.allclose(*efforts, rtol=1e-10, atol=1e-8)


def test_staicus_modules_come_out_of_their_own_numbers() -> None:
    angles = "angle=0,2*pi/3,-2*pi/3"
    upper = 0.75 / 3**0.5
    modules = (
        f"3-UPU: base_radius=0.6 platform_radius=0.2 height=0.8 twist=30*deg {angles};"
        f" 3-UPS/S: base_radius={upper!r} platform_radius={upper!r}"
        f" height={(1.5**2 - upper**2) ** 0.5!r} twist=60*deg {angles}"
    )
    made = robot_of("I", modules=modules)
    shipped = load("staicu2015")
    assert made.active == shipped.active
    u = np.array([0.02, -0.01, 0.03, 0.02, 0.01, -0.02])
    poses = [robot.forward_kinematics(robot.close(u)) for robot in (made, shipped)]
    assert np.allclose(poses[0].position, poses[1].position, atol=1e-10)
    assert np.allclose(poses[0].rotation, poses[1].rotation, atol=1e-10)


def test_a_module_carries_an_arm() -> None:
    module = "3-UPU: base_radius=0.4 platform_radius=0.15 height=0.6"
    robot = robot_of("II", links="yaw: length=0.1; pitch: length=0.3 at=30*deg", modules=module)
    assert robot.active == ("lambda_A", "lambda_B", "lambda_C", "q1", "q2")
    place = robot.forward_kinematics(robot.close(robot.reference)).position
    assert np.allclose(place, [0.3 * np.cos(np.pi / 6), 0.0, 0.6 + 0.1 + 0.15], atol=1e-9)


def test_type_c_and_d_are_those_of_the_shipped_robots() -> None:
    """The same bars as in type_c and type_d; positions of their pins are equal to rounding."""
    made = robot_of(
        "III",
        "yaw: length=0.3; pitch: length=0.75",
        "C: joint=q2 k2=1.0 at=1.1 bar=0.88 pivot=-0.25,0.74 pin=-0.224,0",
    )
    shipped = load("type_c")
    for angle in (0.9, 1.1, 1.3):
        fly = shipped.forward_kinematics(shipped.close([0.2, angle, 0.0]), "fly_jib")
        own = made.forward_kinematics(made.close([0.2, angle]), "l2")
        assert np.allclose(own.position, fly.position, atol=1e-9)
        assert np.allclose(own.rotation, fly.rotation, atol=1e-9)
    made = robot_of(
        "III",
        "yaw: length=0.6; pitch: length=0.8 at=33*deg; pitch: length=0.7 at=-68*deg",
        "D: joint=q2 pivot=0.15,0.25 pin=0.45,-0.05 barrel=0.42 stroke=0.02,0.32;"
        " D: joint=q3 pivot=0.1,0.1 pin=-0.12,0.1 crank=0.15 coupler=0.76",
    )
    shipped = load("type_d")
    assert made.active == ("q1", "q2", "q21")
    for stroke, crank in ((0.15, 1.4), (0.2, 1.7)):
        forearm = shipped.forward_kinematics(shipped.close([0.1, stroke, crank, 0.0]), "forearm")
        own = made.forward_kinematics(made.close([0.1, stroke, crank]), "l22")
        assert np.allclose(own.position, forearm.position, atol=1e-9)
        assert np.allclose(own.rotation, forearm.rotation, atol=1e-9)


@settings(max_examples=15, deadline=None)
@given(
    angle=st.floats(0.2, 1.2),
    x=st.floats(-0.5, -0.2),
    pin=st.floats(0.15, 0.5),
    second=st.floats(-1.5, -0.5),
)
def test_reference_angles_are_what_was_asked_for(
    angle: float, x: float, pin: float, second: float
) -> None:
    """The loops close at the angles in the text, without a search: no joint moves in loading."""
    text = robot_text(
        "III",
        f"yaw: length=0.4; pitch: length=0.6 at={angle!r}; pitch: length=0.5 at={second!r}",
        f"A: joint=q2 pivot={x!r},0.2 pin={pin!r},0.05 barrel=0.1 stroke=0,2;"
        " B: joint=q2 pivot=0.02,0.5; A: joint=q3 base=l22 pivot=0.2,0.3 pin=0.3,0.1 barrel=0.05"
        " stroke=0,2",
    )
    robot = Robot(parse_description(text))
    state = robot.close(robot.reference)
    q2 = state.s[robot.coordinates.index("q2")]
    assert abs(q2 - angle) < 1e-9
    assert state.residual < 1e-9


def test_a_crank_and_a_general_four_bar_close_on_their_side() -> None:
    sides: list[float] = []
    for side in ("left", "right"):
        robot = robot_of(
            "III", "2", f"A: joint=q2 pivot=0.45,0.3 pin=0.4,0 crank=0.25 coupler=0.4 side={side}"
        )
        sides.append(float(robot.reference[1]))
        assert robot.active == ("q1", "q11")
    assert abs(sides[0] - sides[1]) > 0.1
    robot = robot_of(
        "III", "pitch: at=40*deg length=0.5", "B: joint=q1 pivot=-0.1,0.2 bar=0.5 pin=-0.1,0.25"
    )
    assert robot.description.closures[0].assembly is None
    assert robot.close(robot.reference).residual < 1e-9


def test_the_usual_cycle_closes_and_the_report_tells_of_it(tmp_path: Path) -> None:
    robot = robot_of("III", loops=LIFT, **CRANE)
    columns = usual_cycle(robot, 30.0)
    assert len(columns["payload"]) == 3
    path = tmp_path / "drives.csv"
    path.write_text("name,bore,rod,stroke,pressure\nS,1e-3,1e-4,1,1e7\nL,0.1,0.05,1,1e7\n")
    outcome = outcome_of(robot, read_duty(columns, robot), [read_catalogue(path)])
    assert outcome.sizings["q12"].chosen.name == "L"
    report = report_text(outcome, "III")
    assert "| theta_1 | A | l1, l2 | l11, l12 | l2 |" in report
    assert "### q12: L is the smallest that fits" in report
    assert "| S | pressure: needs" in report
    with pytest.raises(InputError, match="is a second catalogue"):
        outcome_of(robot, read_duty(columns, robot), [read_catalogue(path)] * 2)


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ({"loops": LIFT.replace("A:", "E:")}, r"loop 1 \(E\): there is no such type"),
        (
            {"loops": LIFT.replace("q2", "q1")},
            "q1 does not pitch; loops stand at joints that do: q2",
        ),
        ({"loops": LIFT.replace("q2", "q5")}, r"loop 1 \(A\): there is no joint 'q5'"),
        ({"loops": LIFT.replace("0.45", "1.45")}, "does not close: its pins are .* less than its"),
        ({"loops": f"{LIFT} stroke=0.4,0.5"}, "its stroke is .* in the reference; expected 0.4"),
        (
            {"loops": LIFT.replace("barrel=0.45", "crank=0.1 coupler=0.1")},
            "does not close: its bars of 0.1 and 0.1 m do not meet over",
        ),
        ({"loops": LIFT.replace("barrel=0.45", "crank=0.1")}, "give coupler="),
        ({"loops": LIFT.replace("pin=0.4,-0.1", "pin=0.4")}, "expected 2 numbers, with commas"),
        ({"loops": LIFT.replace("pin", "pim")}, r"no key 'pim' \(did you mean 'pin'\?\)"),
        ({"loops": LIFT.replace("0.45", "3*kg")}, "barrel: '3\\*kg' is a mass"),
        ({"loops": LIFT.replace("0.45", "-1")}, "barrel is -1; expected more than zero"),
        ({"loops": f"{LIFT}; {LIFT}"}, "loops of types A, A stand at q2"),
        ({"loops": f"{LIFT} base=base"}, "base does not hold q2; expected base=l1"),
        ({"loops": f"{LIFT} base=l9"}, "there is no link 'l9'"),
        (
            {"loops": f"{LIFT.replace('barrel=0.45', 'crank=0.3 coupler=0.3')} side=up"},
            "side is 'up'; expected left or right",
        ),
        ({"loops": "B: joint=q2 pivot=0,0.5"}, "its pivot is the joint itself"),
        (
            {"links": "yaw; roll: length=1; pitch: on=l1", "loops": LIFT.replace("q2", "q3")},
            "link 2 .*: rolls about a link that points ahead",
        ),
        ({"links": "yaw; bend: length=1"}, "there is no kind of link 'bend'"),
        ({"links": "pitch: length"}, "'length'; expected KEY=VALUE"),
        ({"links": "pitch: length=1 length=2"}, "length is given twice"),
        ({"links": "pitch: tail=-1"}, "tail is -1; expected zero or more"),
        ({"links": "10"}, "there are 10 links; expected 9 at most"),
        ({"links": "yaw; pitch: on=l7"}, "there is no link 'l7'"),
        ({"links": ""}, "Class III has links: give them"),
        ({"modules": "delta: arm=1"}, "Class III has no modules"),
    ],
)
def test_wrong_words_get_one_line(parts: dict[str, str], words: str) -> None:
    given = {**CRANE, "loops": LIFT, **parts}
    with pytest.raises(InputError, match=words) as caught:
        robot_text("III", **given)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("modules", "words"),
    [
        ("gamma: a=1", r"module 1 \(gamma\): there is no template 'gamma'"),
        ("delta: arm=0.3 rod=0.6 base_radius=0.2", "give platform_radius="),
        ("delta: arm=0.3 rods=0.6", r"no key 'rods' \(did you mean 'rod'\?\)"),
        ("delta: arm=1,2 rod=1 base_radius=1 platform_radius=1", "expected one number"),
    ],
)
def test_wrong_modules_get_one_line(modules: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        robot_text("I", modules=modules)


def test_the_verb_writes_a_folder(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    folder = tmp_path / "crane"
    words = ["design", "--class", "III", "--links", CRANE["links"], "--loops", LIFT]
    words += ["--name", "crane", "-o", str(folder)]
    answer = call(*words, "--json")
    assert answer.exit_code == 0, answer.output
    shown = json.loads(answer.stdout)
    assert shown["loops"]["theta_1"]["type"] == "A"
    assert shown["drives"]["q12"]["peak"] > 0.0
    files = sorted(path.name for path in folder.iterdir())
    assert files == ["cycle.csv", "picture.svg", "report.md", "robot.yaml"]
    robot = load(folder / "robot.yaml")
    assert robot.name == "crane"
    assert len(read_duty(folder / "cycle.csv", robot).values) == 3
    assert call(*words).exit_code == 2
    assert call(*words, "--overwrite").exit_code == 0
    wrong = call(*words[:5], "--loops", LIFT.replace("0.45", "2"), "-o", str(tmp_path / "no"))
    assert wrong.exit_code == 2
    assert "does not close" in wrong.stderr
    assert not (tmp_path / "no").exists()


def test_columns_of_a_duty_cycle_that_are_not_used_are_named(tmp_path: Path) -> None:
    cycle = tmp_path / "cycle.csv"
    cycle.write_text("q1,q12,q3,load\n0,0.1,-1,20\n")
    loop = "A: joint=q2 pivot=-0.3,0.4 pin=0.3,0 barrel=0.35"
    words = ["design", "--class", "III", "--links", "3", "--loops", loop, "--cycle", str(cycle)]
    answer = call(*words, "-o", str(tmp_path / "crane"))
    assert answer.exit_code == 0, answer.output
    assert "columns that are not used: load; known: coordinates, time" in answer.output
