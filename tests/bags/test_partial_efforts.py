"""Efforts of some joints only, and trajectories with units in the names of their columns."""

from __future__ import annotations

import json

import numpy as np
import pytest

from hybrid_dynamics_core import load
from hybrid_dynamics_core.identification import identify, random_motion
from hybrid_dynamics_ros.bags.errors import BagError
from hybrid_dynamics_ros.bags.make import simulated
from hybrid_dynamics_ros.bags.trajectory_file import read_trajectory
from tests.bags.calling import output, printed, run

ROBOT = "five_bar"
pytestmark = pytest.mark.usefixtures("python_kernels")


@pytest.fixture(scope="module")
def motion():
    """A motion with efforts."""
    return simulated(load(ROBOT), 4.0, 100.0)


def csv_of(path, head, *columns):
    """A CSV file."""
    table = np.column_stack(columns)
    lines = [",".join(head), *(",".join(map(repr, row)) for row in table.tolist())]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_units_in_the_names_of_columns_change_nothing(forging, tmp_path):
    """Times in ms, angles in degrees, strokes in mm, efforts in kN: the same trajectory."""
    motion = simulated(forging, 0.5, 100.0)
    types = forging.joint_types
    head, columns = ["time [ms]"], [motion.time * 1e3]
    units = {
        "revolute": (("deg", 180.0 / np.pi), ("deg/s", 180.0 / np.pi), ("N m", 1.0)),
        "prismatic": (("mm", 1e3), ("mm/s", 1e3), ("kN", 1e-3)),
    }
    for k, name in enumerate(motion.names):
        parts = (motion.position, motion.velocity, motion.effort)
        suffixes = ("", ".velocity", ".effort")
        for part, suffix, (unit, factor) in zip(parts, suffixes, units[types[name]], strict=True):
            head.append(f"{name}{suffix} [{unit}]")
            columns.append(part[:, k] * factor)
    read = read_trajectory(csv_of(tmp_path / "a.csv", head, *columns), forging)
    for part in ("time", "position", "velocity", "effort"):
        np.testing.assert_allclose(getattr(read, part), getattr(motion, part), rtol=1e-12)
    assert read.unused == ()


@pytest.mark.parametrize(
    ("column", "said"),
    [
        ("q_L [mm]", r"column 'q_L \[mm\]': .* is a length; expected an angle \[rad\]"),
        ("q_L [furlong]", r"column 'q_L \[furlong\]': 'furlong' is not a number, pi or a unit"),
        ("q_L [m//s]", r"column 'q_L \[m//s\]'"),
        ("q_R [deg]", r"two columns are called q_R"),
    ],
)
def test_a_unit_that_does_not_fit_is_refused(column, said, motion, tmp_path):
    head = ["time", column, "q_R", "q_T"]
    file = csv_of(tmp_path / "a.csv", head, motion.time, motion.position)
    with pytest.raises(BagError, match=said):
        read_trajectory(file, load(ROBOT))


@pytest.fixture(scope="module", params=["no column", "no number"])
def recording(request, motion, tmp_path_factory):
    """A bag without efforts of q_R."""
    folder = tmp_path_factory.mktemp("partial")
    names = motion.names
    columns = [motion.position, motion.velocity, motion.effort[:, [0, 2]]]
    head = ["time", *names, *(f"{name}.velocity" for name in names), "q_L.effort", "q_T.effort"]
    if request.param == "no number":
        head.append("q_R.effort")
        columns.append(np.full(len(motion.time), np.nan))
    file = csv_of(folder / "a.csv", head, motion.time, *columns)
    run("make", folder / "in", "--robot", ROBOT, "--trajectory", file, "--noise", "effort=1e-4")
    return folder / "in"


def test_a_report_compares_the_efforts_that_there_are(recording, tmp_path):
    said = printed("report", recording, "--output", tmp_path / "a.html", "--json")
    assert set(json.loads(said)["efforts"]) == {"q_L", "q_T"}


def test_identification_rests_on_the_efforts_that_there_are(recording):
    said = output("identify", recording)
    assert "No efforts of q_R are recorded. What follows rests on those of q_L, q_T." in said
    found = json.loads(printed("identify", recording, "--json"))
    assert set(found["held_out"]) == {"q_L", "q_T"}
    assert found["determined"]
    for name in found["determined"]:
        base = found["base"][name]
        width = base["high"] - base["low"]
        assert abs(base["estimate"] - base["file"]) < 1.5 * width


def test_estimates_from_some_joints_are_those_of_the_model():
    """Without noise: each base parameter that these joints show is exact."""
    robot = load(ROBOT)
    state, ddu = random_motion(robot, 200, 0)
    tau = robot.inverse_dynamics(state, ddu)[:, [1]]
    found = identify(robot, state, ddu, tau, joints=["q_R"])
    everything = identify(robot, state, ddu, robot.inverse_dynamics(state, ddu))
    assert 0 < found.base.size < everything.base.size
    values = found.base.values(found.parameters.values(robot.description))
    np.testing.assert_allclose(found.estimate, values, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("quiet", range(3))
def test_clean_samples_stay_where_a_joint_has_no_noise(quiet, tmp_path):
    """Errors of accelerations are all that such a joint shows; they are no white noise."""
    robot = load(ROBOT)
    motion = simulated(robot, 6.0, 100.0)
    rng = np.random.default_rng(quiet)
    efforts = motion.effort + 0.01 * motion.effort.std(axis=0) * rng.normal(size=(600, 3))
    efforts[:, quiet] = motion.effort[:, quiet]
    positions = motion.position + 1e-6 * rng.normal(size=(600, 3))
    head = ["time", *motion.names]
    for part in ("velocity", "effort"):
        head += [f"{name}.{part}" for name in motion.names]
    file = csv_of(tmp_path / "a.csv", head, motion.time, positions, motion.velocity, efforts)
    run("make", tmp_path / "in", "--robot", ROBOT, "--trajectory", file)
    found = json.loads(printed("identify", tmp_path / "in", "--json"))
    assert len(found["left_out"]) <= 3
