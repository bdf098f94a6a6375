"""The rate filter: exactness, bandwidth, lag, noise, and what stamps do to it."""

import numpy as np
import pytest

from hybrid_dynamics_ros.stream.filter.filter import StampEvent
from hybrid_dynamics_ros.stream.filter.polynomial import PolynomialFilter
from hybrid_dynamics_ros.stream.filter.rate_estimator import MotionEstimator

MS = 1_000_000  # [ns]
DEGREES = pytest.mark.parametrize("degree", [1, 2])


def run(filt, stamps_ns, samples):
    """All states of a stream."""
    states = []
    state = None
    for stamp, sample in zip(stamps_ns, samples, strict=True):
        state, _ = filt.step(state, int(stamp), np.array(sample, dtype=float).reshape(1, -1))
        states.append(state)
    return states


def irregular(rng, count, mean_ms=5.0):
    return np.cumsum(1 + rng.exponential(mean_ms * MS, count).astype(np.int64))


@DEGREES
def test_a_polynomial_of_its_degree_is_exact_from_the_first_samples_on_at_any_stamps(degree):
    rng = np.random.default_rng(1)
    stamps = irregular(rng, 2000)
    t = stamps * 1e-9
    value, slope, curvature = 0.3, -0.2, 3.0 if degree == 2 else 0.0
    samples = value + slope * t + 0.5 * curvature * t * t
    states = run(PolynomialFilter(degree, bandwidth=10.0, max_gap=0.5), stamps, samples)
    for time, sample, state in list(zip(t, samples, states, strict=True))[degree:]:
        assert state.quality == degree
        expected = [sample, slope + curvature * time, curvature][: degree + 1]
        # Rounding of the samples (1e-16 of up to 150) over squares of intervals of some ms.
        np.testing.assert_allclose(state.derivatives[:, 0], expected, rtol=0, atol=1e-7)


@DEGREES
def test_a_higher_polynomial_leaves_the_lag_and_nothing_else(degree):
    """A ramp of the highest derivative is followed with the documented delay."""
    rng = np.random.default_rng(2)
    filt = PolynomialFilter(degree, bandwidth=5.0, max_gap=1.0)
    stamps = irregular(rng, 20000, mean_ms=0.2)
    t = stamps * 1e-9
    samples = t**2 / 2 if degree == 1 else t**3 / 6
    settled = [s.derivatives[degree, 0] for s in run(filt, stamps, samples)][10000:]
    delays = t[10000:] - settled
    assert np.mean(delays) == pytest.approx(filt.lag, rel=0.02)
    assert filt.lag == pytest.approx({1: 0.205, 2: 0.243}[degree] / 5.0, rel=2e-3)


@DEGREES
def test_a_change_of_the_sample_rate_does_not_change_the_lag(degree):
    """A hundred times fewer samples from one moment on.

    The dense past must not outweigh the sparse present.
    """
    filt = PolynomialFilter(degree, bandwidth=2.0, max_gap=1.0)
    dense, sparse = np.arange(0.0, 0.5, 5e-5), np.arange(0.5, 1.0, 5e-3)
    stamps = np.round(np.concatenate([dense, sparse]) * 1e9).astype(np.int64)
    t = stamps * 1e-9
    states = run(filt, stamps, t**2 / 2 if degree == 1 else t**3 / 6)
    delays = np.array([time - s.derivatives[degree, 0] for time, s in zip(t, states, strict=True)])
    assert np.ptp(delays[t > 0.49]) < 0.1 * filt.lag


def response(filt, frequency, dt):
    """Complex gain of the highest derivative against the true one, from a settled sine."""
    stamps = np.arange(int((5.0 / filt.bandwidth + 5.0 / frequency) / dt)) * round(dt * 1e9)
    t = stamps * 1e-9
    omega = 2 * np.pi * frequency
    output = np.array([s.derivatives[filt.degree, 0] for s in run(filt, stamps, np.sin(omega * t))])
    tail = t > t[-1] - 4.0 / frequency
    parts = np.column_stack([np.sin(omega * t[tail]), np.cos(omega * t[tail])])
    in_phase, quadrature = np.linalg.lstsq(parts, output[tail], rcond=None)[0]
    return (in_phase + 1j * quadrature) / (1j * omega) ** filt.degree


