"""Whole recordings and single messages: the same numbers, the same rejections, to the last bit."""

from __future__ import annotations

import itertools
import pickle
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import load, shipped_robots
from hybrid_dynamics_ros.bags.batch_pipeline import BatchPipeline
from hybrid_dynamics_ros.bags.decode import Decoder, sample_of_motion, sample_of_state
from hybrid_dynamics_ros.messages.interfaces import JOINT_MOTION, JOINT_STATE, typestore
from hybrid_dynamics_ros.stream.filter import filter as filters
from hybrid_dynamics_ros.stream.filter.kalman import KalmanFilter
from hybrid_dynamics_ros.stream.filter.polynomial import PolynomialFilter
from hybrid_dynamics_ros.stream.filter.recursion import run_in_python
from hybrid_dynamics_ros.stream.filter.routes import Kalman
from hybrid_dynamics_ros.stream.pipeline import Pipeline
from hybrid_dynamics_ros.stream.results import MotionResult
from tests.bags.messages import START, joint_state, messages_of, recorded
from tests.sampling import examples, swept
from tests.turning import turning_linkages

ACTIVE = ("q1", "q12", "q22", "q4")
GOOD = {"q1": 0.1, "q12": 0.1, "q22": 0.15, "q4": 0.2, "hose": np.nan}
MS = 10**6


def pipeline_of(robot, measured, calibration, kalman=None):
    """A pipeline under the node's defaults, but for the filter."""
    pipeline = Pipeline(robot, 10.0, 0.5, measured, kalman)
    pipeline.evaluator.calibrate(calibration)
    return pipeline


def streamed(pipeline, pairs, kind=JOINT_STATE):
    """Row and result of each accepted message, one after the other; the pipeline."""
    read = {JOINT_STATE: sample_of_state, JOINT_MOTION: sample_of_motion}[kind]
    results = [pipeline.process(read(typestore().deserialize_cdr(data, kind))) for _, data in pairs]
    return [(row, r) for row, r in enumerate(results) if isinstance(r, MotionResult)], pipeline


def in_bulk(pipeline, pairs, cuts=(), kind=JOINT_STATE):
    """Motions of the pieces between cuts, with the row that each begins at; the pipeline."""
    bulk, decoder = BatchPipeline(pipeline), Decoder(pipeline.evaluator.measured, kind)
    edges = [0, *cuts, len(pairs)]
    motions = []
    for start, end in itertools.pairwise(edges):
        if (
            end > start
            and (motion := bulk.process(decoder.decode(messages_of(pairs[start:end])))) is not None
        ):
            motions.append((start, motion))
    return motions, pipeline


def has_velocity(motion):
    """Of each row, whether its velocity is known."""
    return np.concatenate(
        [np.full(len(run.position), run.velocity is not None) for run in motion.runs]
    )


def assert_same(
    robot, pairs, cuts=(), measured=None, kind=JOINT_STATE, calibration=None, kalman=None
):
    """Both ways agree in every bit and every count."""
    one, two = (pipeline_of(robot, measured, calibration, kalman) for _ in range(2))
    expected, stream = streamed(one, pairs, kind)
    motions, bulk = in_bulk(two, pairs, cuts, kind)
    assert stream.counts == bulk.counts
    assert (bulk.counts.received, bulk.counts.accepted) == (len(pairs), len(expected))
    rows = [start + int(row) for start, motion in motions for row in motion.rows]
    assert rows == [row for row, _ in expected]
    found = [(motion, k) for _, motion in motions for k in range(len(motion))]
    for (_, result), (motion, k) in zip(expected, found, strict=True):
        assert motion.stamp_ns[k] == result.stamp_ns
        assert has_velocity(motion)[k] == (result.velocity is not None)
        assert np.isfinite(motion.efforts[k]).all() == (result.efforts is not None)
        for name in ("s", "ds", "R", "distances", "residual"):
            assert np.array_equal(getattr(motion.state, name)[k], getattr(result.state, name)), name
        told = (result.position, result.velocity, result.distances, result.residual)
        closed = (
            result.state.s,
            None if result.velocity is None else result.state.ds,
            result.state.distances,
            motion.state.residual[k],
        )
        assert all(np.array_equal(a, b) for a, b in zip(told, closed, strict=True))
        assert result.nearest == (result.state.singularity, result.state.singular_loop)
        assert result.branch == result.state.branch
        if result.efforts is not None:
            assert np.array_equal(motion.efforts[k], result.efforts)
            assert np.array_equal(motion.acceleration[k], result.active.acceleration)
    return expected


