"""Laws of intervals: whatever is computed from points in them is in the result."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core.certified.boxes.interval_matrix import IntervalMatrix
from hybrid_dynamics_core.certified.interval import Interval
from hybrid_dynamics_core.certified.rounding import TERMS
from tests.sampling import examples

NUMBERS = st.floats(-1e6, 1e6, allow_subnormal=False)
ENDS = st.tuples(NUMBERS, NUMBERS, st.floats(0.0, 1.0))


def interval_and_point(ends: tuple[float, float, float]) -> tuple[Interval, float]:
    lower, upper = sorted(ends[:2])
    point = min(max(lower + ends[2] * (upper - lower), lower), upper)
    return Interval(lower, upper), point


@given(ENDS, ENDS)
@examples(400)
def test_sums_products_and_quotients_hold_the_exact_ones(a: tuple, b: tuple) -> None:
    one, x = interval_and_point(a)
    other, y = interval_and_point(b)
    p, q = Fraction(x), Fraction(y)
    exact = [(one + other, p + q), (one - other, p - q), (one * other, p * q), (one * one, p * p)]
    if not other.holds_zero():
        exact.append((one / other, p / q))
    for enclosure, value in exact:
        # fractions compare with floats exactly, and with infinite ones
        assert float(enclosure.lower) <= value <= float(enclosure.upper)


@given(ENDS)
@examples(400)
def test_roots_and_waves_hold_those_of_points(a: tuple) -> None:
    one, x = interval_and_point(a)
    pairs = [(one.sin(), np.sin(x)), (one.cos(), np.cos(x)), (one.absolute(), abs(x))]
    if x >= 0.0:
        pairs.append((one.sqrt(), np.sqrt(x)))
    for enclosure, value in pairs:
        assert enclosure.lower <= value <= enclosure.upper


@pytest.mark.parametrize(("lower", "upper"), [(-0.1, 0.1), (3.0, 3.3), (1.5, 1.6), (0.0, 7.0)])
def test_waves_hold_their_extreme_values(lower: float, upper: float) -> None:
    points = np.linspace(lower, upper, 1001)
    one = Interval(lower, upper)
    for enclosure, values in ((one.sin(), np.sin(points)), (one.cos(), np.cos(points))):
        assert enclosure.lower <= values.min()
        assert values.max() <= enclosure.upper
        assert enclosure.upper - enclosure.lower <= np.ptp(values) + 1e-4


def test_a_narrow_interval_is_inside_a_wider_one() -> None:
    assert Interval(0.1, 0.2).inside(Interval(0.0, 0.3))
    assert not Interval(0.0, 0.2).inside(Interval(0.0, 0.3))


def test_matrices_whose_rounding_is_not_bounded_have_no_inverse() -> None:
    middle = np.eye(TERMS + 1)[None]
    exact = IntervalMatrix(middle, np.zeros_like(middle))
    assert np.isnan(exact.preconditioner()).all()
    assert np.isinf(exact.inverse().radius).all()
