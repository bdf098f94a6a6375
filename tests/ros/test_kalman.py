"""The Kalman filter of rates: what textbooks say of it, what it follows, what stamps do to it."""

from fractions import Fraction
from math import factorial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_are

from hybrid_dynamics_ros.stream.filter.filter import StampEvent
from hybrid_dynamics_ros.stream.filter.kalman import KalmanFilter, KalmanSteps
from hybrid_dynamics_ros.stream.filter.rate_estimator import MotionEstimator
from hybrid_dynamics_ros.stream.filter.routes import Kalman
from tests.sampling import examples

MS = 1_000_000  # [ns]
UNDETERMINED = 10**20  # variance of what the first sample does not say, in units of the filter
CHANNELS = pytest.mark.parametrize("channels", [1, 2])


def filter_of(bandwidth=15.0, velocity_noise=400.0, max_gap=0.5):
    return KalmanFilter(bandwidth, velocity_noise, max_gap)


def sampled(channels, position, velocity):
    """Samples (N, channels, n) of positions and velocities (N, n)."""
    return np.stack([position, velocity][:channels], axis=1)


def snap_covariance(step, number=float):
    """Of white snap of unit density over a step, by its integral."""
    rows = []
    for i in range(4):
        denominators = [factorial(3 - i) * factorial(3 - j) * (7 - i - j) for j in range(4)]
        rows.append([step ** (7 - i - j) * number(1) / d for j, d in enumerate(denominators)])
    return rows


def transition(step, number=float):
    return [
        [step ** (j - i) * number(1) / factorial(j - i) if j >= i else number(0) for j in range(4)]
        for i in range(4)
    ]


def textbook(filt, stamps, samples):
    """Derivatives (N, 4) of one joint by the textbook's update of the covariance, in fractions."""
    omega, ratio = Fraction(filt.omega), Fraction(filt.constants[1])
    scale = np.array([omega**k for k in range(4)])
    channels = samples.shape[1]
    state = np.array([Fraction(0)] * 4)
    state[:channels] = [Fraction(float(x)) / scale[k] for k, x in enumerate(samples[0, :, 0])]
    covariance, derivatives = None, [state * scale]
    for before, stamp, sample in zip(stamps[:-1], stamps[1:], samples[1:, :, 0], strict=True):
        step = omega * Fraction(float((stamp - before) * 1e-9))
        noises = [1 / step, ratio / step]
        if covariance is None:
            variances = noises[:channels] + [Fraction(UNDETERMINED)] * (4 - channels)
            covariance = np.diag(np.array(variances, dtype=object))
        moved = np.array(transition(step, Fraction), dtype=object)
        noise = np.array(snap_covariance(step, Fraction), dtype=object)
        state, covariance = moved @ state, moved @ covariance @ moved.T + noise
        for k in range(channels):
            gain = covariance[:, k] / (covariance[k, k] + noises[k])
            state = state + gain * (Fraction(float(sample[k])) / scale[k] - state[k])
            covariance = covariance - np.outer(gain, covariance[k])
        derivatives.append(state * scale)
    return np.array(derivatives, dtype=float)


