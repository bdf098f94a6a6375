"""Studies: values of each design, folders that go on, threads and clusters, mistakes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import DescriptionError, InputError
from hybrid_dynamics_core.kernels.run import VARIABLE
from hybrid_dynamics_core.sweeps import (
    EachRobot,
    Study,
    grid,
    listed,
    random,
    read_results,
    sweep,
    sweep_into,
)
from tests.cli.calling import call
from tests.robots import robot as shipped
from tests.sampling import examples
from tests.sweeps import functions

NAME = "forging_chu2020"
SPACE = {"L2": (0.3, 1.1, 12), "L3": (0.7, 0.9, 10)}  # L2 below 0.6 opens a loop
CLOSED = grid({"L2": (0.7, 0.8, 2)})
QUANTITIES = ("position.z", "effort.q12", "coordinate.q2", "singularity", "pin.theta_1")
ROOT = Path(__file__).parents[2]


@pytest.fixture(autouse=True)
def _without_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "python")


def study(chunk: int = 25, space=None, **others) -> Study:
    """A study of the forging robot in five chunks."""
    return Study(shipped(NAME), space or grid(SPACE), QUANTITIES, chunk=chunk, **others)


def assert_same(one, other) -> None:
    """All columns are the same, to the bit."""
    assert list(one) == list(other)
    for name, column in one.items():
        assert column.tobytes() == other[name].astype(column.dtype).tobytes(), name


# -- values


def test_a_design_has_the_numbers_of_its_robot() -> None:
    results = sweep(study())
    assert len(results["design"]) == 120
    robot = shipped(NAME)
    closed = np.flatnonzero(results["status"] == "closed")
    for row in closed[[0, len(closed) // 2, -1]]:
        other = robot.with_parameters(L2=results["L2"][row], L3=results["L3"][row])
        state = other.close(robot.reference)
        tau = other.inverse_dynamics(state, np.zeros(4))
        pins = other.reactions(state, np.zeros(4)).pins
        expected = {
            "position.z": other.forward_kinematics(state).position[2],
            "effort.q12": tau[1],
            "coordinate.q2": state.s[robot.coordinates.index("q2")],
            "singularity": state.singularity,
            "pin.theta_1": np.linalg.norm(pins["theta_1"].force),
        }
        for name, value in expected.items():
            assert results[name][row] == pytest.approx(value, rel=1e-9), name


def test_a_design_that_does_not_close_is_a_row_with_its_status() -> None:
    results = sweep(study())
    is_open = results["status"] == "unreachable"
    assert 0 < is_open.sum() < len(is_open)
    for name in QUANTITIES:
        assert np.isnan(results[name][is_open]).all()
        assert np.isfinite(results[name][~is_open]).all()
    assert (results["closes"] == ~is_open).all()
    row = int(np.flatnonzero(is_open)[0])
    with pytest.raises(DescriptionError):
        shipped(NAME).with_parameters(L2=results["L2"][row], L3=results["L3"][row])


def test_a_joint_beyond_its_limits_is_told() -> None:
    """With a long rod the ankle closes where its pitch may not be; there is no such robot."""
    robot = shipped("ankle")
    results = sweep(Study(robot, listed({"rod": [0.21, 0.29, 0.5]}), ["coordinate.pitch"]))
    assert results["within_limits"].tolist() == [1.0, 0.0, 0.0]
    assert results["closes"].tolist() == [1.0, 1.0, 0.0]
    assert results["coordinate.pitch"][1] < robot.description.joints["pitch"].limits[0]
    with pytest.raises(DescriptionError, match="outside"):
        robot.with_parameters(rod=0.29)


def test_quantities_of_several_poses_are_summaries() -> None:
    robot = shipped(NAME)
    u = np.tile(robot.reference, (3, 1))
    u[:, 1] += (0.0, 0.02, 0.05)
    names = [f"effort.q12.{one}" for one in ("min", "max", "mean", "range")]
    space = listed({"L2": [0.65, 0.7], "L3": [0.8, 0.8]})
    results = sweep(Study(robot, space, names, u))
    taus = [robot.inverse_dynamics(robot.close(row), np.zeros(4))[1] for row in u]
    expected = (min(taus), max(taus), np.mean(taus), np.ptp(taus))
    for name, value in zip(names, expected, strict=True):
        assert results[name][1] == pytest.approx(value, rel=1e-9), name


def test_functions_add_columns() -> None:
    results = sweep(study(function=functions.ratio))
    is_closed = results["status"] == "closed"
    ratio = results["L2"] / results["L3"]
    np.testing.assert_array_equal(results["ratio"][is_closed], ratio[is_closed])
    assert np.isnan(results["ratio"][~is_closed]).all()


def test_a_function_of_each_robot_gives_its_numbers() -> None:
    robot = shipped(NAME)
    space = listed({"L2": [0.7, 0.72, 0.3], "L3": [0.8, 0.81, 0.8]})
    results = sweep(Study(robot, space, function=EachRobot(functions.height_at_rest)))
    other = robot.with_parameters(L2=0.72, L3=0.81)
    height = other.forward_kinematics(other.close(other.reference)).position[2]
    assert results["height"][1] == pytest.approx(height, rel=1e-9)
    assert results["status"].tolist() == ["closed", "closed", "unreachable"]
    assert np.isnan(results["height"][2])
    none = sweep(Study(robot, space, function=EachRobot(functions.refuses_all)))
    assert (none["status"] == "unreachable").all()


def test_a_function_of_each_robot_takes_what_changes_the_structure() -> None:
    """A parallelogram with one longer bar is none; as its file says so, there is no such robot."""
    robot = shipped("palletizer")
    space = grid({"joints.p5.origin.xyz[0]": (0.06, 0.07, 2)})
    with pytest.raises(InputError, match="EachRobot"):
        Study(robot, space, ["position.z"])
    results = sweep(Study(robot, space, function=EachRobot(functions.height_at_rest)))
    assert results["status"].tolist() == ["closed", "unreachable"]


# -- sets of designs


@examples(60)
@given(first=st.integers(0, 59), size=st.integers(1, 60), seed=st.integers(0, 9))
def test_designs_do_not_depend_on_the_chunk(first: int, size: int, seed: int) -> None:
    end = min(first + size, 60)
    bounds = {"a": (1.0, 2.0), "b": (-3.0, 5.0), "c": (0.0, 1e-3)}
    spaces = (random(bounds, 60, seed), grid({"a": (1.0, 2.0, 5), "b": (0.0, 3.0, 12)}))
    for space in spaces:
        whole = space.designs(0, 60)
        np.testing.assert_array_equal(space.designs(first, end), whole[first:end])
        low, high = space.extremes()
        assert (low <= whole).all()
        assert (whole <= high).all()
    every = spaces[1].designs(0, 60)
    assert len(np.unique(every, axis=0)) == 60
    np.testing.assert_array_equal(every[[0, -1]], spaces[1].extremes())


# -- folders


@pytest.mark.parametrize("file_format", ["csv", "parquet"])
def test_a_stopped_study_goes_on_to_the_same_bits(tmp_path: Path, file_format: str) -> None:
    if file_format == "parquet":
        pytest.importorskip("pyarrow")
    whole = sweep(study())
    done = sweep_into(study(), tmp_path / "one", file_format=file_format)
    assert (done.designs, done.computed) == (120, 120)
    assert_same(whole, read_results(tmp_path / "one"))
    parts = sorted((tmp_path / "one").glob("part-*"))
    assert len(parts) == 5
    before = {path.name: path.read_bytes() for path in parts}
    for path in parts[1:4:2]:
        path.unlink()
    (tmp_path / "one" / f".abc.{parts[1].name}").write_bytes(b"half a file")
    again = sweep_into(study(), tmp_path / "one", file_format=file_format)
    assert again.computed == 50
    assert {path.name: path.read_bytes() for path in parts} == before
    assert sweep_into(study(), tmp_path / "one", file_format=file_format).computed == 0


def test_threads_give_the_bits_of_one_thread(tmp_path: Path) -> None:
    assert_same(sweep(study(7)), sweep(study(7), threads=3))
    sweep_into(study(7), tmp_path / "three", threads=3)
    assert_same(sweep(study(7)), read_results(tmp_path / "three"))
    joined = (tmp_path / "three" / "results.csv").read_text(encoding="utf-8").splitlines()
    assert len(joined) == 121
    assert [line.partition(",")[0] for line in joined[1:]] == [str(k) for k in range(120)]


def test_a_cluster_gives_the_bits_of_threads(tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        1, processes=False, dashboard_address=None, threads_per_worker=2
    ) as cluster:
        sweep_into(study(), tmp_path / "dask", scheduler=cluster.scheduler_address)
        broken = study(function=functions.fails)
        with pytest.raises(InputError, match="'L9'"):
            sweep_into(broken, tmp_path / "no", scheduler=cluster.scheduler_address)
    assert_same(sweep(study(), threads=2), read_results(tmp_path / "dask"))


def test_a_killed_process_is_resumed(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "hybrid_dynamics_cli", "sweep", NAME, "--json", "--chunk", "20"]
    words += ["--vary", "L2=0.6:0.9:10", "--vary", "L3=0.7:0.9:10", "--quantity", "position.z"]
    words += ["--function", "tests.sweeps.functions:kills_its_process_once", "-o", "out"]
    mark = tmp_path / "killed"
    variables = {**os.environ, functions.MARK: str(mark), "PYTHONPATH": str(ROOT)}
    first = subprocess.run(words, cwd=tmp_path, env=variables, capture_output=True, check=False)
    assert first.returncode < 0  # by a signal
    assert mark.exists()
    done = len(list((tmp_path / "out").glob("part-*.csv")))
    assert 0 < done < 5
    second = subprocess.run(words, cwd=tmp_path, env=variables, capture_output=True, check=False)
    assert second.returncode == 0, second.stderr
    assert json.loads(second.stdout)["computed"] == 100 - 20 * done
    space = grid({"L2": (0.6, 0.9, 10), "L3": (0.7, 0.9, 10)})
    whole = sweep(Study(shipped(NAME), space, ["position.z"], function=functions.ratio, chunk=20))
    assert_same(whole, read_results(tmp_path / "out"))


@pytest.mark.parametrize(
    ("changed", "part"),
    [
        ({"space": grid({**SPACE, "L2": (0.3, 1.2, 12)})}, "designs"),
        ({"chunk": 30}, "chunk"),
        ({"u": [0.0, 0.11, 0.15, 0.0]}, "poses"),
        ({"function": functions.ratio}, "function"),
        ({"robot": 0.6}, "robot"),
        ({"quantities": ["position.x"]}, "quantities"),
    ],
)
def test_results_of_another_study_are_not_continued(
    tmp_path: Path, changed: dict, part: str
) -> None:
    sweep_into(study(), tmp_path / "out")
    changed = dict(changed)
    robot = shipped(NAME)
    if "robot" in changed:
        robot = robot.with_parameters(L1=changed.pop("robot"))
    space = changed.pop("space", grid(SPACE))
    names = changed.pop("quantities", QUANTITIES)
    other = Study(robot, space, names, **{"chunk": 25, **changed})
    with pytest.raises(InputError, match=f"changed: {part}; name another folder"):
        sweep_into(other, tmp_path / "out")
    sweep_into(other, tmp_path / "out", overwrite=True)
    assert_same(sweep(other), read_results(tmp_path / "out"))


@pytest.mark.parametrize("file_format", ["csv", "parquet"])
@pytest.mark.parametrize("share", [0.0, 0.5, 0.97])
def test_a_chunk_that_lost_its_end_is_computed_anew(
    tmp_path: Path, file_format: str, share: float
) -> None:
    if file_format == "parquet":
        pytest.importorskip("pyarrow")
    out = tmp_path / "out"
    sweep_into(study(), out, file_format=file_format)
    part = sorted(out.glob("part-*"))[2]
    content = part.read_bytes()
    part.write_bytes(content[: int(share * len(content))])
    if file_format == "parquet" or not share:
        with pytest.raises(InputError, match=f"{part.name}: is damaged"):
            read_results(out)
    done = sweep_into(study(), out, file_format=file_format)
    assert done.computed == 25
    assert part.read_bytes() == content
    assert_same(sweep(study()), read_results(out))


def test_rows_that_are_missing_are_computed_anew(tmp_path: Path) -> None:
    sweep_into(study(), tmp_path / "out")
    part = max((tmp_path / "out").glob("part-*"))
    whole = part.read_text(encoding="utf-8")
    part.write_text("".join(whole.splitlines(keepends=True)[:4]), encoding="utf-8")
    assert sweep_into(study(), tmp_path / "out").computed == 20  # of the last, shorter chunk
    assert part.read_text(encoding="utf-8") == whole


def test_a_function_is_another_one_with_other_values_from_outside() -> None:
    def scaled(factor):
        def inner(designs):
            return {"x": factor * designs["L2"]}

        return study(function=inner).digests["function"]

    assert scaled(2.0) == scaled(2.0)
    assert scaled(2.0) != scaled(3.0)
    assert scaled(np.array([2.0])) != scaled(np.array([3.0]))


def test_a_folder_that_cannot_be_written_gets_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "mkdir", refused)
    with pytest.raises(InputError, match="cannot be written: Permission denied; name another"):
        sweep_into(study(), tmp_path / "out")


# -- mistakes


@pytest.mark.parametrize(
    ("make", "part"),
    [
        (lambda: grid({}), "no parameter varies"),
        (lambda: grid({"L2": (0.9, 0.6, 10)}), "ends at 0.6, below its start 0.9"),
        (lambda: grid({"L2": (0.6, 0.6, 10)}), "has no range"),
        (lambda: grid({"L2": (0.6, 0.7)}), "expected low, high and count"),
        (lambda: grid({"L2": (0.6, 0.7, 1)}), "count of L2"),
        (lambda: grid({"L2": (0.6, np.inf, 3)}), "finite bounds"),
        (lambda: grid(dict.fromkeys("abcd", (0.0, 1.0, 10_001))), "designs; at most"),
        (lambda: random({"L2": (0.6, 0.7, 3)}, 10), "expected low and high"),
        (lambda: listed({"L2": [0.6, np.nan]}), "row:2: L2 is empty"),
        (lambda: study(space=grid({"L99": (0.0, 1.0, 2)})), "no parameter 'L99'"),
        (lambda: study(space=grid({"links.l2.mass": (-1.0, 1.0, 3)})), "zero or positive"),
        (lambda: study(space=grid({"joints.q1.origin.xyz": (0.0, 1.0, 3)})), "means 3 numbers"),
        (lambda: study(space=grid({"joints.q32.origin.xyz[0]": (0.69, 0.7, 3)})), "loops.theta_4"),
        (lambda: study(frame="toool"), "no frame 'toool'"),
        (lambda: study(chunk=0), "chunk"),
        (lambda: Study(NAME, grid(SPACE), ["effort.q99"]), "there is no 'q99'"),
        (lambda: Study(NAME, grid(SPACE), ["efort.q12"]), "did you mean 'effort'"),
        (lambda: Study(NAME, grid(SPACE), ["effort.q12"] * 2), "named twice"),
        (
            lambda: Study(NAME, grid(SPACE), ["effort.q12"], np.zeros((2, 4))),
            "2 values, one a pose",
        ),
        (lambda: sweep(study(function=functions.fails)), "function: there is no parameter 'L9'"),
        (lambda: sweep(study(function=functions.short)), "one number a design"),
        (lambda: sweep(study(function=functions.comma)), "expected a name without commas"),
        (lambda: sweep(study(function=functions.imaginary)), "expected real numbers"),
        (
            lambda: sweep(study(space=CLOSED, function=EachRobot(functions.bare))),
            "expected numbers by name",
        ),
    ],
)
def test_a_wrong_study_gets_one_line(make, part: str) -> None:
    with pytest.raises(InputError) as caught:
        make()
    assert part in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_folder_with_something_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match="has other files"):
        sweep_into(study(), tmp_path)
    with pytest.raises(InputError, match="is a file"):
        sweep_into(study(), tmp_path / "notes.txt")
    with pytest.raises(InputError, match="expected the folder of a study"):
        read_results(tmp_path)
    with pytest.raises(InputError, match="no 'xlsx'"):
        sweep_into(study(), tmp_path / "new", file_format="xlsx")
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


def test_the_command_gives_what_python_gives(tmp_path: Path) -> None:
    words = ["--vary", "L2=300*mm:1.1:12", "--vary", "L3=0.7:0.9:10", "--chunk", "25"]
    words += ["--quantity", ",".join(QUANTITIES), "-o", str(tmp_path / "out")]
    result = call("sweep", NAME, *words, "--json")
    assert result.exit_code == 0, result.output
    data = json.loads(result.output)
    results = sweep(study())
    assert_same(results, read_results(tmp_path / "out"))
    assert data["status"]["closed"] == (results["status"] == "closed").sum()
    ends = data["quantities"]["effort.q12"]
    assert ends["least"] == np.nanmin(results["effort.q12"])
    assert ends["most_at"] == np.nanargmax(results["effort.q12"])
    assert ends["most_with"]["L2"] == results["L2"][ends["most_at"]]
    assert list(ends["least_with"]) == ["L2", "L3"]
    shown = call("sweep", NAME, *words)
    assert f"L2={ends['least_with']['L2']:.6g}, L3=" in shown.output
    changed = call("sweep", NAME, *words, "--seed", "3", "--random", "5")
    assert changed.exit_code == 2
    other = call("sweep", NAME, *words[2:], "--vary", "L2=0.6:0.7:3")
    assert "give --overwrite" in other.output


@pytest.mark.parametrize(
    ("words", "part"),
    [
        ([], "give --vary"),
        (["--vary", "L2"], "expected PARAMETER=LOW:HIGH:COUNT"),
        (["--vary", "L2=1:2"], "expected PARAMETER=LOW:HIGH:COUNT"),
        (["--vary", "L2=a:2:3"], "'L2=a:2:3'"),
        (["--vary", "L2=0.6:0.7:3.5"], "'L2=0.6:0.7:3.5'"),
        (["--vary", "L2=0.6:0.7:3", "--vary", "L2=0.6:0.7:3"], "given twice"),
        (["--vary", "L99=1:2:3"], "no parameter 'L99'"),
        (["--vary", "joints.q2.origin.xyz[2]=0.1*kg:0.2:3"], "is a mass; expected a length"),
        (["--vary", "L2=30*deg:0.8:3"], "is an angle; expected a length"),
        (["--designs", "none.csv"], "there is no such file"),
        (["--vary", "L2=0.6:0.7:3", "--function", "nothing"], "expected MODULE:NAME"),
        (["--vary", "L2=0.6:0.7:3", "--each", "nomodule:f"], "nomodule"),
        (["--vary", "L2=0.6:0.7:3", "--scheduler", "x://1"], "scheduler x://1"),
    ],
)
def test_a_wrong_call_gets_one_line(tmp_path: Path, words: list[str], part: str) -> None:
    if "--scheduler" in words:
        pytest.importorskip("distributed")
    result = call("sweep", NAME, *words, "-o", str(tmp_path / "out"))
    assert result.exit_code in (1, 2)
    assert part in result.output
    assert "Traceback" not in result.output


@pytest.mark.parametrize(
    ("header", "part"),
    [
        ("L2 [kg]", "column L2 [kg]: '1*kg' is a mass; expected a length"),
        ("L99", "no parameter 'L99'"),
    ],
)
def test_a_wrong_column_of_designs_gets_one_line(tmp_path: Path, header: str, part: str) -> None:
    table = tmp_path / "designs.csv"
    table.write_text(f"{header}\n0.72\n", encoding="utf-8")
    result = call("sweep", NAME, "--designs", str(table), "-o", str(tmp_path / "out"))
    assert result.exit_code in (1, 2)
    assert part in result.output
    assert str(table) in result.output


def test_designs_have_the_units_of_their_header(tmp_path: Path) -> None:
    table = tmp_path / "designs.csv"
    table.write_text("L2 [mm]\n720\n", encoding="utf-8")
    words = ["--designs", str(table), "--quantity", "singularity", "--json"]
    result = call("sweep", NAME, *words, "-o", str(tmp_path / "out"))
    ends = json.loads(result.stdout)["quantities"]["singularity"]
    assert ends["least_with"]["L2"] == pytest.approx(0.72, rel=1e-15)
