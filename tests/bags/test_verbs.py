"""What is made, told, exported and identified, by the command and by the functions under it."""

from __future__ import annotations

import csv
import dataclasses
import json
import re
from importlib import resources
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.figure import Figure

from hybrid_dynamics_cli.bags.identification_text import (
    _determined,
    _term_lines,
)
from hybrid_dynamics_cli.bags.process import pace
from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_core.dynamics.parameters import described_parameters
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.ground.progress import Progress
from hybrid_dynamics_core.identification import noise_limit
from hybrid_dynamics_core.simulation import simulate
from hybrid_dynamics_ros.bags.analysis.collect import collect
from hybrid_dynamics_ros.bags.analysis.figures import (
    _draw_faults,
    _draw_intervals,
    efforts,
    margins,
    sampling,
)
from hybrid_dynamics_ros.bags.analysis.identify import identify_recording
from hybrid_dynamics_ros.bags.analysis.plotting import widen
from hybrid_dynamics_ros.bags.analysis.report import accelerations_of, report
from hybrid_dynamics_ros.bags.analysis.report_tables import outliers_table
from hybrid_dynamics_ros.bags.analysis.stamp_intervals import StampIntervals
from hybrid_dynamics_ros.bags.errors import BagError
from hybrid_dynamics_ros.bags.input_topic import INPUT
from hybrid_dynamics_ros.bags.job import Job, Outcome
from hybrid_dynamics_ros.bags.make import START_NS, _sine_sums, simulated, write_trajectory
from hybrid_dynamics_ros.bags.parallel import attempt, run_jobs
from hybrid_dynamics_ros.bags.process import process
from hybrid_dynamics_ros.bags.sample_outliers import SampleOutlier
from hybrid_dynamics_ros.bags.storage.bag_reader import BagReader
from hybrid_dynamics_ros.bags.trajectory_file import Trajectory, read_trajectory
from hybrid_dynamics_ros.parameters import FILTER_TYPE, KALMAN, NodeSettings
from tests.bags.calling import output, run
from tests.bags.messages import bag, joint_state, motion_of, recorded

ROBOT = "forging_chu2020"
MS = 10**6


def npz(path):
    """The columns of a file."""
    with np.load(path) as file:
        return dict(file)


def test_a_trajectory_file_becomes_a_bag_and_comes_back(forging, tmp_path):
    time, u, du, _ = motion_of(forging, 50)
    head = ",".join(["time", *forging.active, *(f"{name}.velocity" for name in forging.active)])
    table = np.column_stack([time, u, du])
    np.savetxt(tmp_path / "a.csv", table, fmt="%.17g", delimiter=",", header=head, comments="")
    np.savez(tmp_path / "a.npz", time=time, position=u, velocity=du)
    for name in ("a.csv", "a.npz"):
        output(
            "make",
            "--overwrite",
            tmp_path / "bag",
            "--robot",
            ROBOT,
            "--trajectory",
            tmp_path / name,
        )
        output("export", tmp_path / "bag", tmp_path / "tables", "--format", "npz", "--overwrite")
        table = npz(tmp_path / "tables" / "hybrid_dynamics.active_joint_states.npz")
        for k, joint in enumerate(forging.active):
            assert np.array_equal(table[f"position[{joint}]"], u[:, k])
            assert np.array_equal(table[f"velocity[{joint}]"], du[:, k])
        assert np.array_equal(np.diff(table["header.stamp_ns"]), np.full(49, 10 * MS))


@pytest.mark.parametrize("lasts", [6e8, 1e18])
def test_a_trajectory_beyond_the_stamps_of_ros_is_refused(forging, tmp_path, lasts):
    """20 years, or nanoseconds taken for seconds.

    The bag's stamps begin in 2020 and end in January 2038.
    """
    u = motion_of(forging, 3)[1]
    np.savez(tmp_path / "a.npz", time=[0.0, 1.0, lasts], position=u)
    told = output(
        "make", tmp_path / "bag", "--robot", ROBOT, "--trajectory", tmp_path / "a.npz", code=1
    )
    assert f"lasts {lasts:.10g} s, and stamps of ROS reach 569646847 s beyond the start" in told
    assert not (tmp_path / "bag").exists()


