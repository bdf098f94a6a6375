"""`hybrid-dynamics calibrate`: what it prints and writes, and what it refuses in one line."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import load
from tests.cli.calling import call, data_of
from tests.sampling import swept

from .crank import TEXT, changed, columns, poses, write

NOISE = 5e-5  # [m]
FREE = "reach, loops.lift.pin.crank[0], joints.turn.offset"
TRUTH = {"reach": 0.802, "loops.lift.pin.crank[0]": 0.601, "joints.turn.offset": 0.01}


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    """The folder with a robot's file, the true robot, and measurements."""
    folder = tmp_path_factory.mktemp("calibrate")
    robot = write(folder)
    true = changed(
        folder,
        reach="reach: 0.802 ",
        pin="crank: [0.601, 0, 0]",
        turn="child: column, axis: z, offset: 0.01",
    )
    return folder, robot, true, columns(true, poses(40), noise=NOISE)


def table(path, data):
    rows = np.stack(list(data.values()), axis=1)
    np.savetxt(path, rows, delimiter=",", header=",".join(data), comments="")
    return str(path)


def test_the_new_file_is_the_old_one_with_other_numbers(measured, tmp_path):
    _, robot, true, data = measured
    new = tmp_path / "new.yaml"
    words = ("--robot", robot, "--free", FREE, "--sigma", "0.05*mm", "-o", str(new))
    answer = data_of("calibrate", table(tmp_path / "data.csv", data), *words)
    assert answer["identifiable"] == dict.fromkeys(TRUTH, True)
    assert 0.7 < answer["chi2"] < 1.3
    for path, value in TRUTH.items():
        one = answer["parameters"][path]
        assert abs(one["value"] - value) < 5.0 * one["deviation"]
        low, high = one["interval"]
        assert low < one["value"] < high
    assert answer["parameters"]["reach"]["from"] == 0.8
    text = new.read_text(encoding="utf-8")
    assert "# crank to the tool [m]" in text
    assert "reach: 0.802" in text
    assert "was 0.8," in text
    assert len(text.splitlines()) == len(TEXT.splitlines()) + len(TRUTH) + 1
    u = poses(30, seed=9)
    found_robot = load(str(new))
    place = found_robot.forward_kinematics(found_robot.close(u)).position
    true_place = true.forward_kinematics(true.close(u)).position
    assert np.abs(place - true_place).max() < NOISE


def test_units_stand_in_the_header(measured, tmp_path):
    _, robot, _, data = measured
    words = ("--robot", robot, "--free", FREE, "--sigma", "0.05*mm")
    plain = data_of("calibrate", table(tmp_path / "plain.csv", data), *words)
    others = {}
    for name, values in data.items():
        unit, factor = (" [deg]", 180.0 / np.pi) if name == "turn" else (" [mm]", 1e3)
        others[name + unit] = values * factor
    other = data_of("calibrate", table(tmp_path / "other.csv", others), *words)
    for path in TRUTH:
        values = [answer["parameters"][path]["value"] for answer in (plain, other)]
        assert values[0] == pytest.approx(values[1], abs=1e-9)


def without(data, *names):
    return {name: values for name, values in data.items() if name not in names}


WRONG = {
    "a path near another": (lambda data: data, "reech", "did you mean 'reach'?"),
    "a path": (
        lambda data: data,
        "joints.torn.offset",
        "there is no parameter 'joints.torn.offset'",
    ),
    "one twice": (lambda data: data, "reach, reach", "'reach' is given twice"),
    "millimetres": (
        lambda data: data | {f"tool.{k}": 1e3 * data[f"tool.{k}"] for k in "xyz"},
        "reach",
        "if it is in mm, write tool.x [mm] in the header",
    ),
    "slides in millimetres": (
        lambda data: data | {"stroke": 1e3 * data["stroke"]},
        "reach",
        "if stroke is in mm, write stroke [mm] in the header",
    ),
    "degrees": (
        lambda data: data | {"turn": np.degrees(data["turn"])},
        "reach",
        "if it is in degrees, write turn [deg] in the header",
    ),
    "a column that is missing": (lambda data: without(data, "stroke"), "reach", "no column stroke"),
    "a column of a misspelt name": (
        lambda data: without(data, "tool.x") | {"tol.x": data["tool.x"]},
        "reach",
        "column tol.x is not known (did you mean 'tool.x'?)",
    ),
    "nothing measured": (
        lambda data: without(data, "tool.x", "tool.y", "tool.z"),
        "reach",
        "nothing is measured",
    ),
    "too few rows": (
        lambda data: {name: values[:1] for name, values in data.items()},
        "reach, end_effector.xyz, joints.turn.offset, joints.pivot.origin.xyz",
        "3 measured numbers cannot give 8 parameters",
    ),
    "a row that does not close": (
        lambda data: data | {"stroke": np.where(np.arange(40) == 11, 0.9, data["stroke"])},
        "reach",
        ".csv:13: loop 'lift' cannot close",
    ),
    "a tilt that a planar loop does not allow": (
        lambda data: data,
        "joints.pivot.origin.rpy[0]",
        "free: joints.pivot.origin.rpy[0] cannot change",
    ),
    "half a quaternion": (
        lambda data: data | {"tool.qx": data["tool.x"]},
        "reach",
        "no column tool.qy",
    ),
}