@CHANNELS
@examples(16)
@given(st.integers(0, 2**32 - 1), st.sampled_from([3.0, 30.0, 300.0, 3000.0]))
def test_estimates_are_those_of_the_textbook_in_exact_arithmetic(channels, seed, rate):
    rng = np.random.default_rng(seed)
    stamps = np.cumsum(np.round(rng.uniform(0.2, 2.0, 7) * 1e9 / rate).astype(np.int64))
    samples = rng.normal(0, 1.0, (7, channels, 1))
    filt = filter_of(max_gap=10.0)
    found = filt.run(None, stamps, samples).derivatives[:, :, 0]
    expected = textbook(filt, stamps.tolist(), samples)
    # From the sample on that determines all. Rounding of samples over cubes of intervals.
    for row in range(4 // channels, 7):
        np.testing.assert_allclose(found[row], expected[row], rtol=1e-8, atol=1e-9)


@CHANNELS
@pytest.mark.parametrize("step", [0.01, 0.1, 1.0, 10.0])
def test_gains_settle_at_those_of_the_riccati_equation(channels, step):
    """SciPy solves it; `step` is in units of 1/omega."""
    steps, ratio = KalmanSteps(channels), 0.7
    memory = filter_of().first_memory(channels)
    for _ in range(round(25 / step) + 50):
        memory, gains = steps.update((1.0, ratio), memory, step)
    moved, measured = np.array(transition(step)), np.eye(4)[:channels]
    noise = np.diag([1.0, ratio][:channels]) / step
    covariance = solve_discrete_are(moved.T, measured.T, np.array(snap_covariance(step)), noise)
    spread = measured @ covariance @ measured.T + noise
    expected = covariance @ measured.T @ np.linalg.inv(spread)
    first, last = np.array(gains[:4]), np.array(gains[-4:])
    if channels == 2:  # both at once are the first, and the second of what the first leaves
        first = first - last * first[1]
        np.testing.assert_allclose(last, expected[:, 1], rtol=1e-6)
    np.testing.assert_allclose(first, expected[:, 0], rtol=1e-6)
    assert memory[-1] <= 1.001  # the variance of the acceleration is what is said of it, or less
    if channels == 1 and step < 0.1:
        assert memory[-1] == pytest.approx(1.0, rel=0.02)  # of dense positions it is just that


@CHANNELS
@examples(24)
@given(
    st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4),
    st.sampled_from([5.0, 50.0, 200.0, 1000.0, 5000.0]),
    st.integers(0, 2**32 - 1),
)
def test_motions_of_degree_3_are_followed_without_error_at_any_stamps(
    channels, coefficients, rate, seed
):
    rng = np.random.default_rng(seed)
    intervals = rng.uniform(0.1, 2.0, 600) * rng.choice([1.0, 1.0, 1.0, 4.0], 600)
    stamps = np.cumsum(np.round(intervals * 1e9 / rate).astype(np.int64))
    span = stamps[-1] * 1e-9
    motion = np.polynomial.Polynomial(coefficients)
    t = stamps * 1e-9 / span
    position, velocity, acceleration = (
        motion.deriv(k)(t)[:, None] / span**k if k else motion(t)[:, None] for k in range(3)
    )
    rows = filter_of(max_gap=10.0).run(None, stamps, sampled(channels, position, velocity))
    assert rows.ready.any()
    first = int(np.argmax(rows.ready))
    assert rows.ready[first:].all()
    error = np.abs(rows.derivatives[first:, 2] - acceleration[first:]) * span**2
    # Rounding of samples, some thousand times 2e-16, over squares of the filter's memory (1/omega,
    # or some intervals).
    memory = max(1.0 / filter_of().omega, 1.0 / rate)
    assert error.max() < 1e-12 * (span / memory) ** 2 + 1e-9


def test_a_short_gap_is_crossed_and_a_long_one_restarts():
    stamps = np.concatenate([np.arange(100), np.arange(140, 240), np.arange(900, 1000)]) * 10 * MS
    t = stamps * 1e-9
    position = (0.2 - 0.1 * t + 0.3 * t**2 - 0.1 * t**3)[:, None, None]
    rows = filter_of(max_gap=0.5).run(None, stamps, position)
    assert rows.events == {StampEvent.FIRST: 1, StampEvent.GAP: 1, StampEvent.NEXT: 298}
    expected = 0.6 - 0.6 * t
    settled = rows.ready
    np.testing.assert_allclose(rows.derivatives[settled, 2, 0], expected[settled], atol=1e-8)
    assert settled[10:200].all()
    assert not settled[200:203].any()
    assert settled[210:].all()


def test_samples_with_and_without_velocities_take_turns_in_one_filter():
    estimator = MotionEstimator(10.0, 0.5, Kalman(15.0, 400.0))
    stamps = np.arange(200) * 7 * MS
    t = stamps[:, None] * 1e-9
    position, velocity = 0.1 * t**3 - 0.2 * t**2, 0.3 * t**2 - 0.4 * t
    measured = np.arange(200) % 3 == 0
    rows = estimator.run(None, stamps, position, velocity, measured)
    assert rows.events == {StampEvent.FIRST: 1, StampEvent.NEXT: 199}
    assert rows.has_acceleration[20:].all()
    np.testing.assert_allclose(rows.acceleration[20:], 0.6 * t[20:] - 0.4, atol=1e-8)
    np.testing.assert_allclose(rows.velocity[20:], velocity[20:], atol=1e-9)
    state = None
    for k, stamp in enumerate(stamps.tolist()):
        given_velocity = velocity[k] if measured[k] else None
        state, estimate = estimator.step(state, stamp, position[k], given_velocity)
        assert (estimate.acceleration is not None) == rows.has_acceleration[k]
        if estimate.acceleration is not None:
            assert np.array_equal(estimate.acceleration, rows.acceleration[k])
            assert np.array_equal(estimate.velocity, rows.velocity[k])


