"""Smoothing that looks ahead: stand-in joints, and samples that the model cannot take."""

import numpy as np
import pytest

from hybrid_dynamics_core import load
from hybrid_dynamics_ros.bags.analysis.collect import collect
from hybrid_dynamics_ros.bags.job import Job
from hybrid_dynamics_ros.bags.process import process
from hybrid_dynamics_ros.bags.smooth import _savgol
from hybrid_dynamics_ros.bags.storage.compression import zstd
from hybrid_dynamics_ros.bags.storage.mcap_chunk import ChunkPacker, RecordBlock
from hybrid_dynamics_ros.bags.storage.mcap_format import PREFIX
from hybrid_dynamics_ros.bags.storage.storage import Messages
from hybrid_dynamics_ros.parameters import MEASURED, NodeSettings
from hybrid_dynamics_ros.stream.rate_limit import RateLimit
from tests.bags.messages import START, bag, joint_state, motion_of

MS = 10**6


@pytest.mark.parametrize("measured", [("p_L", "p_R", "q_T"), ("q_L", "p_R", "q_T")])
def test_joints_that_stand_in_for_the_active_ones_are_not_taken_as_those(measured, tmp_path):
    robot = load("five_bar")
    time, u, du, _ = motion_of(robot, 200)
    states = robot.close(u, du)
    places = [robot.coordinates.index(name) for name in measured]
    pairs = [
        (START + round(t * 1e9), joint_state(START + round(t * 1e9), measured, s, ds))
        for t, s, ds in zip(time, states.s[:, places], states.ds[:, places], strict=True)
    ]
    path, settings = bag(tmp_path / "in", pairs), NodeSettings({MEASURED.name: measured})
    for smooth in ("causal", "spline", "savgol"):
        track = collect(path, "five_bar", smooth=smooth, settings=settings)
        assert track.state.u == pytest.approx(u, abs=1e-9), smooth


@pytest.mark.parametrize("smooth", ["spline", "savgol"])
def test_a_sample_beyond_all_numbers_is_refused_and_leaves_its_neighbours_alone(smooth, tmp_path):
    robot = load("ankle")
    time, u, du, ddu = motion_of(robot, 400)
    rates = du.copy()
    rates[100] = 1e200
    stamps = [START + round(t * 1e9) for t in time]
    pairs = [
        (t, joint_state(t, robot.active, p, v)) for t, p, v in zip(stamps, u, rates, strict=True)
    ]
    path = bag(tmp_path / "in", pairs)
    track = collect(path, "ankle", smooth=smooth)
    assert (track.counts.accepted, track.counts.rejected.total()) == (399, 1)
    kept = np.delete(ddu, 100, axis=0)
    assert np.abs(track.acceleration - kept)[5:-5].max() < 0.05 * np.abs(kept).max()
    outcome = process(Job(path, tmp_path / "out", "ankle", smooth=smooth))
    assert "399 accepted" in outcome.summary


@pytest.mark.parametrize("rate", [1e-10, 1e-5, 1e-300])
def test_a_rate_of_once_in_an_age_sends_the_first(rate):
    stamps = START + MS * np.arange(50)
    alone, together = RateLimit(), RateLimit()
    due = [k for k, stamp in enumerate(stamps.tolist()) if alone.due(stamp, rate)]
    assert together.due_rows(stamps, rate).tolist() == due == [0]
    assert together.due_rows(stamps + 10**9, rate).tolist() == []


def test_messages_without_a_byte_are_packed():
    messages = Messages.of([START, START + 5, START + 7], [b"", b"some", b""])
    chunk = ChunkPacker().pack(list(RecordBlock.copies(3, messages)))
    records = zstd.decompress(chunk.compressed)
    assert len(records) == chunk.size == 3 * PREFIX + 4
    assert records.count(b"some") == 1
    assert chunk.indices[3][:, 0].tolist() == [START, START + 5, START + 7]


@pytest.mark.parametrize("count", [20, 21])
def test_a_recording_shorter_than_a_period_is_smoothed_over_all_of_it(count):
    """A polynomial of the filter's degree is its own derivative to rounding."""
    time = 0.01 * np.arange(count)
    values = np.stack([time**4 - time, 3.0 * time**2], axis=-1)
    rate, bend = _savgol(time, values, 0.5, (1, 2))
    assert rate == pytest.approx(np.stack([4.0 * time**3 - 1.0, 6.0 * time], axis=-1), abs=1e-9)
    assert bend == pytest.approx(np.stack([12.0 * time**2, 6.0 + 0.0 * time], axis=-1), abs=1e-7)