@pytest.mark.parametrize("name", ["a.npz", "a.csv"])
def test_a_saved_simulation_becomes_a_trajectory(name, tmp_path):
    robot = load("five_bar")
    motion = simulate(robot, robot.reference, [0.4, -0.3, 0.1], None, (0.0, 0.05))
    motion.save(tmp_path / name)
    found = read_trajectory(tmp_path / name, robot)
    assert np.array_equal(found.time, motion.t)
    for part, whole in (
        ("position", "u"),
        ("velocity", "du"),
        ("acceleration", "ddu"),
        ("effort", "tau"),
    ):
        assert np.array_equal(getattr(found, part), getattr(motion, whole)), part
    done = run("make", tmp_path / "bag", "--robot", "five_bar", "--trajectory", tmp_path / name)
    assert f"{robot.active[0]}.acceleration" in done.stderr  # joint states hold none
    output("export", tmp_path / "bag", tmp_path / "tables", "--format", "npz")
    table = npz(tmp_path / "tables" / "hybrid_dynamics.active_joint_states.npz")
    for k, joint in enumerate(robot.active):
        assert np.array_equal(table[f"velocity[{joint}]"], motion.du[:, k])


def test_trajectories_of_earlier_versions_keep_their_rates(tmp_path):
    robot = load("five_bar")
    time, u = np.arange(5) * 0.1, np.tile(robot.reference, (5, 1))
    du, ddu = np.full_like(u, 0.25), np.full_like(u, 0.5)
    head = ",".join(["t", *robot.active, *(f"{name}.rate" for name in robot.active)])
    np.savetxt(
        tmp_path / "a.csv", np.column_stack([time, u, du]), delimiter=",", header=head, comments=""
    )
    np.savez(tmp_path / "a.npz", t=time, state_u=u, state_du=du, ddu=ddu)
    assert np.array_equal(read_trajectory(tmp_path / "a.csv", robot).velocity, du)
    found = read_trajectory(tmp_path / "a.npz", robot)
    assert np.array_equal(found.velocity, du)
    assert np.array_equal(found.acceleration, ddu)


@pytest.mark.parametrize(
    ("columns", "told"),
    [
        (
            ["slew.speed", "boom_cylinder.speed"],
            "column slew.speed, boom_cylinder.speed is not known",
        ),
        (
            ["slew.velocity"],
            "no column boom_cylinder.velocity, stick_cylinder.velocity, bucket_cylinder.velocity; expected velocity of all",  # noqa: E501
        ),
        (["slew"], "two columns have the same name"),
    ],
)
def test_columns_of_active_joints_are_never_dropped_in_silence(columns, told, tmp_path):
    robot = load("excavator")
    names = ["time", *robot.active, *columns]
    rows = np.column_stack(
        [np.arange(3), np.tile(robot.reference, (3, 1)), np.zeros((3, len(columns)))]
    )
    np.savetxt(tmp_path / "a.csv", rows, delimiter=",", header=",".join(names), comments="")
    with pytest.raises(BagError, match=told):
        read_trajectory(tmp_path / "a.csv", robot)


def test_a_simulation_has_the_noise_that_was_asked_for(forging, tmp_path):
    motion = simulated(forging, 5.0, 500.0)
    noisy = motion.noisy({"position": 1e-4, "effort": 3.0})
    assert (noisy.position - motion.position).std() == pytest.approx(1e-4, rel=0.05)
    assert (noisy.effort - motion.effort).std() == pytest.approx(3.0, rel=0.05)
    assert noisy.velocity is motion.velocity
    told = output(
        "make", tmp_path / "bag", "--robot", ROBOT, "--seconds", 1, "--noise", "weight=3", code=2
    )
    assert "position, velocity, effort" in told


