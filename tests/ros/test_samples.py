"""Samples by name: order, extra joints, and every way to be wrong."""

import numpy as np
import pytest

from hybrid_dynamics_core.errors import (
    ClosureError,
    HybridDynamicsError,
    InputError,
    SingularityError,
)
from hybrid_dynamics_ros.messages.joint_samples import (
    JointOrder,
    JointSample,
    RejectedError,
    RejectionCode,
    rejection_of,
)
from hybrid_dynamics_ros.stream.rate_limit import RateLimit, Throttle

NAMES = ["a", "b", "c"]


def sample(names=NAMES, position=(1.0, 2.0, 3.0), velocity=None, acceleration=None):
    def array(values):
        return None if values is None else np.array(values, dtype=float)

    return JointSample(0, list(names), array(position), array(velocity), array(acceleration))


def test_joints_come_out_in_the_robots_order_whatever_order_they_come_in():
    motion = JointOrder(NAMES).arrange(
        sample(["c", "x", "a", "b"], [3, np.nan, 1, 2], [30, 0, 10, 20])
    )
    assert np.array_equal(motion.position, [1, 2, 3])
    assert np.array_equal(motion.velocity, [10, 20, 30])
    assert motion.acceleration is None


def test_a_change_of_order_within_a_stream_is_followed():
    order = JointOrder(NAMES)
    for names in (
        ["a", "b", "c"],
        ["b", "a", "c"],
        ["b", "a", "c"],
        ["c", "b", "x", "a"],
        ["a", "b", "c"],
    ):
        motion = order.arrange(sample(names, [ord(name) for name in names]))
        assert np.array_equal(motion.position, [97, 98, 99])


def test_the_motion_does_not_share_memory_with_the_sample():
    given = sample()
    motion = JointOrder(NAMES).arrange(given)
    given.position[:] = 9.0
    assert np.array_equal(motion.position, [1, 2, 3])


@pytest.mark.parametrize(
    ("bad", "code", "text"),
    [
        (sample([], []), RejectionCode.EMPTY, "a, b, c"),
        (sample(["a", "x"], [1, 2]), RejectionCode.MISSING_JOINT, "b, c"),
        (sample(["a", "b", "c", "b"], [1, 2, 3, 4]), RejectionCode.DUPLICATE_JOINT, "b"),
        (sample(position=[1, 2]), RejectionCode.WRONG_LENGTH, "position has 2 values for 3"),
        (sample(position=[]), RejectionCode.WRONG_LENGTH, "position has 0 values for 3"),
        (sample(velocity=[1, 2, 3, 4]), RejectionCode.WRONG_LENGTH, "velocity has 4 values for 3"),
        (sample(acceleration=[]), RejectionCode.WRONG_LENGTH, "acceleration has 0 values for 3"),
        (sample(position=[1, np.nan, 3]), RejectionCode.NOT_FINITE, "position of joint b is nan"),
        (sample(velocity=[1, 2, -np.inf]), RejectionCode.NOT_FINITE, "velocity of joint c is -inf"),
        (
            sample(acceleration=[np.inf, 2, 3]),
            RejectionCode.NOT_FINITE,
            "acceleration of joint a is inf",
        ),
    ],
)
def test_what_is_wrong_is_named(bad, code, text):
    order = JointOrder(NAMES)
    order.arrange(sample())  # nothing remembered from a good sample may hide it
    with pytest.raises(RejectedError) as caught:
        order.arrange(bad)
    assert caught.value.rejection.code is code
    assert text in caught.value.rejection.text
    assert np.array_equal(order.arrange(sample()).position, [1, 2, 3])


def test_extra_joints_may_be_doubled():
    motion = JointOrder(["a"]).arrange(sample(["x", "a", "x"]))
    assert np.array_equal(motion.position, [2])


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (ClosureError("loop L,\n  q is 3", loop="L"), RejectionCode.UNREACHABLE),
        (SingularityError("loop L", loop="L", distance=0.0), RejectionCode.SINGULAR),
        (InputError("too large"), RejectionCode.OVERFLOW),
        (HybridDynamicsError("anything else"), RejectionCode.INTERNAL),
    ],
)
def test_errors_of_the_model_become_rejections_of_one_line(error, code):
    rejection = rejection_of(error)
    assert rejection.code is code
    assert rejection.text == " ".join(str(error).split())


def test_the_throttle_lets_one_line_of_a_kind_through_in_a_period_and_counts_the_others():
    throttle = Throttle(period=5.0)
    assert throttle.admit("a", now=100.0) == 0
    assert throttle.admit("a", now=101.0) is None
    assert throttle.admit("b", now=102.0) == 0
    assert throttle.admit("a", now=104.9) is None
    assert throttle.admit("a", now=105.0) == 2
    assert throttle.admit("a", now=110.0) == 0


def test_a_throttle_without_a_period_lets_everything_through():
    throttle = Throttle(period=0.0)
    assert [throttle.admit("a", now=1.0) for _ in range(3)] == [0, 0, 0]


@pytest.mark.parametrize("rate", [-1.0, 0.0, 100.0, 333.3])
def test_many_messages_are_due_as_one_after_the_other(rate):
    rng = np.random.default_rng(1)
    steps = rng.choice(
        [0, 10**6, 3 * 10**6, 10**7, 10**9, -(10**7)], 2000, p=[0.1, 0.5, 0.2, 0.18, 0.01, 0.01]
    )
    stamps = 10**10 + np.cumsum(steps)
    one, many = RateLimit(), RateLimit()
    expected = [k for k, stamp in enumerate(stamps.tolist()) if one.due(stamp, rate)]
    found = [
        start + many.due_rows(stamps[start : start + 50], rate) for start in range(0, 2000, 50)
    ]
    assert np.concatenate(found).tolist() == expected


@pytest.mark.parametrize("rate", [20.0, 333.3, 999.0, 1000.0, 1e5])
@pytest.mark.parametrize("jitter", [0, 10**5])
def test_many_messages_without_a_gap_are_due_as_one_after_the_other(rate, jitter):
    noise = np.random.default_rng(2).integers(-jitter, jitter + 1, 2000)
    stamps = 10**18 + 10**6 * np.arange(2000) + noise
    one, many = RateLimit(), RateLimit()
    expected = [k for k, stamp in enumerate(stamps.tolist()) if one.due(stamp, rate)]
    found = [
        start + many.due_rows(stamps[start : start + 300], rate) for start in range(0, 2000, 300)
    ]
    assert np.concatenate(found).tolist() == expected


def test_a_joint_under_nearly_its_name_is_pointed_at():
    order = JointOrder(("slew", "motor", "tilt"))
    said = r"motor not named; 'motr' is none of slew, motor, tilt \(did you mean 'motor'\?\)$"
    with pytest.raises(RejectedError, match=said):
        order.arrange(sample(["slew", "motr", "tilt"]))
    with pytest.raises(RejectedError, match=r"motor not named; named are slew, camera, tilt$"):
        order.arrange(sample(["slew", "camera", "tilt"]))
