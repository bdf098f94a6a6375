"""Motions through change points and toggles, by `close_path(..., through_change_points=True)`.

The oracle is the four-bar's closed form with the sign of the height over the diagonal carried
through its double root.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.problems.four_bars import four_bars
from hybrid_dynamics_core import ClosureError, Robot, SingularityError
from hybrid_dynamics_core.closed_state.state import ClosureStatus
from hybrid_dynamics_core.errors import StateError
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.ground.arrays import Array
from tests.hard_cases.linkages import four_bar, robot
from tests.sampling import examples

EXACT = 1e-11  # R keeps twelve digits at the places from which a change point is interpolated


class Bars(NamedTuple):
    """A change-point four-bar that turns all round: it folds at the crank's angle `flat`."""

    ground: float
    crank: float
    coupler: float
    rocker: float
    flat: float

    def angles(self, u: Array, side: float) -> Array:
        """Rows (q1, q2, q3); the side of the diagonal changes where the bars fold."""
        tip = self.crank * np.exp(1j * u)
        across = self.ground - tip
        length = np.abs(across)
        along = (self.coupler**2 - self.rocker**2 + length**2) / (2.0 * length)
        # one factor of the square of the height has a double root, which is carried out of it
        half = np.sin(0.5 * (u - self.flat))
        four = 4.0 * self.ground * self.crank
        if self.flat:
            other = length**2 - (self.coupler - self.rocker) ** 2
        else:
            other = (self.coupler + self.rocker) ** 2 - length**2
        height = side * half * np.sqrt(four * other) / (2.0 * length)
        pin = tip + across / length * (along + 1j * height)
        q2 = np.angle((pin - tip) * np.exp(-1j * u))
        q3 = np.angle(pin - self.ground)
        return np.unwrap(np.column_stack([u, q2, q3]), axis=0)

    def robot(self, reference: float, side: float) -> Robot:
        q1, q2, q3 = self.angles(np.array([reference]), side)[0].tolist()
        text = f"q1: {q1!r}, q2: {q2!r}, q3: {q3!r}"
        bars = (self.ground, self.crank, self.coupler, self.rocker)
        return robot(four_bar(*bars, assembly="", reference=text))


@st.composite
def change_point_bars(draw: st.DrawFn) -> Bars:
    """Shortest and longest bar are together as long as the other two, so that the bars fold.

    The crank turns all round. Bars of equal length in pairs would fold twice, and are left out.
    """
    lengths = st.floats(0.15, 0.6)
    ground, crank = draw(lengths), draw(lengths)
    stretched = draw(st.booleans())
    shift = draw(st.floats(0.05, 0.9)) * min(ground, crank)
    if stretched:  # ground + crank = coupler + rocker
        total = ground + crank
        # the difference of coupler and rocker is less than that of ground and crank
        least = draw(st.floats(0.1, 0.9)) * abs(ground - crank)
        return Bars(ground, crank, 0.5 * (total + least), 0.5 * (total - least), np.pi)
    # |ground - crank| = |coupler - rocker|, and coupler and rocker reach far enough
    coupler = max(ground, crank) + shift
    rocker = coupler - abs(ground - crank)
    return Bars(ground, crank, coupler, rocker, 0.0)


def turned_off(angles: Array, expected: Array) -> Array:
    """Differences of angles [rad], less whole turns."""
    return np.asarray(np.remainder(angles - expected + np.pi, 2 * np.pi) - np.pi)


def folds_once(bars: Bars) -> bool:
    return abs(bars.ground - bars.crank) > 0.02


class TestChangePointFourBars:
    @examples(24)
    @given(change_point_bars().filter(folds_once), st.sampled_from([-1.0, 1.0]))
    def test_motion_keeps_its_branch_through_the_place(self, bars: Bars, side: float) -> None:
        start = bars.flat - 1.0
        u = np.linspace(start, bars.flat + 1.3, 12)
        machine = bars.robot(start, side)
        path = machine.close_path(u[:, None], np.ones((12, 1)), through_change_points=True)
        expected = bars.angles(u, side)
        assert np.abs(turned_off(path.s, expected)).max() < 1e-9
        (passage,) = path.passages
        assert passage.kind == "change point"
        assert passage.s[0] == pytest.approx(bars.flat, abs=1e-9)
        assert passage.index == int(np.argmax(u > bars.flat))
        assert passage.before != passage.after

    @examples(24)
    @given(change_point_bars().filter(folds_once), st.sampled_from([-1.0, 1.0]))
    def test_both_branches_are_told(self, bars: Bars, side: float) -> None:
        """Their rates are the derivatives of both closed forms, by central differences."""
        start = bars.flat - 0.5
        u = np.array([start, bars.flat + 0.5])
        path = bars.robot(start, side).close_path(u[:, None], through_change_points=True)
        (passage,) = path.passages
        step = 1e-5  # its square is the error of the difference
        nearby = bars.flat + step * np.array([-1.0, 1.0])
        for rates, way in ((passage.rates, side), (*passage.other_rates, -side)):
            before, after = bars.angles(nearby, way)
            assert np.array(rates) == pytest.approx((after - before) / (2 * step), abs=1e-5)