def gain(filt, frequency, dt):
    """Complex gain of the acceleration against the true one, from a settled sine."""
    count = int((3.0 / filt.bandwidth + 4.0 / frequency) / dt)
    stamps = np.arange(count) * round(dt * 1e9)
    t, omega = stamps * 1e-9, 2 * np.pi * frequency
    output = filt.run(None, stamps, np.sin(omega * t)[:, None, None]).derivatives[:, 2, 0]
    late = t > t[-1] - 3.0 / frequency
    parts = np.column_stack([np.sin(omega * t[late]), np.cos(omega * t[late])])
    in_phase, quadrature = np.linalg.lstsq(parts, output[late], rcond=None)[0]
    return -(in_phase + 1j * quadrature) / omega**2


@pytest.mark.parametrize("bandwidth", [5.0, 15.0])
def test_accelerations_pass_as_the_documented_transfer_function_says(bandwidth):
    filt, dt = filter_of(bandwidth), 1e-3 / bandwidth
    c = np.sqrt(4.0 + 2.0 * np.sqrt(2.0))
    for frequency in (0.1, 0.3, 0.5443, 1.0, 2.0):  # of the bandwidth; the third is the largest
        s = 2j * np.pi * frequency * bandwidth / filt.omega
        expected = (1 + c * s) / (1 + c * s + (c * s) ** 2 / 2 + c * s**3 + s**4)
        assert gain(filt, frequency * bandwidth, dt) == pytest.approx(expected, rel=0.02)
    assert abs(gain(filt, bandwidth, dt)) == pytest.approx(np.sqrt(0.5), rel=0.02)


def test_white_noise_comes_out_as_documented_and_not_much_larger_when_it_is_ready():
    rng, dt, sigma = np.random.default_rng(4), 1e-3, 0.01
    filt, stamps = filter_of(), np.arange(1000) * MS
    rows = filt.run(None, stamps, sigma * rng.standard_normal((1000, 1, 500)))
    expected = 1.54 * sigma * np.sqrt(filt.omega**5 * dt)
    # 2500 values: a few per cent of scatter.
    assert np.std(rows.derivatives[500::100, 2]) == pytest.approx(expected, rel=0.05)
    first = int(np.argmax(rows.ready))
    # 5 times the settled error, of which noise is the smaller part: the other is what snap adds.
    assert np.std(rows.derivatives[first, 2]) < 5.0 * 2.51 / 1.54 * 1.1 * expected
    assert stamps[first] * 1e-9 < 3.0 / filt.omega


def test_at_1_hz_accelerations_are_far_better_than_those_of_polynomials():
    """The kind of motion for which the filter is there; noise of 1e-5 at 1 kHz."""
    rng, stamps = np.random.default_rng(3), np.arange(4000) * MS
    angle = 2 * np.pi * stamps[:, None] * 1e-9
    acceleration = -0.1 * (2 * np.pi) ** 2 * np.sin(angle)
    position = 0.1 * np.sin(angle) + 1e-5 * rng.standard_normal((4000, 1))
    errors = []
    for kalman in (None, Kalman(15.0, 400.0)):
        rates = MotionEstimator(10.0, 0.5, kalman).run(
            None, stamps, position, np.zeros_like(position), np.zeros(4000, dtype=bool)
        )
        errors.append(np.std((rates.acceleration - acceleration)[1000:]))
    assert errors[1] < errors[0] / 3.0


@pytest.mark.parametrize("name", ["bandwidth", "velocity_noise", "max_gap"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_nonsense_settings_are_refused(name, value):
    settings = {"bandwidth": 10.0, "velocity_noise": 400.0, "max_gap": 0.5} | {name: value}
    with pytest.raises(ValueError, match=name):
        KalmanFilter(**settings)