COMMON = (
    "a path near another",
    "millimetres",
    "a column of a misspelt name",
    "a row that does not close",
)


@pytest.mark.parametrize("case", swept(WRONG, COMMON))
def test_a_wrong_call_gets_one_line(measured, tmp_path, case):
    _, robot, _, data = measured
    change, free, message = WRONG[case]
    path = table(tmp_path / "data.csv", change(dict(data)))
    answer = call("calibrate", path, "--robot", robot, "--free", free, "--sigma", "0.05*mm")
    assert answer.exit_code == 2, answer.output
    assert message in answer.stderr
    assert answer.stderr.strip().count("\n") == 0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("turn,stroke,tool.x\n0,0.1\n", ":2: has 2 cells; the header has 3"),
        ("turn,stroke,tool.x\n0,0.1,a\n", ":2: tool.x is 'a', which is no number"),
        ("turn,stroke,tool.x\n", "has no rows"),
        ("turn,stroke,tool.x [kg]\n0,0.1,1\n", ":1: column tool.x [kg]"),
        ("turn,stroke,tool.x,turn\n0,0.1,1,0\n", ":1: there are two columns turn"),
        ("turn,stroke,tool.x\n0,,1\n", ":2: stroke is missing"),
    ],
)
def test_a_wrong_table_gets_one_line(measured, tmp_path, text, message):
    _, robot, _, _ = measured
    path = tmp_path / "data.csv"
    path.write_text(text, encoding="utf-8")
    answer = call("calibrate", str(path), "--robot", robot, "--free", "reach")
    assert answer.exit_code == 2, answer.output
    assert message in answer.stderr
    assert answer.stderr.strip().count("\n") == 0


def test_other_measurements_check_the_estimates(measured, tmp_path):
    _, robot, true, data = measured
    path = table(tmp_path / "data.csv", data)
    others = table(tmp_path / "others.csv", columns(true, poses(25, seed=8), noise=NOISE, seed=9))
    words = ("--robot", robot, "--free", FREE, "--sigma", "0.05*mm")
    answer = data_of("calibrate", path, *words, "--hold-out", others)
    check = answer["hold_out"]["tool"]
    assert check["before"] > 1e-3
    assert 0.7 * NOISE < check["after"] < 1.4 * NOISE
    held_out = answer["residuals"]["tool"]["held_out"]
    assert 0.7 * NOISE < held_out < 1.4 * NOISE


WRONG_SIGMAS = ["0.05*kg", "-1*mm", "points=1*mm", "0", "tool=0.01*deg"]


@pytest.mark.parametrize("sigma", WRONG_SIGMAS)
def test_a_wrong_sigma_is_refused(measured, tmp_path, sigma):
    _, robot, _, data = measured
    path = table(tmp_path / "data.csv", data)
    answer = call("calibrate", path, "--robot", robot, "--free", "reach", f"--sigma={sigma}")
    assert answer.exit_code == 2
    assert "sigma" in answer.stderr


@pytest.mark.parametrize(
    ("column", "change", "words"),
    [
        ("tool.x", lambda v: 1000.0 * v, "tool.x [mm]"),
        ("tool.x", lambda v: np.where(v == v[3], np.inf, v), "tool.x is inf"),
        ("tool.z", lambda v: np.where(v == v[3], 1e200, v), "tool.z is"),
        ("weight", lambda v: 0.0 * v, "all weights are zero"),
    ],
)
def test_what_cannot_be_measured_is_refused(measured, tmp_path, column, change, words):
    _, robot, _, data = measured
    wrong = {**data, column: change(data.get(column, np.ones(40)))}
    path = table(tmp_path / "data.csv", wrong)
    answer = call("calibrate", path, "--robot", robot, "--free", FREE, "--sigma", "0.05*mm")
    assert answer.exit_code == 2
    assert words in answer.output


def test_measurements_are_not_replaced_by_the_result(measured, tmp_path):
    _, robot, _, data = measured
    path = table(tmp_path / "data.csv", data)
    words = ("--robot", robot, "--free", FREE, "-o", path, "--overwrite")
    answer = call("calibrate", path, *words)
    assert answer.exit_code == 2
    assert "is read by this call" in answer.output


def test_choose_needs_candidates(measured, tmp_path):
    _, robot, _, data = measured
    path = table(tmp_path / "data.csv", data)
    answer = call("calibrate", path, "--robot", robot, "--free", FREE, "--choose", "3")
    assert answer.exit_code == 2
    assert "--candidates" in answer.output


def test_measurements_that_no_parameter_explains_are_doubted(measured, tmp_path):
    _, robot, _, data = measured
    stuck = {**data, "tool.x": np.full(40, data["tool.x"][0])}
    path = table(tmp_path / "data.csv", stuck)
    answer = call("calibrate", path, "--robot", robot, "--free", FREE, "--sigma", "0.05*mm")
    assert "do not explain" in answer.output