@pytest.fixture(scope="module")
def folded() -> Robot:
    """A parallelogram that is not named one: its bars fold at q1 = 0 and pi."""
    bars = (0.3, 0.1, 0.3, 0.1)
    return robot(four_bar(*bars, assembly="", reference="q1: 1, q2: -1, q3: 1"))


class TestFoldedParallelogram:
    def test_it_turns_twice_with_unit_rates(self, folded: Robot) -> None:
        u = np.linspace(1.0, 1.0 + 4 * np.pi, 90)
        path = folded.close_path(u[:, None], np.ones((90, 1)), through_change_points=True)
        assert path.s == pytest.approx(np.column_stack([u, -u, u]), abs=EXACT)
        assert path.ds == pytest.approx(np.tile([1.0, -1.0, 1.0], (90, 1)), abs=1e-9)
        places = [passage.s[0] for passage in path.passages]
        assert places == pytest.approx(np.pi * np.arange(1, 5), abs=EXACT)

    def test_the_branch_beyond_depends_on_no_spacing(self, folded: Robot) -> None:
        """Long and short steps over the place, from near and from far, agree."""
        rng = np.random.default_rng(3)
        for _ in range(20):
            before, beyond = 10.0 ** rng.uniform(-3.5, 0.3, size=2)
            start = folded.close([before])
            path = folded.close_path([[before], [-beyond]], near=start, through_change_points=True)
            assert path.s[-1] == pytest.approx([-beyond, beyond, -beyond], abs=1e-9)

    def test_the_crossed_linkage_passes_as_the_crossed_one(self, folded: Robot) -> None:
        """Both turn the rocker by a turn while the crank makes one; the crossed one backwards."""
        crossed = folded.close([-1.0])  # the mode of the same name, on the other side
        u = np.linspace(-1.0, -1.0 + 2 * np.pi, 30)[:, None]
        path = folded.close_path(u, near=crossed, through_change_points=True)
        assert len(path.passages) == 2
        assert abs(path.s[-1, 2] - path.s[0, 2]) == pytest.approx(2 * np.pi, abs=1e-9)
        assert np.diff(path.s[:, 2]).max() < 0.0

    def test_both_motions_are_told(self, folded: Robot) -> None:
        """The crossed bars' ratio is (coupler + crank) / (coupler - crank) at the fold."""
        path = folded.close_path([[1.0], [-1.0]], through_change_points=True)
        (passage,) = path.passages
        assert np.array(passage.rates) / -2.0 == pytest.approx([1.0, -1.0, 1.0], abs=1e-9)
        (other,) = passage.other_rates
        assert np.array(other) / -2.0 == pytest.approx([1.0, -2.0, -2.0], abs=1e-9)
        name = folded.close([1.0]).branch["bar"]
        assert passage.before == {"bar": name}
        assert passage.after == dict(path.branch)
        assert passage.after != passage.before
        assert "loop 'bar' passed a change point" in passage.message

    def test_a_row_at_the_place_is_told_and_has_no_efforts(self, folded: Robot) -> None:
        u = np.array([[0.5], [0.0], [0.0], [-0.5]])
        path = folded.close_path(u, np.ones((4, 1)), through_change_points=True)
        singular = ClosureStatus.SINGULAR
        assert path.status.tolist() == [0, singular, singular, 0]
        assert path.s[1] == pytest.approx([0.0, 0.0, 0.0], abs=EXACT)
        assert path.ds[1] == pytest.approx([1.0, -1.0, 1.0], abs=1e-9)
        efforts = folded.inverse_dynamics(path, np.zeros((4, 1)))
        assert np.isnan(efforts[:, 0]).tolist() == [False, True, True, False]
        assert len(path.passages) == 1

    def test_a_path_that_turns_back_at_the_place_stays_on_its_branch(self, folded: Robot) -> None:
        u = np.array([0.5, 0.0, 0.5, -0.5])
        path = folded.close_path(u[:, None], through_change_points=True)
        assert path.s == pytest.approx(np.column_stack([u, -u, u]), abs=1e-9)

    def test_without_the_word_it_ends(self, folded: Robot) -> None:
        u = np.linspace(1.0, -1.0, 12)[:, None]
        with pytest.raises(SingularityError) as caught:
            folded.close_path(u)
        assert caught.value.index == 6

    def test_a_motion_that_meets_no_singular_place_is_the_same_with_the_word(
        self, folded: Robot
    ) -> None:
        u = np.linspace(1.0, 3.0, 9)[:, None]
        plain, through = folded.close_path(u), folded.close_path(u, through_change_points=True)
        assert (plain.s == through.s).all()
        assert through.passages == ()

    @pytest.mark.parametrize("gap", [1e-2, 1e-4, 1e-6, 1e-8, -1e-2, -1e-4, -1e-6, -1e-8])
    def test_a_near_miss_is_no_change_point(self, gap: float) -> None:
        """The bars do not fold by a gap: the motion has the end, or the mode, that it had."""
        near = robot(four_bar(0.5, 0.25, 0.625 + gap, 0.375))
        u = np.linspace(1.0, -1.0, 12)[:, None]
        outcomes = []
        for word in (False, True):
            try:
                path = near.close_path(u, through_change_points=word)
                outcomes.append((path.s.tolist(), path.passages))
            except StateError as error:
                outcomes.append((str(error), ()))
        assert outcomes[0] == outcomes[1]