@pytest.mark.parametrize("velocity", [True, False])
@pytest.mark.parametrize("name", swept(shipped_robots()))
def test_every_shipped_robot_gives_the_bits_of_the_stream(name, velocity):
    robot = load(name)
    expected = assert_same(robot, recorded(robot, 50, velocity=velocity), cuts=(7, 8, 30))
    assert sum(result.efforts is not None for _, result in expected) > 30


@pytest.mark.parametrize("velocity", [True, False])
@examples(12)
@given(linkage=turning_linkages(), way=st.sampled_from([1.0, -1.0]))
def test_passive_joints_go_round_without_a_jump(velocity, linkage, way):
    robot = linkage.robot()
    u = linkage.start + way * np.linspace(0.0, 15.0, 150)[:, None]
    rates = np.full_like(u, way * 10.0)
    pairs = []
    for k, (position, rate) in enumerate(zip(u, rates, strict=True)):
        stamp = START + 10 * MS * k
        given_rate = rate if velocity else ()
        pairs.append((stamp, joint_state(stamp, robot.active, position, given_rate)))
    expected = assert_same(robot, pairs, cuts=(7, 60, 61))
    path = robot.close_path(u)
    for row, result in expected:
        np.testing.assert_allclose(result.position, path.s[row], atol=1e-9)  # rounding
        if result.efforts is not None:
            state = robot.close(u[row], result.active.velocity, near=path.rows(row))
            efforts = robot.inverse_dynamics(state, result.active.acceleration)
            np.testing.assert_allclose(result.efforts, efforts, atol=1e-7)


numbers = st.one_of(st.floats(0.08, 0.2), st.sampled_from([0.1, 0.9, 1e300, np.nan, np.inf, -0.0]))
steps = st.sampled_from(
    [10 * MS, 10 * MS, 9_999_999, 1, 0, -5 * MS, 600 * MS, 2 * MS]
)  # from the message before [ns]
HALVES = [("q1", "q12"), ("q4", "q22"), ("q22", "q4", "hose")]  # of several drivers
NAMES = [
    *(ACTIVE, ACTIVE, ACTIVE[::-1], ("hose", *ACTIVE), ACTIVE[:3], (), (*ACTIVE, "q1")),
    *HALVES,
]
KINDS = ["good", "good", "good", "odd", "short", "none", "absent", "same"]


@st.composite
def sequences(draw):
    """JointState messages: reordered joints, gaps, duplicates, resets, odd values and lengths."""
    stamp, pairs = START, []
    for k in range(draw(st.integers(1, 40))):
        names = draw(st.sampled_from(NAMES))
        kind = draw(st.sampled_from(KINDS))
        if kind == "same" and pairs:
            pairs.append(pairs[-1])
            continue
        stamp = (
            draw(st.sampled_from([5, START]))
            if draw(st.integers(0, 40)) == 0
            else max(stamp + draw(steps), 0)
        )
        position = [GOOD[name] + 0.001 * (k % 7) for name in names]
        velocity = [] if kind == "none" else [0.01 * draw(st.integers(-3, 3)) for _ in names]
        if kind == "odd" and names:
            (position if draw(st.booleans()) or not velocity else velocity)[
                draw(st.integers(0, len(names) - 1))
            ] = draw(numbers)
        if kind == "absent":
            velocity = [draw(st.sampled_from([0.01, np.nan])) for _ in names]
        if kind == "short":
            position = position[:-1]
        pairs.append((START + k, joint_state(stamp, names, position, velocity)))
    return pairs, sorted(draw(st.lists(st.integers(0, len(pairs)), max_size=3)))


@examples(150)
@given(case=sequences())
def test_any_sequence_cut_anywhere_gives_the_bits_of_the_stream(forging, case):
    assert_same(forging, *case)


def test_measured_joints_that_are_not_the_active_ones_give_the_bits_of_the_stream(forging):
    state = forging.close(forging.reference)
    measured = ("q1", "q2", "q3", "q4")
    at = [float(state.s[forging.coordinates.index(name)]) for name in measured]
    pairs = [
        (k, joint_state(START + 10 * MS * k, measured, np.add(at, 1e-4 * k), [0.01] * 4))
        for k in range(20)
    ]
    assert assert_same(forging, pairs, (5,), measured)


