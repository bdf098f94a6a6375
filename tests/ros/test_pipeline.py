"""The pipeline: samples in, results or rejections out, without ROS."""

import subprocess
import sys

import numpy as np
import pytest

from hybrid_dynamics_core import Payload, Robot
from hybrid_dynamics_core.errors import HybridDynamicsError, InputError, SingularityError
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_ros.messages.joint_samples import JointSample, Rejection, RejectionCode
from hybrid_dynamics_ros.stream.filter.filter import StampEvent
from hybrid_dynamics_ros.stream.pipeline import Pipeline
from hybrid_dynamics_ros.stream.results import MotionResult
from tests.export.test_round_trip import CART

MS = 10**6  # [ns]
POSITION = np.array([0.8726646259971648, 0.15000000000000002, 0.175, 0.4363323129985824])
RATES = np.array([0.17453292519943295, 0.01, 0.005, 0.08726646259971647])
# Chu (2020), corrected model, t = 5 s, accelerations zero.
EFFORTS = [0.1783183547256898, 846.5280575553463, -4032.4362202954067, 0.0]
TOOL = [0.3226478557853928, 0.38451674127506036, 1.1179125884719605]


@pytest.fixture
def pipeline(robot):
    return Pipeline(robot, bandwidth=10.0, max_gap=0.5)


def sample(
    stamp_ms=0.0,
    position=POSITION,
    velocity=RATES,
    acceleration=None,
    names=("q1", "q12", "q22", "q4"),
):
    return JointSample(round(stamp_ms * MS), names, np.asarray(position), velocity, acceleration)


def wavy(k, *, with_velocity=True):
    """Sample k of a moving robot, every 8 ms with some jitter."""
    t = 0.008 * k + 0.001 * (k % 3)
    position = np.array(
        [0.3 * np.sin(4 * t), 0.15 + 0.02 * np.sin(6 * t), 0.18 - 0.01 * np.sin(5 * t), t * t]
    )
    velocity = np.array([1.2 * np.cos(4 * t), 0.12 * np.cos(6 * t), -0.05 * np.cos(5 * t), 2 * t])
    return sample(1e3 * t, position, velocity if with_velocity else None)


def arrays(result):
    """All numbers of a result, for comparison to the last bit."""
    return [
        result.position,
        result.velocity,
        *result.active,
        result.efforts,
        result.distances,
        result.pose.matrix,
    ]


def same(one, two):
    return all(
        (a is None and b is None) or np.array_equal(a, b)
        for a, b in zip(arrays(one), arrays(two), strict=True)
    )


def test_one_sample_gives_the_full_state_and_the_pose(pipeline, robot):
    result = pipeline.process(sample(stamp_ms=7.0))
    state = robot.close(POSITION, RATES)
    assert isinstance(result, MotionResult)
    assert result.stamp_ns == 7 * MS
    assert np.array_equal(result.position, state.s)
    assert np.array_equal(result.velocity, state.ds)
    np.testing.assert_allclose(result.pose.position, TOOL, rtol=1e-9)
    assert result.residual < 1e-12
    assert result.efforts is None
    assert result.event is StampEvent.FIRST


def test_efforts_come_with_the_filter(pipeline):
    results = [pipeline.process(sample(10.0 * k)) for k in range(5)]
    assert [r.efforts is not None for r in results] == [False, False, False, True, True]
    np.testing.assert_allclose(results[-1].efforts, EFFORTS, rtol=1e-9, atol=1e-9)
    assert pipeline.counts.with_efforts == 2


def test_without_velocities_there_are_none_until_the_filter_has_its_samples(pipeline):
    results = [
        pipeline.process(sample(10.0 * k, POSITION + RATES * 0.01 * (k - 5), velocity=None))
        for k in range(6)
    ]
    assert [r.velocity is not None for r in results] == [False] * 3 + [True] * 3
    assert [r.efforts is not None for r in results] == [False] * 3 + [True] * 3
    np.testing.assert_allclose(results[-1].active.velocity, RATES, rtol=1e-9)
    np.testing.assert_allclose(results[-1].efforts, EFFORTS, rtol=1e-6, atol=1e-6)