@DEGREES
@pytest.mark.parametrize("dt", [0.5e-3, 2e-3])
def test_sines_pass_as_the_documented_transfer_function_says(degree, dt):
    filt = PolynomialFilter(degree, bandwidth=10.0, max_gap=0.5)
    for frequency in (0.5, 2.0, 5.0, 10.0, 20.0, 40.0):
        omega = 2 * np.pi * frequency
        expected = (filt.rate / (1j * omega + filt.rate)) ** (degree + 1) * np.exp(
            0.5j * omega * dt
        )
        # The discrete filter is the continuous one half a sample earlier, up to terms of second
        # order in dt.
        slack = 1e-6 + (degree + 1) * filt.rate * omega * dt**2 / 10 + (omega * dt) ** 2 / 10
        assert abs(response(filt, frequency, dt) - expected) < slack


@DEGREES
@pytest.mark.parametrize("bandwidth", [2.0, 10.0, 50.0])
def test_the_bandwidth_is_where_3_db_are_lost(degree, bandwidth):
    filt = PolynomialFilter(degree, bandwidth, max_gap=0.5)
    assert abs(response(filt, bandwidth, dt=0.01 / bandwidth)) == pytest.approx(
        np.sqrt(0.5), rel=0.01
    )


@DEGREES
def test_the_bandwidth_does_not_depend_on_jitter_or_on_lost_samples(degree):
    rng = np.random.default_rng(3)
    filt = PolynomialFilter(degree, bandwidth=5.0, max_gap=0.5)
    steps = rng.uniform(0.2e-3, 1.8e-3, 6000) * rng.choice([1.0, 1.0, 1.0, 4.0], 6000)
    stamps = np.round(np.cumsum(steps) * 1e9).astype(np.int64)
    t, omega = stamps * 1e-9, 2 * np.pi * 5.0
    output = np.array([s.derivatives[degree, 0] for s in run(filt, stamps, np.sin(omega * t))])
    tail = t > 2.0
    parts = np.column_stack([np.sin(omega * t[tail]), np.cos(omega * t[tail])])
    gain = np.hypot(*np.linalg.lstsq(parts, output[tail], rcond=None)[0]) / omega**degree
    assert gain == pytest.approx(np.sqrt(0.5), rel=0.03)


@DEGREES
def test_white_noise_comes_out_as_documented(degree):
    rng = np.random.default_rng(4)
    filt, dt, sigma = PolynomialFilter(degree, bandwidth=10.0, max_gap=0.5), 0.5e-3, 0.01
    stamps = np.arange(3000) * round(dt * 1e9)
    states = run(filt, stamps, sigma * rng.standard_normal((3000, 50)))
    measured = np.std([s.derivatives[degree] for s in states[1000::100]])
    rate = filt.rate
    expected = sigma * np.sqrt({1: rate**3 * dt / 4, 2: 3 * rate**5 * dt / 16}[degree])
    assert measured == pytest.approx(expected, rel=0.1)  # 1000 values: a few per cent of scatter


@DEGREES
def test_when_it_is_ready_noise_is_near_what_it_settles_at(degree):
    rng = np.random.default_rng(5)
    filt = PolynomialFilter(degree, bandwidth=10.0, max_gap=0.5)
    states = run(filt, np.arange(2000) * MS, rng.standard_normal((2000, 500)))
    ready = [filt.ready(s) for s in states]
    first = ready.index(True)
    assert all(ready[first:])
    assert first == pytest.approx(filt.lag * 1000, abs=1)
    settled = np.std([s.derivatives[degree] for s in states[1000::50]])
    assert np.std(states[first].derivatives[degree]) < 5.0 * settled


@DEGREES
def test_a_bandwidth_above_the_sample_rate_gives_difference_quotients(degree):
    rng = np.random.default_rng(6)
    samples = rng.standard_normal(50)
    dt = 0.05
    states = run(
        PolynomialFilter(degree, bandwidth=1000.0, max_gap=0.5), np.arange(50) * 50 * MS, samples
    )
    quotient = np.diff(samples, degree) / dt**degree
    found = np.array([s.derivatives[degree, 0] for s in states])[degree:]
    # A tenth of the weight stays with older samples, so it is not quite the quotient.
    assert np.corrcoef(quotient, found)[0, 1] > {1: 0.98, 2: 0.95}[degree]


