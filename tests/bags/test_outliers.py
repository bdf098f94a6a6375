"""Samples that do not fit the motion or the model around them, and what stamps tell of those that
are missing.
"""

from __future__ import annotations

import dataclasses
import json
import re
from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import load
from hybrid_dynamics_ros.bags.analysis.collect import collect
from hybrid_dynamics_ros.bags.analysis.stamp_intervals import StampIntervals
from hybrid_dynamics_ros.bags.input_topic import INPUT
from hybrid_dynamics_ros.bags.job import Job
from hybrid_dynamics_ros.bags.make import simulated, write_trajectory
from hybrid_dynamics_ros.bags.process import process
from hybrid_dynamics_ros.bags.sample_outliers import _lateness, find_outliers
from tests.bags.calling import printed, run

ROBOT = "five_bar"
STEP = 0.01  # [s]
pytestmark = pytest.mark.usefixtures("python_kernels")


def waves(count=900, seed=0):
    """Times, positions and velocities of two joints that swing, with noise."""
    rng = np.random.default_rng(seed)
    time = STEP * np.arange(count)
    angle = np.array([2.0, 3.1]) * time[:, None]
    noise = rng.normal(size=(2, count, 2))
    return (
        time,
        np.sin(angle) + 1e-5 * noise[0],
        np.array([2.0, 3.1]) * np.cos(angle) + 1e-3 * noise[1],
    )


def ns(time):
    return 10**18 + np.round(time * 1e9).astype(np.int64)


@pytest.mark.parametrize("row", [0, 1, 450, 898, 899])
@pytest.mark.parametrize("measured", [True, False])
def test_a_stamp_that_is_late_is_found_and_by_how_much(row, measured):
    """At both ends, too, where a curve follows its last sample best."""
    time, position, velocity = waves()
    kept = np.setdiff1d(np.arange(900), np.arange(row + 1, row + 5))  # room for the late one
    late, position, velocity = 0.04, position[kept], velocity[kept]
    moved = time[kept]
    moved[row] += late
    found = find_outliers(ns(moved), position, velocity if measured else None)
    assert list(found) == [row]
    assert found[row].late == pytest.approx(late, abs=2e-3)  # a parabola through six neighbours
    assert found[row].stamp_ns == ns(moved)[row]


@pytest.mark.parametrize("measured", [True, False])
def test_a_reading_that_jumps_is_found_with_its_joint(measured):
    time, position, velocity = waves()
    position[300, 1] += 0.5
    (row,) = found = find_outliers(ns(time), position, velocity if measured else None)
    assert (row, found[row].joint, found[row].rate) == (300, 1, False)
    assert found[row].off == pytest.approx(0.5, abs=0.05)


def test_several_bad_samples_are_all_found():
    time, position, velocity = waves()
    rows = [10, 11, 200, 239, 240, 241, 700]
    position[rows, 0] += 0.4 * np.array([1, -1, 1, 1, -1, 1, 1])
    velocity[500, 1] += 3.0
    found = find_outliers(ns(time), position, velocity)
    assert sorted(found) == [10, 11, 200, 239, 240, 241, 500, 700]
    assert found[500].rate


def jittered(time):
    return time + np.random.default_rng(1).uniform(-0.4, 0.4, len(time)) * STEP


def sampled_late(time, values):
    """What a joint shows where stamps jitter and readings do not: noise of a stamp."""
    return np.stack([np.interp(jittered(time), time, part) for part in values.T], axis=-1)


def corners(time):
    """Velocity in ramps: a motion profile with jumps of the acceleration."""
    rate = np.clip(np.abs((time % 2.0) - 1.0) * 4.0 - 1.0, 0.0, 2.0)
    return np.cumsum(rate)[:, None] * STEP, rate[:, None]


def test_what_is_no_fault_of_a_sample_is_none():
    time, position, velocity = waves()
    counts = np.round(position / 1e-3) * 1e-3  # an encoder's
    still = np.zeros((900, 2)) + 1e-3 * (
        np.random.default_rng(2).random((900, 2)) < 0.02
    )  # a digit that flickers
    gap = np.delete(np.arange(900), np.arange(400, 413))
    assert not find_outliers(ns(time), position, velocity)
    assert not find_outliers(ns(time), position, None)
    assert not find_outliers(ns(time), counts, None)
    assert not find_outliers(ns(time), still, None)
    assert not find_outliers(ns(time), sampled_late(time, position), None)
    assert not find_outliers(ns(time)[gap], position[gap], velocity[gap])
    assert not find_outliers(ns(time), *corners(time))
    assert not find_outliers(ns(time), corners(time)[0], None)
    assert not find_outliers(ns(time), np.zeros((900, 2)), np.zeros((900, 2)))
    assert not find_outliers(ns(time)[:5], position[:5], velocity[:5])