def test_exports_agree_whatever_the_format(forging, tmp_path):
    pytest.importorskip("pyarrow")
    from pyarrow import parquet

    process(Job(bag(tmp_path / "in", recorded(forging, 20)), tmp_path / "out", ROBOT))
    for kind in ("csv", "npz", "parquet"):
        output(
            "export",
            tmp_path / "out",
            tmp_path / kind,
            "--format",
            kind,
            "--topic",
            "/hybrid_dynamics/closed_state",
        )
    name = "hybrid_dynamics.closed_state"
    with (tmp_path / "csv" / f"{name}.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    columns = npz(tmp_path / "npz" / f"{name}.npz")
    table = parquet.read_table(tmp_path / "parquet" / f"{name}.parquet")
    assert len(rows) == 20
    for column in ("residual", "singularity[theta_2]", "to_lower[q12]", "nearest_loop"):
        expected = [row[column] for row in rows]
        assert [str(value) for value in columns[column].tolist()] == expected
        assert [str(value) for value in table[column].to_pylist()] == expected


@pytest.mark.parametrize(("smooth", "least"), [("causal", 1.0), ("savgol", 20.0), ("spline", 20.0)])
def test_smoothing_with_the_future_has_no_lag(smooth, least, forging, tmp_path):
    """Beside the causal filter's error, smoothing is at least `least` times smaller."""
    time, u, du, ddu = motion_of(forging, 400, 200.0)
    pairs = [
        (round(t * 1e9), joint_state(round(t * 1e9), forging.active, p, v))
        for t, p, v in zip(time, u, du, strict=True)
    ]
    track = collect(bag(tmp_path / "in", pairs), ROBOT, smooth=smooth)
    inner = (track.time > 0.4) & (track.time < 1.6)
    error = np.abs(track.acceleration[inner] - ddu[-len(track.time) :][inner]).max()
    lag = (
        np.abs(ddu).max() * 3.0 * 0.0205
    )  # what a delay of the filter's lag does to the fastest sine
    assert error < lag / least


def test_identification_finds_base_parameters_within_its_confidence(forging, tmp_path):
    motion = simulated(forging, 40.0, 100.0, seed=5).noisy({"effort": 0.5})
    write_trajectory(tmp_path / "rec", motion, INPUT, {"robot": ROBOT})
    found = identify_recording(collect(tmp_path / "rec", smooth="spline"))
    truth = found.identification.base.values(
        described_parameters(forging.description).values(forging.description)
    )
    inside = (truth > found.identification.interval[:, 0]) & (
        truth < found.identification.interval[:, 1]
    )
    assert (
        inside.mean() > 0.85
    )  # of 43 independent 95 % intervals fewer are as good as never inside
    assert found.residual == pytest.approx(0.5, rel=0.1)  # held out: nothing but the noise is left
    assert found.test_count == pytest.approx(1000, abs=20)
    told = json.loads(output("identify", tmp_path / "rec", "--json"))
    assert len(told["base"]) == found.identification.base.size
    assert told["unsettled"] == list(found.undetermined)
    assert "excites too little" not in output("identify", tmp_path / "rec")
    assert output("identify", tmp_path / "rec", "--topic", "/none", code=2).startswith("Error: ")


def test_a_motion_that_shows_too_little_is_told(forging, tmp_path):
    """In noise of 1 kN most signs are not known; parameters that are 0 in the file do not count."""
    motion = simulated(forging, 20.0, 100.0, seed=5).noisy({"effort": 1000.0})
    write_trajectory(tmp_path / "rec", motion, INPUT, {"robot": ROBOT})
    found = identify_recording(collect(tmp_path / "rec", smooth="spline"))
    true = found.identification.base.values(
        described_parameters(forging.description).values(forging.description)
    )
    known = (
        np.abs(found.identification.estimate)
        > noise_limit(found.identification.base.size) * found.identification.deviation
    )
    meant = np.abs(true) > 1e-6  # zeros of the file are zero to rounding
    assert len(found.nonzero_in_file) == meant.sum() < found.identification.base.size
    assert len(found.undetermined) == (meant & ~known).sum()
    said = " ".join(output("identify", tmp_path / "rec").split())
    assert (
        f"of {len(found.nonzero_in_file)} base parameters that are not 0 in the robot file" in said
    )
    assert f"the signs of {len(found.undetermined)} are not known" in said


@pytest.mark.sweep(sample="test_identification_finds_base_parameters_within_its_confidence")
def test_identification_tells_what_is_determined_on_lines_that_fit(tmp_path):
    output(
        "make",
        tmp_path / "rec",
        "--robot",
        "excavator",
        "--seconds",
        10,
        "--rate",
        100,
        "--noise",
        "effort=50",
    )
    told = json.loads(
        output("identify", tmp_path / "rec", "--json", "--output", tmp_path / "all.csv")
    )
    base = told["base"]
    determined = told["determined"]
    assert {name for name in base if name in determined} < {
        name for name, part in base.items() if not part["low"] <= 0.0 <= part["high"]
    }
    assert 5 < len(determined) < len(base) - 5
    said = output("identify", tmp_path / "rec")
    every = output("identify", tmp_path / "rec", "--all")
    assert max(map(len, (*said.splitlines(), *every.splitlines()))) <= 80
    for text in (said, every):
        assert text.startswith(f"{len(determined)} of {len(base)} base parameters are determined")
    leads = {
        name: re.split(r" (?=[+-] )", name)[0] for name in base
    }  # of two combinations no two begin alike
    head, rule, *lines = said[said.index("determined  ") :].splitlines()
    assert head.split("  ")[0] == "determined"
    place = rule.index(" ")  # where the numbers begin, on the line of the terms or below it
    terms = [line for line in lines if line[:place].strip()]
    assert [re.split(r" (?=[+-] |\.\.\. )| {2,}", line)[0] for line in terms] == [
        leads[name] for name in determined
    ]
    shown = re.findall(r"(\S+) +\S+ +\S+ +\S+  kg(?: m|$)", "\n".join(lines), re.MULTILINE)
    estimates = [base[name]["estimate"] for name in determined]
    assert list(map(float, shown)) == pytest.approx(estimates, rel=1e-5)
    unwrapped = " ".join(every.split())
    assert all(name in unwrapped for name in base)
    assert (tmp_path / "all.csv").read_text(encoding="utf-8").count("\n") == len(base) + 1


def test_the_pace_is_told_where_it_means_something():
    assert pace(0.05, 0.3) == "0.3 s"
    assert pace(0.0, 0.0) == "0.0 s"
    assert pace(600.0, 2.5) == "2.5 s, 240 times real time"
    assert pace(2.0, 5.0) == "5.0 s, 0.4 times real time"


def test_a_short_bag_is_not_zero_times_real_time(forging, tmp_path):
    told = output(
        "process", bag(tmp_path / "in", recorded(forging, 5)), tmp_path / "out", "--robot", ROBOT
    )
    assert "5 accepted" in told
    assert "real time" not in told


def test_a_wrong_robot_file_is_seen_in_the_held_out_part(forging, tmp_path):
    motion = simulated(forging, 20.0, 100.0, seed=5).noisy({"effort": 0.5})
    heavier = motion.effort * 1.1
    write_trajectory(
        tmp_path / "rec",
        type(motion)(motion.names, motion.time, motion.position, motion.velocity, heavier),
        INPUT,
        {"robot": ROBOT},
    )
    found = identify_recording(collect(tmp_path / "rec", smooth="spline"))
    assert (found.file_residual > 2.0 * found.residual)[:3].all()  # q4 carries next to nothing


@pytest.mark.usefixtures("painted")
def test_a_report_stands_alone_and_tells_of_gaps_and_bad_samples(forging, tmp_path):
    pairs = recorded(forging, 60)
    pairs[20] = (
        pairs[20][0],
        joint_state(pairs[20][0], forging.active, [0.0, 0.9, 0.1, 0.0], [0.0] * 4),
    )
    time, u, du, _ = motion_of(forging, 30)
    start = pairs[-1][0] + 3000 * MS
    late = [
        (
            start + round(t * 1e9),
            joint_state(start + round(t * 1e9), forging.active, p, v, [1.0] * 4),
        )
        for t, p, v in zip(time, u, du, strict=True)
    ]
    bag(tmp_path / "rec", pairs + late)
    told = output("report", tmp_path / "rec", "--robot", ROBOT)
    page = (tmp_path / "rec.html").read_text(encoding="utf-8")
    assert "89 accepted" in told
    assert page.count("<svg") == 6
    for part in re.findall(r"<svg.*?</svg>", page, re.DOTALL):
        ElementTree.fromstring(part)
    outside = re.findall(r'(?:src|href)="(?!#)[^"]*"', page)
    assert [link for link in outside if "w3.org" not in link] == []
    assert "refused by the model" in page
    assert "<td>gaps</td><td>1 (stamps that go back, or are more than 0.5 s apart" in page
    assert "recorded less computed" in page
    assert len(set(re.findall(r' id="([^"]+)"', page))) == len(re.findall(r' id="([^"]+)"', page))


@pytest.mark.sweep(sample="test_a_report_stands_alone_and_tells_of_gaps_and_bad_samples")
def test_a_report_draws_ends_of_strokes_in_view_and_nothing_where_nothing_is_missing(
    forging, tmp_path
):
    write_trajectory(tmp_path / "rec", simulated(forging, 2.0, 100.0), INPUT, {"robot": ROBOT})
    track = collect(tmp_path / "rec", ROBOT)
    strokes = margins(track).axes
    assert len(strokes) == len(track.margins[0])
    assert all(axes.get_ylim()[0] < 0.0 for axes in strokes)  # else the axis hides the line at zero
    noise = 1e-13 * np.random.default_rng(1).standard_normal(track.efforts.shape)
    suppress_rounding = efforts(dataclasses.replace(track, recorded=track.efforts + noise)).axes[
        1::2
    ]
    assert all(
        axes.get_ylim()[0] < -0.01 < 0.01 < axes.get_ylim()[1] for axes in suppress_rounding
    )  # rounding is a line
    (intervals,) = sampling(track).axes
    assert sum(bar.get_height() for bar in intervals.patches) == len(track.time) - 1
    page = report(track, "rec")
    assert re.search(r"<td>largest power</td><td>[\d.,]+ W</td>", page)
    assert (
        page.count("<th class=n>") == 8
    )  # of the efforts' table: 50 %, 95 %, far, RMS, mean, largest, explained, samples
    assert re.search(r"<td>q12</td><td>N</td><td class=n>", page)


@pytest.mark.sweep(sample="test_a_report_stands_alone_and_tells_of_gaps_and_bad_samples")
def test_a_report_says_where_accelerations_are_from_and_a_perfect_model_looks_perfect(
    forging, tmp_path
):
    write_trajectory(tmp_path / "rec", simulated(forging, 3.0, 200.0), INPUT, {"robot": ROBOT})
    said, left = {}, {}
    for smooth in ("spline", "savgol", "causal"):
        track = collect(tmp_path / "rec", smooth=smooth)
        said[smooth] = accelerations_of(track)
        left[smooth] = track.errors.rms / track.recorded.std(axis=0)
    output("report", tmp_path / "rec")
    assert said["spline"] in (tmp_path / "rec.html").read_text(encoding="utf-8")
    # two time constants of the filter, whose bandwidth is the node's 10 Hz: 2 sqrt(sqrt(2) - 1) /
    # (2 pi 10)
    assert "from the node's causal filter, which gives them 20.5 ms late" in said["causal"]
    assert "<code>--smooth spline</code>" in said["causal"]
    assert "from a spline through the samples before and after, which has no lag" in said["spline"]
    assert "from a Savitzky-Golay filter" in said["savgol"]
    assert (
        left["spline"] < 0.1 * left["causal"]
    ).all()  # exact rates at 200 Hz: the lag was all that the model left
    settings = NodeSettings({FILTER_TYPE.name: KALMAN})
    track = collect(tmp_path / "rec", settings=settings, smooth="causal")
    assert "from the node's Kalman filter, which has no lag" in accelerations_of(track)
    assert track.errors.rms[1] / track.recorded.std(axis=0)[1] < left["causal"][1] / 3.0


@pytest.mark.sweep(sample="test_a_report_stands_alone_and_tells_of_gaps_and_bad_samples")
def test_a_processed_bag_is_reported_with_the_rates_that_it_was_made_with(forging, tmp_path):
    source = bag(tmp_path / "in", recorded(forging, 60))
    for smooth in ("causal", "savgol"):
        process(Job(source, tmp_path / smooth, ROBOT, smooth=smooth, keep=True))
        assert collect(tmp_path / smooth, smooth=None).smooth == smooth
    assert collect(source, ROBOT, smooth=None).smooth == "spline"
    assert json.loads(output("report", tmp_path / "savgol", "--json"))["smooth"] == "savgol"


@pytest.fixture
def own_file(tmp_path):
    """The excavator in a file of one's own, under the same name.

    A robot that could be taken for the shipped one.
    """
    text = (
        resources.files("hybrid_dynamics_core")
        .joinpath("robots", "excavator.yaml")
        .read_text(encoding="utf-8")
    )
    path = tmp_path / "own.yaml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("verb", ["process", "make"])
def test_a_bag_knows_the_file_of_its_robot(verb, own_file, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    output("make", "rec", "--robot", "own.yaml", "--seconds", 0.5, "--rate", 200)
    if verb == "process":
        output("process", "rec", "results", "--robot", "own.yaml", "--keep")
    made = tmp_path / ("results" if verb == "process" else "rec")
    monkeypatch.chdir("/")
    track = collect(made)
    given = collect(made, str(own_file))
    assert Path(track.robot.description.file) == own_file.resolve()
    assert np.array_equal(track.efforts, given.efforts, equal_nan=True)
    own_file.write_text(own_file.read_text(encoding="utf-8") + "# a word\n", encoding="utf-8")
    assert "has been changed since then; give --robot FILE" in output("report", made, code=2)
    own_file.unlink()
    for told in (output("report", made, code=2), output("identify", made, code=2)):
        assert f"was made with {own_file}" in told
        assert "give --robot FILE" in told


def test_a_bag_that_only_names_a_robot_of_its_own_asks_for_the_file(forging, tmp_path):
    write_trajectory(tmp_path / "rec", simulated(forging, 0.5, 100.0), INPUT, {"robot": "my_arm"})
    told = output("report", tmp_path / "rec", code=2)
    assert (
        "was made with 'my_arm', which is not a shipped robot, and does not tell its file; give"
        " --robot FILE" in told
    )


@pytest.mark.sweep(sample="test_a_report_stands_alone_and_tells_of_gaps_and_bad_samples")
def test_many_bags_give_the_same_in_processes_and_a_failed_one_is_told(forging, tmp_path):
    (tmp_path / "night").mkdir()
    for k in range(2):
        bag(tmp_path / "night" / f"b{k}", recorded(forging, 30, seed=k))
    (tmp_path / "night" / "c.mcap").write_bytes(b"no")
    told = output("process", tmp_path / "night", tmp_path / "one", "--robot", ROBOT, code=1)
    assert "c.mcap: failed: c.mcap: 2 bytes" in told
    output("process", tmp_path / "night", tmp_path / "two", "--robot", ROBOT, "--jobs", 2, code=1)
    for k in range(2):
        one, two = (tmp_path / name / f"b{k}" / f"b{k}.mcap" for name in ("one", "two"))
        assert one.read_bytes() == two.read_bytes()
    assert sorted(p.name for p in (tmp_path / "two").iterdir()) == ["b0", "b1"]


def test_a_dask_cluster_gives_the_same(forging, tmp_path):
    distributed = pytest.importorskip("distributed")
    source = bag(tmp_path / "in", recorded(forging, 30))
    one, two = (Job(source, tmp_path / name / "out", ROBOT) for name in ("one", "two"))
    assert isinstance(attempt(one), Outcome)
    with distributed.LocalCluster(
        1, processes=False, dashboard_address=None, threads_per_worker=1
    ) as cluster:
        results = run_jobs(
            [two, Job(tmp_path / "none", tmp_path / "o", ROBOT)],
            scheduler=cluster.scheduler_address,
        )
    assert isinstance(results[0], Outcome)
    assert "there is no such file or folder" in results[1]
    assert (one.target / "out.mcap").read_bytes() == (two.target / "out.mcap").read_bytes()


def test_parameters_of_the_node_count_here_too(forging, tmp_path):
    source = bag(tmp_path / "in", recorded(forging, 30))
    params = tmp_path / "p.yaml"
    params.write_text(
        "/**:\n  ros__parameters:\n    payload: {mass: 50.0}\n    rates: {joint_states: -1}\n",
        encoding="utf-8",
    )
    output("process", source, tmp_path / "plain", "--robot", ROBOT)
    output("process", source, tmp_path / "laden", "--robot", ROBOT, "--params", params)
    for name in ("plain", "laden"):
        output("export", tmp_path / name, tmp_path / f"{name}_t", "--format", "npz")
    assert not (tmp_path / "laden_t" / "hybrid_dynamics.joint_states.npz").exists()
    plain, laden = (
        npz(tmp_path / f"{name}_t" / "hybrid_dynamics.required_efforts.npz")["effort[q12]"]
        for name in ("plain", "laden")
    )
    assert np.abs(laden - plain).min() > 100.0
    params.write_text("/**:\n  ros__parameters: {payload: {mas: 1.0}}\n", encoding="utf-8")
    assert "payload.mas" in output(
        "process", source, Path(tmp_path / "x"), "--robot", ROBOT, "--params", params, code=1
    )


TWO_BARS = """
format: 1
name: two_bars
links: {base: {}, one: {mass: 1, com: [0.1, 0, 0]}, two: {mass: 1, com: [0.1, 0, 0]}}
joints:
  q1: {type: revolute, parent: base, child: one, axis: z, limits: [0.2, 0.6]}
  q2: {type: revolute, parent: one, child: two, axis: y, limits: [-0.2, 9]}
active: [q1, q2]
end_effector: {link: two}
reference: {q1: 0.3, q2: 0.6}
"""


def test_a_made_motion_sweeps_nine_tenths_of_each_range(python_kernels):  # noqa: ARG001
    """Of the limits, or of 1 rad to each side of the reference where that is less."""
    position = simulated(Robot(parse_description(TWO_BARS)), 20.0, 20.0).position
    middle, half = np.array([0.4, 0.7]), np.array([0.2, 0.9])
    assert np.abs(position - middle).max(axis=0) == pytest.approx(0.9 * half, rel=1e-9)


def test_made_motions_have_all_frequencies_of_their_band_and_no_others() -> None:
    """0.3 to 6 rad/s, of 200 sines; the window leaks into its next neighbours alone."""
    time = 0.5 * np.arange(4000)
    waves, _, _ = _sine_sums(np.random.default_rng(0), time, 40)
    heights = np.abs(np.fft.rfft(waves * np.hanning(len(time))[:, None], axis=0)).max(axis=1)
    rates = 2.0 * np.pi * np.fft.rfftfreq(len(time), 0.5)
    tall = rates[heights > 0.01 * heights.max()]
    assert 0.28 < tall.min() < 0.5
    assert 5.8 < tall.max() < 6.02


@pytest.mark.parametrize("step", [0.1, 3600.0, 86_400.5])
def test_stamps_of_made_bags_are_exact_after_hours(step: float, tmp_path: Path) -> None:
    time = step * np.arange(3)
    motion = Trajectory(("q",), time, np.zeros((3, 1)), None, None)
    write_trajectory(tmp_path / "made", motion, INPUT, {})
    with BagReader(tmp_path / "made") as source:
        stamps = [log for _, messages in source.read() for log, _ in messages.raw()]
    assert stamps == [START_NS + k * round(step * 1000) * MS for k in range(3)]


@pytest.mark.parametrize("keep", [False, True])
def test_the_line_of_progress_ends_at_all_messages(keep, forging, tmp_path, monkeypatch) -> None:
    lines = []

    class Line(Progress):
        def __init__(self, label, total, shown=None):
            super().__init__(label, total, shown)
            lines.append([total])

        def update(self, done):
            lines[-1].append(done)

    for module in ("process", "analysis.collect"):
        monkeypatch.setattr(f"hybrid_dynamics_ros.bags.{module}.Progress", Line)
    recording = bag(tmp_path / "in", recorded(forging, 30))
    process(Job(recording, tmp_path / "out", ROBOT, keep=keep))
    collect(recording, ROBOT)
    assert [(line[0], line[-1]) for line in lines] == [(30, 30), (30, 30)]


@pytest.mark.parametrize("is_causal", [False, True])
def test_rows_of_faults_are_in_view_with_the_same_room_above_and_below(is_causal: bool) -> None:
    axes = Figure().add_subplot()
    track = SimpleNamespace(
        stamps=StampIntervals(0.0, np.full(3, 0.01)),
        gaps=[],
        outliers=[],
        refused=[(0.01, "why")],
        time=np.array([0.0, 0.03]),
        is_causal=is_causal,
    )
    _draw_faults(axes, track)
    low, high = axes.get_ylim()
    heights = axes.get_yticks()
    assert len(heights) == 3 - is_causal
    assert min(heights) - low == pytest.approx(high - max(heights))
    assert 0.0 < high - max(heights) < 1.0


@pytest.mark.parametrize(("late", "words"), [(0.0995, "99.5 ms late"), (-0.0995, "99.5 ms early")])
def test_the_page_says_how_late_a_stamp_is_in_milliseconds(late: float, words: str) -> None:
    robot = SimpleNamespace(joint_types={"q": "revolute"})
    outlier = SampleOutlier(12_500_000_000, 0, True, 0.25, late)
    track = SimpleNamespace(outliers=[outlier], measured=["q"], robot=robot, start_ns=10**9)
    page = outliers_table(track)
    for cell in ("11.500 s", "q", "0.25 rad/s", words):
        assert f">{cell}</td>" in page


@pytest.mark.parametrize("length", [0.0, 1e-4, 1.0, 3600.0])
def test_marks_at_the_ends_of_axes_are_seen_and_curves_fill_them(length: float) -> None:
    low, high = widen(7.0, 7.0 + length)
    assert low < 7.0
    assert high > 7.0 + length
    assert high - low <= max(1.1 * length, 0.01)


@pytest.mark.parametrize("interval", [0.01, 0.25])
def test_intervals_are_drawn_in_milliseconds(interval: float) -> None:
    """Those that are all alike in a range of a tenth of them, with room."""
    axes = Figure().add_subplot()
    stamps = StampIntervals(0.0, np.full(40, interval))
    assert _draw_intervals(axes, stamps) == "40 intervals"
    expected = 1e3 * interval * np.array([0.98, 1.02])
    assert axes.get_xlim() == pytest.approx(expected, rel=1e-9)


def test_the_page_says_the_lag_in_milliseconds() -> None:
    track = SimpleNamespace(is_causal=True, causal_lag=0.0995)
    assert "gives them 99.5 ms late" in accelerations_of(track)


@pytest.mark.parametrize(
    ("open_count", "words"), [(3, "3 are not determined"), (5, "excites too little")]
)
def test_a_motion_that_leaves_less_than_half_open_is_not_called_too_slow(open_count, words):
    known = tuple("abcdefgh")
    result = SimpleNamespace(
        determined=known[open_count:],
        unphysical=(),
        nonzero_in_file=known,
        undetermined=known[:open_count],
    )
    assert words in " ".join(_determined(result, 10))


@pytest.mark.parametrize("excess", [0, 1])
def test_terms_are_cut_where_a_line_is_full(excess):
    last = " + b"
    name = "a" * (66 + excess - len(last)) + last
    assert (_term_lines(name, 66, everything=False) == [name]) == (excess == 0)