@DEGREES
def test_joints_do_not_mix_to_the_last_bit(degree):
    rng = np.random.default_rng(7)
    stamps, samples = irregular(rng, 300), rng.standard_normal((300, 7))
    filt = PolynomialFilter(degree, bandwidth=10.0, max_gap=0.5)
    together = run(filt, stamps, samples)[-1]
    for joint in range(7):
        alone = run(filt, stamps, samples[:, joint])[-1]
        assert np.array_equal(alone.derivatives[:, 0], together.derivatives[:, joint])


def test_a_step_leaves_the_state_before_as_it_was():
    filt = PolynomialFilter(1, bandwidth=10.0, max_gap=0.5)
    sample = np.array([[1.0, 2.0]])
    first, _ = filt.step(None, 0, sample)
    kept = first.derivatives.copy()
    sample[:] = 99.0
    one, _ = filt.step(first, MS, np.array([[3.0, 4.0]]))
    two, _ = filt.step(first, MS, np.array([[3.0, 4.0]]))
    assert np.array_equal(first.derivatives, kept)
    assert np.array_equal(first.sample, [[1.0, 2.0]])
    assert np.array_equal(one.derivatives, two.derivatives)


@DEGREES
@pytest.mark.parametrize(
    ("stamp_ms", "value", "event", "restarts"),
    [
        (101, 0.3, StampEvent.NEXT, False),
        (600, 0.3, StampEvent.NEXT, False),
        (601, 0.3, StampEvent.GAP, True),
        (99, 0.3, StampEvent.BACKWARD, True),
        (0, 0.3, StampEvent.BACKWARD, True),
        (100, 0.3, StampEvent.CONFLICT, True),
        (100, 0.2, StampEvent.REPEATED, False),
    ],
)
def test_what_a_stamp_means(degree, stamp_ms, value, event, restarts):
    filt = PolynomialFilter(degree, bandwidth=10.0, max_gap=0.5)
    before = run(filt, np.arange(0, 101, 10) * MS, np.linspace(0.0, 0.2, 11))[-1]
    assert filt.ready(before)
    after, found = filt.step(before, stamp_ms * MS, np.array([[value]]))
    assert found is event
    assert filt.ready(after) is not restarts
    assert after.start_ns == (stamp_ms * MS if restarts else 0)
    if event is StampEvent.REPEATED:
        assert after is before


@DEGREES
def test_stamps_that_almost_coincide_do_not_blow_up(degree):
    """Two stamps a nanosecond apart, noise between them.

    No derivative of 1e9 comes out, then or later.
    """
    rng = np.random.default_rng(8)
    pairs = np.arange(400) * 5 * MS
    stamps = np.ravel(np.column_stack([pairs, pairs + 1]))
    samples = 0.7 * stamps * 1e-9 + 1e-6 * rng.standard_normal(800)
    filt = PolynomialFilter(degree, bandwidth=10.0, max_gap=0.5)
    states = run(filt, stamps, samples)
    ready = [s for s in states if filt.ready(s)]
    assert len(ready) > 700
    # Noise over the time in which it became ready, blown up by the start: 5 sigma and more.
    np.testing.assert_allclose([s.derivatives[1, 0] for s in ready], 0.7, atol=2e-3)
    np.testing.assert_allclose(
        [s.derivatives[degree, 0] for s in ready], [0.7, 0.0][degree - 1], atol=0.2
    )


@pytest.mark.parametrize("apart_ns", [1, 2, 5, 20])
def test_a_third_stamp_that_almost_coincides_with_the_second_says_nothing_about_a_curvature(
    apart_ns,
):
    rng = np.random.default_rng(9)
    stamps = np.array([0, 10 * MS, 10 * MS + apart_ns, *range(20 * MS, 100 * MS, 10 * MS)])
    samples = 0.7 * stamps * 1e-9 + 1e-6 * rng.standard_normal(stamps.size)
    states = run(PolynomialFilter(2, bandwidth=10.0, max_gap=0.5), stamps, samples)
    assert [s.quality for s in states] == [0, 1, 1] + [2] * 8
    # Noise over intervals of 10 ms: 1e-6 / 1e-4 s^2, and some more.
    assert max(abs(s.derivatives[2, 0]) for s in states) < 0.1


