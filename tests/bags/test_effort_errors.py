"""Errors of efforts: what most are within does not move with a few that are far off.

Those are counted.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import load
from hybrid_dynamics_ros.bags.analysis.collect import collect
from hybrid_dynamics_ros.bags.analysis.effort_error import effort_errors
from hybrid_dynamics_ros.bags.input_topic import INPUT
from hybrid_dynamics_ros.bags.make import simulated, write_trajectory
from tests.cli.calling import call

SPIKES = (40, 120, 121, 300, 455)
MEDIAN = 0.6745  # of the sizes of Gaussian values of deviation 1


@pytest.fixture
def recording(tmp_path: Path, python_kernels: None) -> Path:  # noqa: ARG001
    """Five seconds of the five-bar with noise of 1 N m in its efforts, and five samples of the
    first that are off.
    """
    motion = simulated(load("five_bar"), 5.0, 100.0, 3).noisy({"effort": 1.0}, 3)
    assert motion.effort is not None
    effort = motion.effort.copy()
    effort[list(SPIKES), 0] += 1000.0
    write_trajectory(
        tmp_path / "recording", replace(motion, effort=effort), INPUT, {"robot": "five_bar"}
    )
    return tmp_path / "recording"


def test_what_is_far_off_is_counted_and_moves_the_rms_alone(recording: Path) -> None:
    first, *others = effort_errors(collect(recording, smooth="spline"))
    assert (first.far, first.joint) == (len(SPIKES), "q_L")
    assert [error.far for error in others] == [0] * len(others)
    for error in (first, *others):
        assert error.median == pytest.approx(
            MEDIAN, rel=0.15
        )  # of 500 samples: three deviations of their median
        assert error.near == pytest.approx(1.96, rel=0.15)
    assert first.rms > 50.0
    assert max(error.rms for error in others) < 2.0


@pytest.mark.sweep(sample="test_the_terminal_and_the_page_tell_it")
@pytest.mark.parametrize("bag", ["recording", "recording/"])
def test_the_page_is_named_as_the_bag_was(
    recording: Path, monkeypatch: pytest.MonkeyPatch, bag: str
) -> None:
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(recording.parent)
    assert call("bag", "report", bag).stdout.startswith("written: recording.html (report: ")
    monkeypatch.chdir(recording)
    assert (
        f"written: {recording.with_suffix('.html')} (" in call("bag", "report", ".").stdout
    )  # it has no name here


def test_the_terminal_and_the_page_tell_it(recording: Path) -> None:
    pytest.importorskip("matplotlib")
    page = recording.with_suffix(".html")
    said = call("bag", "report", str(recording))
    assert said.exit_code == 0
    assert f"{len(SPIKES)} of 5" in said.stdout
    assert "off the motion around" in said.stdout
    assert all(
        word in page.read_text(encoding="utf-8")
        for word in ("50 % within", "95 % within", "far off")
    )


@pytest.mark.sweep(sample="test_the_terminal_and_the_page_tell_it")
def test_json_tells_it(recording: Path) -> None:
    pytest.importorskip("matplotlib")
    told = json.loads(call("bag", "report", str(recording), "--json").stdout)["efforts"]
    assert told["q_L"]["far"] == len(SPIKES)
    assert np.isfinite(list(told["q_R"].values())).all()


def test_a_bag_without_recorded_efforts_is_told_how_it_would_have_kept_them(
    recording: Path,
) -> None:
    pytest.importorskip("matplotlib")
    results = recording.with_name("results")
    assert (
        call("bag", "process", str(recording), str(results), "--robot", "five_bar").exit_code == 0
    )
    report = call("bag", "report", str(results))
    assert (
        "no recorded efforts to compare with; `bag process --keep` takes those of the recording"
        " over" in report.stdout
    )
    page = results.with_suffix(".html").read_text(encoding="utf-8")
    assert "beside what was recorded" not in page
    assert "there is nothing to compare with" in page
    refused = call("bag", "identify", str(results))
    assert refused.exit_code == 1
    assert "process the recording with --keep" in refused.stderr


@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_an_offset_of_all_samples_puts_none_of_them_far_off(recording: Path, noise: float) -> None:
    track = collect(recording, smooth="spline")
    spikes = np.zeros_like(track.efforts)
    spikes[[10, 20]] = 500.0  # N m
    noisy = noise * np.random.default_rng(0).standard_normal(track.efforts.shape)
    for error in effort_errors(replace(track, recorded=track.efforts + 8.0 + noisy + spikes)):
        assert error.median == pytest.approx(8.0, abs=0.1)
        assert error.far in range(2, 5)  # noise goes beyond its limit in one recording of 20