def test_given_accelerations_are_taken_as_they_are_and_leave_the_filter_alone(robot):
    plain, mixed = (Pipeline(robot, bandwidth=10.0, max_gap=0.5) for _ in range(2))
    acceleration = np.array([1.0, -0.2, 0.3, 2.0])
    for k in range(8):
        one, two = plain.process(wavy(k)), mixed.process(wavy(k))
        assert same(one, two)
        between = mixed.process(sample(999.0, acceleration=acceleration))
        assert np.array_equal(
            between.efforts, robot.inverse_dynamics(robot.close(POSITION, RATES), acceleration)
        )
        assert between.event is None


def test_angles_go_on_over_a_turn_and_lengths_are_as_they_came():
    """A pole on a cart: it goes past half a turn as the cart goes four metres at once."""
    stream = Pipeline(Robot(parse_description(CART)), bandwidth=10.0, max_gap=0.5)
    readings = [(0.0, 3.1), (4.0, -3.1), (0.5, 3.1)]
    results = [
        stream.process(JointSample(10 * k * MS, ("x", "th"), np.array(pair)))
        for k, pair in enumerate(readings)
    ]
    assert [result.position[0] for result in results] == [0.0, 4.0, 0.5]
    angles = [result.position[1] for result in results]
    np.testing.assert_allclose(angles, [3.1, 2.0 * np.pi - 3.1, 3.1])


@pytest.mark.parametrize("with_velocity", [True, False])
def test_equal_samples_give_equal_bits(robot, with_velocity):
    one, two = (Pipeline(robot, bandwidth=10.0, max_gap=0.5) for _ in range(2))
    for k in range(50):
        assert same(
            one.process(wavy(k, with_velocity=with_velocity)),
            two.process(wavy(k, with_velocity=with_velocity)),
        )


def test_the_order_of_joints_and_extra_ones_do_not_change_a_bit(robot):
    one, two = (Pipeline(robot, bandwidth=10.0, max_gap=0.5) for _ in range(2))
    for k in range(10):
        plain = wavy(k)
        names = ("q4", "hose", "q22", "q12", "q1")
        places = [3, 0, 2, 1, 0]
        position, velocity = plain.position[places], plain.velocity[places]
        position[1] = velocity[1] = np.nan
        mixed = JointSample(plain.stamp_ns, names, position, velocity)
        assert same(one.process(plain), two.process(mixed))


BAD = {
    "empty": (sample(names=(), position=[], velocity=None), RejectionCode.EMPTY),
    "missing": (sample(names=("q1", "q12", "q22", "x")), RejectionCode.MISSING_JOINT),
    "duplicate": (
        sample(names=("q1", "q12", "q22", "q4", "q4"), position=[0.0] * 5),
        RejectionCode.DUPLICATE_JOINT,
    ),
    "length": (sample(position=POSITION[:3]), RejectionCode.WRONG_LENGTH),
    "nan": (sample(position=[np.nan, 0.1, 0.1, 0.0]), RejectionCode.NOT_FINITE),
    "infinite": (sample(velocity=np.array([0.0, np.inf, 0.0, 0.0])), RejectionCode.NOT_FINITE),
    "stamp": (sample(stamp_ms=-1.0), RejectionCode.BAD_STAMP),
    "long cylinder": (sample(position=[0.0, 0.9, 0.15, 0.0]), RejectionCode.UNREACHABLE),
    "short cylinder": (sample(position=[0.0, 0.1, -0.35, 0.0]), RejectionCode.UNREACHABLE),
    "no velocity": (sample(velocity=None, acceleration=np.zeros(4)), RejectionCode.WRONG_LENGTH),
    "overflow": (
        sample(velocity=np.full(4, 1e300), acceleration=np.zeros(4)),
        RejectionCode.OVERFLOW,
    ),
    "huge rate": (sample(velocity=np.array([0.0, 0.0, 0.0, -1.7e308])), RejectionCode.OVERFLOW),
    "huge place": (sample(position=[1e12, 0.1, 0.15, 0.0]), RejectionCode.OVERFLOW),
}