def test_jitter_and_long_streams_give_the_bits_of_the_stream(forging):
    rng = np.random.default_rng(4)
    stamps = START + np.cumsum(rng.integers(1, 20 * MS, 400))
    rates = [() if k < 200 else rng.normal(0, 0.01, 4) for k in range(400)]
    at = np.add([0.1, 0.1, 0.15, 0.2], rng.normal(0, 1e-3, (400, 4)))
    pairs = [(k, joint_state(int(t), ACTIVE, at[k], rates[k])) for k, t in enumerate(stamps)]
    assert_same(forging, pairs, (100, 199, 300))


@pytest.mark.parametrize("count", [3, 40])  # one by one, and in bulk
def test_bytes_that_writers_leave_behind_a_message_are_no_damage(forging, count):
    """rclpy's serialize_message leaves eight, with anything in them."""
    pairs = recorded(forging, count)
    rng = np.random.default_rng(1)
    longer = [(log, data + rng.bytes(8)) for log, data in pairs]
    ((_, wanted),), ((_, found),) = (
        in_bulk(pipeline_of(forging, None, None), entries)[0] for entries in (pairs, longer)
    )
    assert len(found) == count
    for name in ("stamp_ns", "efforts"):
        assert np.array_equal(getattr(wanted, name), getattr(found, name), equal_nan=True)
    assert np.array_equal(has_velocity(wanted), has_velocity(found))


@pytest.mark.parametrize("having", ["all", "some", "none"])
def test_the_kalman_filter_gives_the_bits_of_the_stream(forging, having):
    rng = np.random.default_rng(5)
    stamps = START + np.cumsum(rng.integers(1, 20 * MS, 200))
    stamps[150:] += 600 * MS
    at = np.add([0.1, 0.1, 0.15, 0.2], np.cumsum(rng.normal(0, 1e-4, (200, 4)), axis=0))
    pairs = []
    for k, stamp in enumerate(stamps.tolist()):
        rates = rng.normal(0, 0.01, 4) if having != "none" and k % 5 else ()
        if having == "some" and k % 5:
            rates[rng.integers(4)] = np.nan
        pairs.append((k, joint_state(stamp, ACTIVE, at[k], rates)))
    expected = assert_same(forging, pairs, (40, 100), kalman=Kalman(15.0, 400.0))
    assert sum(result.efforts is not None for _, result in expected) > 180


FILTERS = [
    *(
        pytest.param(partial(PolynomialFilter, degree, bandwidth), 1, id=f"{degree} {bandwidth}")
        for degree in (1, 2)
        for bandwidth in (1e-12, 1e-9, 0.01, 10.0, 1000.0)
    ),
    *(
        pytest.param(
            partial(KalmanFilter, bandwidth, 400.0), channels, id=f"{channels} {bandwidth}"
        )
        for channels in (1, 2)
        for bandwidth in (0.01, 15.0, 1000.0)
    ),
]


@pytest.mark.parametrize(("make", "channels"), FILTERS)
def test_filters_give_the_same_bits_step_by_step_and_in_rows_in_python_and_compiled(
    make, channels, monkeypatch
):
    rng = np.random.default_rng(6)
    short, long = rng.integers(1, 50, 150), rng.integers(1, 20 * MS, 150)
    stamps = START + np.cumsum(np.where(np.arange(150) % 2, short, long))
    samples = np.cumsum(rng.normal(0, 1e-3, (150, channels, 3)), axis=0)
    received = pickle.loads(pickle.dumps(samples))  # noqa: S301 - as another process sends them
    results = []
    for advance in (filters.advance_of, lambda steps: partial(run_in_python, steps)):
        monkeypatch.setattr(filters, "advance_of", advance)
        filt = make(max_gap=0.5)
        state, singly = None, []
        for stamp, sample in zip(stamps.tolist(), samples, strict=True):
            state, _ = filt.step(state, stamp, sample)
            singly.append(state.derivatives)
        rows = filt.run(None, stamps, received)
        assert np.array_equal(rows.derivatives, singly)
        assert np.array_equal(rows.state.memory, state.memory)
        results.append((rows.derivatives, rows.state.memory))
    for compiled, python in zip(*results, strict=True):
        assert np.array_equal(compiled, python)