@pytest.mark.parametrize("count", [1, 2, 10])
def test_a_row_of_four_bars_goes_round_as_parallelograms(count: int) -> None:
    """All loops fold at once; each goes on as a parallelogram, and could go on as a crossed one."""
    text = four_bars(count).replace(", assembly: parallelogram", "")
    joints = [f"a{k}: 0.3" for k in range(count + 1)]
    joints += [f"b{k + 1}: -0.3" for k in range(count)]
    text = text.replace("reference: {a0: 0}", f"reference: {{{', '.join(joints)}}}")
    row = Robot(parse_description(text))
    u = np.linspace(0.3, 0.3 + 2 * np.pi, 25)
    path = row.close_path(u[:, None], through_change_points=True)
    ways = np.array([1.0] * (count + 1) + [-1.0] * count)
    assert path.s == pytest.approx(u[:, None] * ways, abs=1e-9)
    for passage in path.passages:
        assert passage.loops == row.loops
        assert len(passage.other_rates) == count
    assert len(path.passages) == 2


SPHERICAL = """
format: 1
name: spherical
links: {base: {}, crank: {mass: 1}, coupler: {mass: 1}, rocker: {mass: 1}}
joints:
  q1: {type: revolute, parent: base, child: crank, axis: z}
  q2: {type: revolute, parent: crank, child: coupler, origin: {rpy: [0.4, 0, 0]}, axis: z}
  q3: {type: revolute, parent: base, child: rocker, origin: {rpy: [1, 0, 0]}, axis: z}
closures:
  bar: {kind: axis, between: {coupler: {rpy: [1, 0, 0]}, rocker: {rpy: [0.4, 0, 0]}}}
active: [q1]
end_effector: {link: rocker}
reference: {q1: 1, q2: -1, q3: 1}
"""


def test_a_spherical_four_bar_closed_by_iteration_passes() -> None:
    """Redundant equations, no closed form. q3 is odd in q1, so the motion is the same backwards."""
    bar = Robot(parse_description(SPHERICAL))
    assert bar.follows
    u = np.linspace(1.0, -1.0, 21)[:, None]
    path = bar.close_path(u, through_change_points=True)
    assert path.s == pytest.approx(-path.s[::-1], abs=1e-9)
    (passage,) = path.passages
    # arcs of 1 and 0.4 rad fold: half angles have the constant ratios of Napier's analogies
    assert passage.rates[2] / passage.rates[0] == pytest.approx(np.cos(0.7) / np.cos(0.3))
    (other,) = passage.other_rates
    assert other[2] / other[0] == pytest.approx(-np.sin(0.7) / np.sin(0.3))


@pytest.fixture(scope="module")
def bar() -> Robot:
    return robot(four_bar(0.3, 0.1, 0.3, 0.2, active="q3", reference="q3: 1.6"))


class TestToggles:
    """Driven by the rocker, the four-bar's crank and coupler come in line where q3 turns back."""

    EDGE = np.pi - np.arccos((0.3**2 + 0.2**2 - 0.4**2) / (2 * 0.3 * 0.2))

    def test_a_path_that_touches_the_end_goes_on_in_the_other_mode(self, bar: Robot) -> None:
        u = np.array([1.6, 1.4, self.EDGE, self.EDGE, 1.4, 1.6])[:, None]
        path = bar.close_path(u, through_change_points=True)
        (passage,) = path.passages
        assert passage.kind == "toggle"
        assert passage.other_rates == ()
        assert passage.rates[0] == pytest.approx(0.0, abs=1e-9)
        names = [passage.before["bar"], passage.after["bar"]]
        assert names == ["counterclockwise", "clockwise"]
        for row, mode in ((0, names[0]), (1, names[0]), (4, names[1]), (5, names[1])):
            alone = bar.close(u[row], branch={"bar": mode})
            assert path.s[row] == pytest.approx(alone.s, abs=1e-9)
        assert path.status.tolist() == [0, 0, 2, 2, 0, 0]
        assert np.isnan(path.R[2]).all()
        # in line: the pin is as far from the crank's pivot as both bars are long
        assert path.s[2, 2] == pytest.approx(0.0, abs=1e-9)

    def test_a_path_that_turns_before_the_end_stays_on_its_mode(self, bar: Robot) -> None:
        u = np.array([1.6, self.EDGE + 1e-6, 1.6])[:, None]
        path = bar.close_path(u, through_change_points=True)
        assert path.passages == ()
        assert path.s[2] == pytest.approx(path.s[0], abs=1e-9)

    def test_beyond_the_end_nothing_closes(self, bar: Robot) -> None:
        u = np.array([1.6, self.EDGE, self.EDGE - 0.1])[:, None]
        with pytest.raises(ClosureError) as caught:
            bar.close_path(u, through_change_points=True)
        assert caught.value.index == 2