def recording(folder: Path, change, seconds=10.0, noise=0.05) -> Path:
    """A bag of a motion with its efforts, changed."""
    robot = load(ROBOT)
    motion = simulated(robot, seconds, 1.0 / STEP, 5).noisy(
        {"effort": noise, "position": 1e-6, "velocity": 1e-5}, 3
    )
    write_trajectory(folder / "rec", change(motion), INPUT, {"robot": ROBOT})
    return folder / "rec"


def late_first(motion):
    """The first stamp 46 ms late: 4 ms before the second."""
    time = np.concatenate([motion.time[:1], motion.time[5:]])
    time[0] = time[1] - 0.004
    kept = np.concatenate([[0], np.arange(5, len(motion.time))])
    parts = {name: getattr(motion, name)[kept] for name in ("position", "velocity", "effort")}
    return dataclasses.replace(motion, time=time, **parts)


def heavy_first(motion):
    """Efforts of another payload through the first 70 % of the recording."""
    effort = motion.effort.copy()
    effort[: round(0.7 * len(effort))] *= 1.5
    return dataclasses.replace(motion, effort=effort)


def test_a_late_stamp_spoils_neither_efforts_nor_estimates_and_is_named(tmp_path):
    path = recording(tmp_path, late_first)
    for smooth in ("spline", "savgol"):
        track = collect(path, smooth=smooth)
        (outlier,) = track.outliers
        assert outlier.at(track.start_ns) == 0.0
        assert outlier.late == pytest.approx(
            0.046, abs=0.003
        )  # a parabola through six samples, 46 ms before them
        assert np.isnan(track.efforts[0]).all()
        assert (
            track.errors.count.tolist() == [len(track.time) - 1] * 3 if smooth == "spline" else True
        )
        assert (
            track.errors.largest[:2] < 1.0
        ).all()  # 20 deviations; the late stamp made some ten N m of it
    told = json.loads(printed("identify", path, "--json"))
    assert told["worse_than_file"] == []
    first = told["left_out"][0]
    assert first["time"] == 0.0
    assert first["what"] in ("position", "velocity")
    assert first["late"] == pytest.approx(0.046, abs=0.003)
    assert re.search(
        r"0\.000 s +\w+ +(position|velocity) +-?[\d.]+ (rad|m)(/s)? +4[3-8][\d.]* ms late",
        printed("identify", path),
    )
    outcome = process(Job(path, tmp_path / "out", ROBOT, smooth="spline"))
    assert len(outcome.outliers) == 1
    assert "ms late" in printed(
        "process", path, tmp_path / "again", "--robot", ROBOT, "--smooth", "spline"
    )


def test_spikes_of_efforts_are_left_out_counted_and_named(tmp_path):
    rows = [50, 333, 620, 900]  # the last is held out

    def spiky(motion):
        effort = motion.effort.copy()
        effort[rows, 1] += [40.0, -70.0, 30.0, 55.0]
        return dataclasses.replace(motion, effort=effort)

    told = json.loads(printed("identify", recording(tmp_path, spiky), "--json"))
    named = {
        round(entry["time"] / STEP): entry
        for entry in told["left_out"]
        if entry["what"] == "effort"
    }
    assert set(rows) <= set(named)
    assert {named[row]["joint"] for row in rows} == {load(ROBOT).active[1]}
    assert named[333]["off"] == pytest.approx(-70.0, abs=1.0)
    assert told["worse_than_file"] == []
    assert all(
        part["left_by_estimate"] < 0.1 for part in told["held_out"].values()
    )  # noise of 0.05, and spikes of 55
    said = printed("identify", tmp_path / "rec")
    assert (
        f"{len(told['left_out'])} samples left out: {len(told['left_out'])} with efforts that noise"
        " does not" in said
    )
    assert re.search(
        r"^left out +joint +off in +by$", said, re.MULTILINE
    )  # of stamps there is nothing to tell


def test_estimates_that_are_worse_than_the_file_say_so_first_and_cutting_mends_them(tmp_path):
    path = recording(tmp_path, heavy_first, noise=0.002)  # a tenth of the efforts
    said = printed("identify", path)
    assert said.startswith("The estimates are worse than the robot file: ")
    assert "determined  " not in said
    told = json.loads(printed("identify", path, "--json"))
    assert told["determined"] == []
    assert told["worse_than_file"]
    cut = json.loads(printed("identify", path, "--from", 7.01, "--json"))
    assert cut["worse_than_file"] == []
    assert cut["determined"]
    assert all(entry["time"] >= 7.01 for entry in cut["left_out"])


