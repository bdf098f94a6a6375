"""Ramps in place of jumps: what they keep of the fastest motion."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core.retiming.constraints import Constraints
from hybrid_dynamics_core.retiming.eased import EasedMotion, eased
from tests.limits.machines import crane

RAMP = 1e-3  # [s]
PATH = [[0.1, 0.1], [0.3, 0.4], [0.5, 0.2]]


@pytest.fixture(scope="module")
def motions():
    robot = crane()
    fastest = robot.retime(PATH, stations=60)
    constraints = Constraints(robot, fastest.curve, None, None, 1.0)
    return robot, fastest, eased(fastest, constraints, RAMP)


def test_values_of_a_profile_are_derivatives_of_each_other(motions) -> None:
    _, _, gentle = motions
    steps = np.linspace(0.0, gentle.duration, 20_001)
    s, ds, dds = gentle.profile(steps)
    width = steps[1]
    jerk = np.abs(np.diff(gentle.dds) / np.diff(gentle.times)).max()
    # errors of the rule of trapezoids: of kinks in s'', and of parabolas of s'
    rises = 0.5 * width * (dds[1:] + dds[:-1])
    assert np.diff(ds) == pytest.approx(rises, abs=jerk * width**2 / 4.0)
    ways = 0.5 * width * (ds[1:] + ds[:-1])
    assert np.diff(s) == pytest.approx(ways, abs=jerk * width**3 / 4.0)


def test_it_goes_along_the_whole_path_from_rest_to_rest_without_jumps(motions) -> None:
    _, fastest, gentle = motions
    point = gentle([0.0, gentle.duration])
    assert point.u == pytest.approx(fastest([0.0, fastest.duration]).u, abs=1e-12)
    assert not point.du.any()
    jumps = np.diff(gentle.dds) / np.diff(gentle.times)
    largest = np.abs(gentle.dds).max()
    assert np.abs(jumps).max() <= 2.0 * largest / RAMP


def test_it_keeps_all_limits_on_a_grid_finer_than_its_own(motions) -> None:
    robot, _, gentle = motions
    count = 37 * (len(gentle.times) - 1) + 1
    numbers = np.linspace(0, len(gentle.times) - 1, count)
    point = gentle(np.interp(numbers, np.arange(len(gentle.times)), gentle.times))
    assert robot.limit_margins(robot.close(point.u, point.du), point.ddu).beyond == ()


def test_it_takes_hardly_longer(motions) -> None:
    _, fastest, gentle = motions
    # a thousandth of the limits about jumps of pressures costs as much of the time, several times
    assert fastest.duration <= gentle.duration < 1.02 * fastest.duration


def test_a_slower_one_passes_the_same_path_later(motions) -> None:
    _, _, gentle = motions
    slow = gentle.slower(0.25)
    assert isinstance(slow, EasedMotion)
    there, here = slow(0.6 * slow.duration), gentle(0.6 * gentle.duration)
    assert slow.duration == pytest.approx(2.0 * gentle.duration)
    assert there.u == pytest.approx(here.u)
    assert there.du == pytest.approx(0.5 * here.du)
    assert there.ddu == pytest.approx(0.25 * here.ddu)
