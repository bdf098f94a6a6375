"""What messages lack: velocities that are NaN or come in turn, joints of another driver."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_ros.bags.analysis.collect import collect
from hybrid_dynamics_ros.messages.joint_samples import JointSample, Rejection, RejectionCode
from hybrid_dynamics_ros.stream.filter.rate_estimator import MotionEstimator
from hybrid_dynamics_ros.stream.joint_groups import GroupedEstimator
from hybrid_dynamics_ros.stream.pipeline import Pipeline
from hybrid_dynamics_ros.stream.results import MotionResult
from tests.bags.messages import START, bag, joint_state, motion_of
from tests.bags.test_stream import assert_same, streamed
from tests.sampling import examples

MS = 10**6


def messages(robot, u, velocities, effort=()):
    """Messages every 10 ms."""
    pairs = []
    for k, position in enumerate(u):
        stamp = START + 10 * MS * k
        pairs.append((stamp, joint_state(stamp, robot.active, position, velocities[k], effort)))
    return pairs


def bits(robot, pairs):
    """All numbers that a stream gives."""
    results, _ = streamed(Pipeline(robot, 10.0, 0.5), pairs)
    return [
        (row, result.position, result.velocity, result.efforts, result.active.acceleration)
        for row, result in results
    ]


def assert_equal_bits(found, expected):
    assert len(found) == len(expected)
    for one, other in zip(found, expected, strict=True):
        for a, b in zip(one, other, strict=True):
            assert a is b is None or np.array_equal(a, b)


def test_velocities_that_are_nan_are_absent(forging):
    _, u, _, _ = motion_of(forging, 40)
    nan = messages(forging, u, [[np.nan] * 4] * 40, [np.nan] * 4)
    absent = messages(forging, u, [()] * 40)
    found = bits(forging, nan)
    assert_equal_bits(found, bits(forging, absent))
    assert sum(efforts is not None for *_, efforts, _ in found) == 37
    assert_same(forging, nan, (11,))


COUNT = 60
TIME = 0.01 * np.arange(COUNT)
FREQUENCIES = np.array([2.0, 3.0, 5.0])
STAMPS = START + 10 * MS * np.arange(COUNT)
IN_TURN = np.arange(COUNT) % 2 == 1


def accelerations(rows, position, velocity, *, is_measured):
    """What one estimator gives for some rows (COUNT, n); NaN for the others."""
    found = np.full_like(position, np.nan)
    every = np.full(len(STAMPS[rows]), is_measured)
    estimator = MotionEstimator(10.0, 0.5)
    rates = estimator.run(None, STAMPS[rows], position[rows], velocity[rows], every)
    found[rows] = rates.acceleration
    return found


def stepped(velocity, position):
    """What the groups give for each sample; NaN where a velocity is absent."""
    grouped, state, estimates = GroupedEstimator(MotionEstimator(10.0, 0.5)), None, []
    for k in range(COUNT):
        rates = None if np.isnan(velocity[k]).all() else velocity[k]
        state, estimate = grouped.step(state, int(STAMPS[k]), position[k], rates)
        estimates.append(estimate)
    return estimates


@examples(40)
@given(kinds=st.lists(st.sampled_from("vpa"), min_size=3, max_size=3), cut=st.integers(0, COUNT))
def test_each_joint_has_the_rates_of_its_own_samples(kinds, cut):
    """Kinds of joints: always with velocities, never, and in turn."""
    position = np.sin(np.outer(TIME, FREQUENCIES))
    velocity = np.cos(np.outer(TIME, FREQUENCIES)) * FREQUENCIES
    is_kind = {kind: np.array([other == kind for other in kinds]) for kind in "vpa"}
    given = np.where(is_kind["p"] | (is_kind["a"] & IN_TURN[:, None]), np.nan, velocity)
    every = slice(None)
    of_all = accelerations(every, position, velocity, is_measured=True)
    of_none = accelerations(every, position, velocity, is_measured=False)
    of_some = accelerations(~IN_TURN, position, velocity, is_measured=True)
    expected = np.where(is_kind["p"], of_none, np.where(is_kind["a"], of_some, of_all))
    estimates = stepped(given, position)
    found = np.array([np.full(3, np.nan) if e[1] is None else e[1] for e in estimates])
    # From the tenth sample on all filters have theirs. Where a joint has velocities in turn, its
    # filter of positions began with the first sample without one.
    is_told = np.isfinite(expected[10:])
    np.testing.assert_array_equal(found[10:][is_told], expected[10:][is_told])
    np.testing.assert_allclose(found[25:][~is_told[15:]], of_none[25:][~is_told[15:]], rtol=0.01)
    assert np.isfinite(found[10:]).all()
    assert_rows_are_steps(estimates, cut, position, given)


def assert_rows_are_steps(estimates, cut, position, given):
    """Many samples at once, in two parts, give the bits of one after the other."""
    grouped = GroupedEstimator(MotionEstimator(10.0, 0.5))
    first = grouped.run(None, STAMPS[:cut], position[:cut], given[:cut])
    second = grouped.run(first.state, STAMPS[cut:], position[cut:], given[cut:])
    for k, estimate in enumerate(estimates):
        rates, row = (first, k) if k < cut else (second, k - cut)
        velocity, acceleration = rates.part(slice(row, row + 1)).at(slice(0, 1))
        for rows, single in ((velocity, estimate.velocity), (acceleration, estimate.acceleration)):
            assert (rows is None) == (single is None)
            assert single is None or np.array_equal(rows[0], single)


@pytest.mark.parametrize("smooth", ["causal", "spline", "savgol"])
def test_velocities_in_turn_are_served(forging, tmp_path, smooth):
    _, u, du, ddu = motion_of(forging, 120)
    in_turn = messages(forging, u, [du[k] if k % 2 else () for k in range(120)])
    track = collect(bag(tmp_path / "in", in_turn), "forging_chu2020", smooth=smooth)
    assert np.isfinite(track.efforts).all(axis=1).sum() >= 116
    if smooth != "causal":
        np.testing.assert_allclose(track.acceleration[10:-10], ddu[10:-10], atol=2e-3)
    else:
        assert_same(forging, in_turn, (40,))


def halves(draw, names):
    """The joints of two drivers."""
    is_first = draw(st.lists(st.booleans(), min_size=len(names), max_size=len(names)))
    first = [k for k, has in enumerate(is_first) if has] or [0]
    return first, [k for k in range(len(names)) if k not in first] or [len(names) - 1]


@examples(60)
@given(data=st.data())
def test_a_recording_split_over_two_drivers_is_the_joined_one(forging, data):
    count = 30
    _, u, du, _ = motion_of(forging, count)
    has_velocity = data.draw(st.booleans())
    parts = halves(data.draw, forging.active)
    split, joined = [], []
    for k in range(count):
        stamp = START + 10 * MS * k
        rates = du[k] if has_velocity else ()
        joined.append((stamp, joint_state(stamp, forging.active, u[k], rates)))
        order = data.draw(st.permutations([0, 1]))
        for part in (parts[which] for which in order):
            names = [forging.active[i] for i in part]
            own = du[k, part] if has_velocity else ()
            split.append((stamp, joint_state(stamp, names, u[k, part], own)))
    found = [values[1:] for values in bits(forging, split)]
    assert_equal_bits(found, [values[1:] for values in bits(forging, joined)])
    assert_same(forging, split, data.draw(st.lists(st.integers(0, 60), max_size=2).map(sorted)))


def partial(stamp_ms, **positions):
    """A sample of some joints."""
    values = np.array(list(positions.values()))
    return JointSample(START + stamp_ms * MS, tuple(positions), values)


def test_the_newest_of_each_joint_counts(forging):
    pipeline = Pipeline(forging, 10.0, 0.5)
    refused = pipeline.process(partial(0, q1=0.1, q12=0.1))
    assert isinstance(refused, Rejection)
    assert refused.code is RejectionCode.MISSING_JOINT
    assert pipeline.process(partial(2, q1=0.2, q12=0.1)).code is RejectionCode.MISSING_JOINT
    result = pipeline.process(partial(1, q22=0.15, q4=0.3))
    assert isinstance(result, MotionResult)
    assert result.stamp_ns == START + 2 * MS
    np.testing.assert_array_equal(result.active.position, [0.2, 0.1, 0.15, 0.3])
    assert pipeline.process(partial(10, q1=0.2, q12=0.1)) is None
    late = pipeline.process(partial(300, q22=0.15, q4=0.3))
    assert "within 0.2 s no message has q1, q12" in late.text
    assert "1 with some joints, which waited for the others" in pipeline.counts.summary()
    pipeline.readings.joiner.max_age = 0.0
    assert isinstance(pipeline.process(partial(301, q1=0.2, q12=0.1)), Rejection)


def test_a_position_that_is_nan_is_another_drivers(forging):
    pipeline = Pipeline(forging, 10.0, 0.5)
    one = pipeline.process(partial(0, q1=0.1, q12=0.1, q22=np.nan, q4=np.nan))
    assert one.code is RejectionCode.NOT_FINITE
    assert "position of joint q22 is nan" in one.text
    other = pipeline.process(partial(0, q1=np.nan, q12=np.nan, q22=0.15, q4=0.3))
    np.testing.assert_array_equal(other.active.position, [0.1, 0.1, 0.15, 0.3])


def test_efforts_of_two_drivers_are_joined_in_recordings(forging, tmp_path):
    _, u, du, _ = motion_of(forging, 40)
    pairs = []
    for k in range(40):
        stamp = START + 10 * MS * k
        for part in ([0, 3], [1, 2]):
            names = [forging.active[i] for i in part]
            efforts = [10.0 * k + i for i in part]
            data = joint_state(stamp, names, u[k, part], du[k, part], efforts)
            pairs.append((stamp, data))
    track = collect(bag(tmp_path / "in", pairs), "forging_chu2020")
    assert len(track.recorded) == 40
    np.testing.assert_array_equal(track.recorded[7], [70.0, 71.0, 72.0, 73.0])
