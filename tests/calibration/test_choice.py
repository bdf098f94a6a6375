"""Poses chosen from candidates: better than most random ones, and as good as the best of few."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from hybrid_dynamics_core import InputError
from hybrid_dynamics_core.calibration import calibrate, choose_poses
from hybrid_dynamics_core.calibration.choice import exchanged, greedy
from tests.cli.calling import data_of

from .crank import changed, columns, poses, write
from .test_command import table

FREE = "reach, loops.lift.pin.crank[0], joints.turn.offset, joints.stroke.offset"
NOISE = 5e-5  # [m]


def candidates(count: int):
    u = poses(count, seed=4)
    return {"turn": u[:, 0], "stroke": u[:, 1]}


def test_the_expected_deviations_are_those_of_the_measured_poses(tmp_path):
    robot = write(tmp_path)
    rows = candidates(60)
    choice = choose_poses(robot, rows, FREE, 8, sigma=NOISE)
    assert len(set(choice.rows)) == 8
    u = np.stack([rows["turn"], rows["stroke"]], axis=1)
    data = columns(changed(tmp_path), u[list(choice.rows)])
    result = calibrate(robot, data, FREE, sigma=NOISE)
    for name, one in result.parameters.items():
        assert one.deviation == pytest.approx(choice.deviations[name], rel=1e-3)
    chosen = np.linalg.slogdet(result.covariance)[1]
    for seed in range(2):
        some = np.random.default_rng(seed).choice(60, 8, replace=False)
        data = columns(changed(tmp_path), u[some])
        other = calibrate(robot, data, FREE, sigma=NOISE)
        assert np.linalg.slogdet(other.covariance)[1] > chosen


def test_the_choice_is_nearly_the_best_of_all():
    rng = np.random.default_rng(2)
    for _ in range(20):
        parts = rng.standard_normal((9, 2, 3))
        rows = np.swapaxes(parts, 1, 2) @ parts
        start = 1e-3 * np.eye(3)
        chosen = exchanged(rows, start, greedy(rows, start, 4))

        def size(some, rows=rows, start=start):
            return np.linalg.slogdet(start + rows[list(some)].sum(axis=0))[1]

        best = max(size(some) for some in combinations(range(9), 4))
        # exchanges of one pose at a time may end beside the best
        assert size(chosen) > best - 0.2


def test_what_was_measured_before_counts(tmp_path):
    robot = write(tmp_path)
    data = columns(changed(tmp_path), poses(6), noise=NOISE)
    words = ("--robot", robot, "--free", FREE, "--sigma", "0.05*mm")
    places = table(tmp_path / "candidates.csv", candidates(40))
    path = table(tmp_path / "data.csv", data)
    answer = data_of("calibrate", path, *words, "--candidates", places, "--choose", "5")
    further = answer["further"]
    assert len(further["lines"]) == 5
    assert all(2 <= line <= 41 for line in further["lines"])
    for name, deviation in further["deviations"].items():
        assert deviation < answer["parameters"][name]["deviation"]


def test_more_poses_than_candidates_are_refused(tmp_path):
    with pytest.raises(InputError, match="11 poses of 10 candidates"):
        choose_poses(write(tmp_path), candidates(10), FREE, 11)