@pytest.mark.parametrize("name", ["bandwidth", "max_gap"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_nonsense_settings_are_refused(name, value):
    settings = {"bandwidth": 10.0, "max_gap": 0.5} | {name: value}
    with pytest.raises(ValueError, match=name):
        PolynomialFilter(1, **settings)


@DEGREES
@pytest.mark.parametrize("bandwidth", [1e-12, 1e-9, 1e-6])
@pytest.mark.parametrize("apart_ns", [1, 10 * MS])
def test_the_slowest_filters_and_the_shortest_steps_give_the_polynomial(
    degree, bandwidth, apart_ns
):
    """The weight of a sample is far below the rounding of 1, and counts all the same."""
    stamps = apart_ns * np.arange(20)
    t = stamps / stamps[-1]
    samples = 0.3 - 0.2 * t + (0.5 * t * t if degree == 2 else 0.0)
    last = run(PolynomialFilter(degree, bandwidth, max_gap=0.5), stamps, samples)[-1]
    assert last.quality == degree
    scale = (stamps[-1] * 1e-9) ** np.arange(degree + 1)
    expected = [samples[-1], -0.2 + (1.0 if degree == 2 else 0.0), 1.0][: degree + 1]
    # Rounding of the samples (1e-16) over squares of 1/19, and the condition of a fit over equal
    # weights.
    np.testing.assert_allclose(last.derivatives[:, 0] * scale, expected, rtol=0, atol=1e-9)


def test_a_bandwidth_too_small_to_compute_with_is_refused():
    with pytest.raises(ValueError, match="bandwidth is 1e-300 Hz, expected 1e-12 Hz or more"):
        PolynomialFilter(1, bandwidth=1e-300, max_gap=0.5)


def test_a_degree_it_does_not_have_is_refused():
    with pytest.raises(ValueError, match="degree"):
        PolynomialFilter(3, bandwidth=10.0, max_gap=0.5)


def feed(estimator, times, position, velocity=None):
    state, estimates = None, []
    for t in times:
        state, estimate = estimator.step(
            state, round(t * 1e9), position(t), None if velocity is None else velocity(t)
        )
        estimates.append(estimate)
    return state, estimates


def test_measured_velocities_pass_unchanged_and_give_the_acceleration():
    estimator = MotionEstimator(bandwidth=10.0, max_gap=0.5)
    times = np.arange(0, 0.1, 0.01)
    _, estimates = feed(
        estimator, times, lambda t: np.array([t, 0.0]), lambda t: np.array([1.0, 3 * t])
    )
    assert [e.acceleration is not None for e in estimates] == [t >= 0.0204 for t in times]
    for t, estimate in zip(times, estimates, strict=True):
        assert np.array_equal(estimate.velocity, [1.0, 3 * t])
    np.testing.assert_allclose(estimates[-1].acceleration, [0.0, 3.0], atol=1e-9)


def test_without_velocities_both_come_from_the_positions():
    estimator = MotionEstimator(bandwidth=10.0, max_gap=0.5)
    times = np.arange(0, 0.1, 0.01)
    _, estimates = feed(estimator, times, lambda t: np.array([0.5 * t, 2 * t * t]))
    assert estimates[0].velocity is None
    assert [e.velocity is None for e in estimates] == [e.acceleration is None for e in estimates]
    np.testing.assert_allclose(estimates[-1].velocity, [0.5, 4 * 0.09], atol=1e-9)
    np.testing.assert_allclose(estimates[-1].acceleration, [0.0, 4.0], atol=1e-7)


def test_a_change_of_what_messages_carry_starts_anew():
    estimator = MotionEstimator(bandwidth=10.0, max_gap=0.5)
    state, _ = feed(
        estimator, np.arange(0, 0.1, 0.01), lambda t: np.array([t]), lambda _: np.array([1.0])
    )
    state, estimate = estimator.step(state, 110 * MS, np.array([0.11]), None)
    assert estimate.event is StampEvent.FIRST
    assert estimate.velocity is None
    assert estimate.acceleration is None
    _, estimate = estimator.step(state, 120 * MS, np.array([0.12]), np.array([1.0]))
    assert np.array_equal(estimate.velocity, [1.0])
    assert estimate.acceleration is None