@pytest.mark.parametrize("kind", BAD)
def test_bad_samples_are_rejected_counted_and_do_not_touch_the_filter(robot, kind):
    bad, code = BAD[kind]
    plain, disturbed = (Pipeline(robot, bandwidth=10.0, max_gap=0.5) for _ in range(2))
    for k in range(8):
        one, two = plain.process(wavy(k)), disturbed.process(wavy(k))
        assert same(one, two)
        rejection = disturbed.process(bad)
        assert isinstance(rejection, Rejection)
        assert rejection.code is code
        assert rejection.text
    assert disturbed.counts.rejected == {code: 8}
    assert disturbed.counts.received == 16
    assert disturbed.counts.accepted == 8
    assert f"8 rejected: {code.value}" in disturbed.counts.summary()


@pytest.mark.parametrize("rate", [9e11, -9e11])
def test_an_absurd_rate_gives_finite_numbers_and_fades_in_the_filter(pipeline, rate):
    """exp(-2 pi 10 Hz 1.5 s) times 1e12 is below all rounding."""
    pipeline.process(sample(0.0, velocity=np.array([0.0, 0.0, 0.0, rate])))
    results = [pipeline.process(sample(10.0 * k)) for k in range(1, 150)]
    efforts = [result.efforts for result in results if result.efforts is not None]
    assert np.isfinite(efforts).all()
    assert np.abs(efforts).max() > 1e9
    np.testing.assert_allclose(efforts[-1], EFFORTS, rtol=1e-9, atol=1e-9)


def test_an_unreachable_sample_names_the_joint_and_its_value(pipeline):
    rejection = pipeline.process(BAD["long cylinder"][0])
    assert "q12" in rejection.text
    assert "0.9" in rejection.text


class Failing:
    """A robot whose inverse dynamics fails in a chosen way; all else is that of a real one."""

    def __init__(self, robot, error):
        self._robot, self._error = robot, error

    def __getattr__(self, name):
        return getattr(self._robot, name)

    @property
    def kernels(self):
        return self

    def under(self, _loads):
        return self

    def closed_inverse_dynamics(self, _u, _du, _ddu):
        raise self._error


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (SingularityError("loop", loop="theta_1", distance=0.0), RejectionCode.SINGULAR),
        (HybridDynamicsError("odd"), RejectionCode.INTERNAL),
    ],
)
def test_failures_of_the_model_are_rejections(robot, error, code):
    pipeline = Pipeline(Failing(robot, error), bandwidth=10.0, max_gap=0.5)
    assert pipeline.process(sample(acceleration=np.zeros(4))).code is code


def test_restarts_are_counted_by_kind(pipeline):
    for stamp in (0.0, 10.0, 5.0, 5.0, 900.0, 910.0):
        assert isinstance(pipeline.process(sample(stamp)), MotionResult)
    pipeline.process(sample(910.0, velocity=2 * RATES))
    assert pipeline.counts.events == {
        StampEvent.FIRST: 1,
        StampEvent.NEXT: 2,
        StampEvent.BACKWARD: 1,
        StampEvent.REPEATED: 1,
        StampEvent.GAP: 1,
        StampEvent.CONFLICT: 1,
    }
    assert "1 backward stamp" in pipeline.counts.summary()
    assert pipeline.evaluator.gap == pytest.approx(0.895)


def test_a_reset_forgets_the_samples(pipeline):
    for k in range(5):
        pipeline.process(sample(10.0 * k))
    pipeline.evaluator.reset()
    result = pipeline.process(sample(50.0))
    assert result.efforts is None
    assert result.event is StampEvent.FIRST


def test_the_pipeline_needs_no_ros():
    """Recordings are processed on machines without ROS."""
    code = "import sys, hybrid_dynamics_ros.stream.pipeline; sys.exit('rclpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_loads_that_are_none_leave_all_as_it_was(pipeline, robot):
    before = pipeline.evaluator.loads
    wanted = pipeline.process(sample(acceleration=np.zeros(4))).efforts
    with pytest.raises(InputError, match="nonsense"):
        pipeline.evaluator.loads = robot.loads.with_payload(Payload(50.0), "nonsense")
    result = pipeline.process(sample(acceleration=np.zeros(4)))
    assert result.loads is before
    assert np.array_equal(result.efforts, wanted)


def test_results_are_read_only(pipeline):
    for k in range(50):
        result = pipeline.process(wavy(k, with_velocity=False))
    assert result.efforts is not None
    for array in (result.position, result.velocity, result.efforts, *result.active):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