def test_a_span_is_as_if_the_rest_were_not_there_and_times_stay_those_of_the_bag(tmp_path):
    path = recording(tmp_path, lambda motion: motion, seconds=4.0)
    whole = collect(path, smooth="causal")
    part = collect(path, smooth="causal", span=(1.0, 2.5))
    assert (part.time[0], part.time[-1]) == pytest.approx((1.0, 2.5), abs=1e-9)
    assert part.counts.received == 151
    assert part.start_ns == whole.start_ns
    rows = np.searchsorted(whole.time, part.time + 1e-6) - 1
    assert np.array_equal(part.state.u, whole.state.u[rows])
    assert np.isnan(part.efforts[0]).all()  # the filter starts at 1 s
    assert "no sample from 9 s to the end" in " ".join(
        run_error("identify", path, "--from", 9).split()
    )
    assert "is not after" in run_error("report", path, "--from", 2, "--to", 1, code=2)


def run_error(*words: object, code: int = 1) -> str:
    return run(*words, code=code).stderr


def test_missing_samples_are_counted_and_late_stamps_are_none():
    steps = np.full(200, 0.01)
    steps[[20, 21]] = 0.018, 0.002  # a late stamp
    steps[[40, 41]] = 0.002, 0.018  # an early one
    steps[100], steps[150] = 0.14, 0.0201
    stamps = StampIntervals(0.5, steps)
    assert stamps.nominal == pytest.approx(0.01)
    assert stamps.longest == pytest.approx((0.14, 0.5 + 1.0))
    assert [count for _, _, count in stamps.missing] == [13, 1]
    assert [at for at, _, _ in stamps.missing] == pytest.approx([1.5, 0.5 + 1.5 + 0.13])
    assert StampIntervals(0.0, np.zeros(0)).missing == []
    assert StampIntervals(0.0, np.zeros(3)).missing == []


def test_a_report_counts_every_interval_names_the_longest_and_says_what_a_gap_is(tmp_path):
    pytest.importorskip("matplotlib")
    from hybrid_dynamics_ros.bags.analysis.figures import efforts, sampling

    def holed(motion):
        time = motion.time.copy()
        time[300:] += 0.13
        effort = motion.effort.copy()
        effort[500, 0] += 80.0
        position, velocity = (getattr(motion, name) for name in ("position", "velocity"))
        return dataclasses.replace(
            motion, time=time, position=position, velocity=velocity, effort=effort
        )

    path = recording(tmp_path, holed)
    track = collect(path, smooth="spline")
    bars, _ = sampling(track).axes
    assert (
        sum(bar.get_height() for bar in bars.patches) == 998
    )  # of 999 intervals; the longest is beyond the axis
    assert bars.get_title() == "998 of 999 intervals; 1 longer, to 140 ms"
    left = efforts(track).axes[1]
    assert left.get_ylim()[1] < 5.0  # of noise of 0.05 N m: the spike of 80 does not flatten it
    assert any(re.search("beyond, to (79|80)", text.get_text()) for text in left.texts)
    told = json.loads(printed("report", path, "--json"))
    assert told["stamps"] == {
        "nominal": 0.01,
        "longest": pytest.approx([0.14, 2.99]),
        "missing": 13,
        "gaps": 0,
    }
    page = (tmp_path / "rec.html").read_text(encoding="utf-8")
    assert "the longest interval is 140 ms at 2.990 s" in page
    assert "<td>13, in intervals of more than 1.5 times the median, at 2.990 s</td>" in page
    assert "more than 0.5 s apart" in page
    assert "<th class=n>95 % within</th>" in page
    assert re.search(r"<td class=n>(79|80)[.\d]* at 5\.130 s</td>", page)


@pytest.mark.parametrize("late", [-0.02, 0.013])
def test_how_late_a_stamp_is_is_exact_on_a_parabola(late: float) -> None:
    time = 0.01 * np.arange(9.0)
    there = time.copy()
    there[4] -= late  # the sample was taken then, and says time[4]
    speed, bend = np.array([0.3, -1.2]), np.array([4.0, 9.0])
    positions = speed * there[:, None] + bend * there[:, None] ** 2
    found = _lateness(time, positions, 4, np.ones(2))
    assert found == pytest.approx(late, abs=1e-9)
