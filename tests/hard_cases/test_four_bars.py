"""Four-bars where they are hard: folded, at change points, on mirror branches, round and round."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import ClosureError, DescriptionError, Robot, SingularityError
from hybrid_dynamics_core.closed_state import mode_search
from hybrid_dynamics_core.closed_state.assembly_modes import AssemblyModes, Completeness
from hybrid_dynamics_core.formats.reader import parse_description
from tests.hard_cases.linkages import four_bar, robot
from tests.hard_cases.test_over_determined import framed

GROUND, CRANK = 0.3, 0.1  # of the parallelogram: coupler like ground, rocker like crank


@pytest.fixture(scope="module")
def crank_rocker() -> Robot:
    """Shortest and longest bar together are shorter than the other two.

    The crank turns all round.
    """
    return robot(four_bar(0.3, 0.1, 0.3, 0.2))


@pytest.fixture(scope="module")
def parallelogram() -> Robot:
    return robot(
        four_bar(
            GROUND, CRANK, GROUND, CRANK, assembly="parallelogram", reference="q1: 1, q2: -1, q3: 1"
        )
    )


@pytest.fixture(scope="module")
def general() -> Robot:
    """The same bars, not named a parallelogram."""
    return robot(
        four_bar(GROUND, CRANK, GROUND, CRANK, assembly="", reference="q1: 1, q2: -1, q3: 1")
    )


class TestModesNextToTheEnd:
    """Driven by the rocker, both modes of the four-bar meet where it folds."""

    EDGE = np.pi - np.arccos((0.3**2 + 0.2**2 - 0.4**2) / (2 * 0.3 * 0.2))

    @pytest.mark.parametrize("way", [1e-4, 1e-9, 1e-11, 1e-13, 1e-16, 0.0, -1e-16, -1e-13, -1e-8])
    def test_the_list_has_both_or_says_that_it_may_be_short(self, way: float) -> None:
        """Rounding decides on which side of the end an input is; far outside there is no mode."""
        bar = robot(four_bar(0.3, 0.1, 0.3, 0.2, active="q3", reference="q3: 1.6"))
        modes = bar.assembly_modes([self.EDGE + way])
        self.assert_honest(modes, way)
        assert (modes.completeness is Completeness.PROVEN) == (abs(way) >= 1e-9)

    @pytest.mark.parametrize("way", [1e-4, 1e-12, 0.0, -1e-12])
    def test_so_does_a_list_found_by_iteration(
        self, way: float, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(mode_search, "MOST_STARTS", mode_search.STARTS)
        text = framed("[0.3, -1.2, 2]", "[0.3, -1.2, 2]").replace("active: [q1]", "active: [q3]")
        modes = robot(text).assembly_modes([self.EDGE + way])
        self.assert_honest(modes, way)

    @staticmethod
    def assert_honest(modes: AssemblyModes, way: float) -> None:
        if abs(way) < 1e-9:
            assert modes.completeness is Completeness.UNLIKELY
            assert "left out, nearer than 1e-05 to a singular place, loop 'bar'" in modes.reason
        else:
            assert len(modes) == (2 if way > 0.0 else 0)


class TestFolded:
    @pytest.mark.parametrize("sign", [-1, 1])
    def test_rocker_stops_where_crank_and_coupler_are_in_line(self, sign: int) -> None:
        """Driven by the rocker.

        From the law of cosines, with the diagonal coupler + crank or coupler - crank.
        """
        driven = robot(four_bar(0.3, 0.1, 0.3, 0.2, active="q3", reference="q3: 1.6"))
        diagonal = 0.3 + sign * 0.1
        edge = np.pi - np.arccos((0.3**2 + 0.2**2 - diagonal**2) / (2 * 0.3 * 0.2))
        assert driven.closing_range[0, 0 if sign > 0 else 1] == pytest.approx(edge, abs=1e-12)
        outward = -float(sign)
        inside, outside = edge - 1e-4 * outward, edge + 1e-4 * outward
        assert (
            0.0 < float(driven.close([inside]).singularity) < 0.03
        )  # goes down with the root of the way left
        with pytest.raises(
            ClosureError, match=r"outside of \[.*\] rad, where the loop closes$"
        ) as caught:
            driven.close([outside])
        assert caught.value.allowed == pytest.approx(tuple(driven.closing_range[0]), abs=1e-12)
        with pytest.raises(SingularityError):
            driven.close([edge])
        with pytest.raises(ClosureError):
            driven.close([outside], near=driven.close([inside]))

    def test_all_bars_in_line_is_singular_however_driven(self) -> None:
        """Ground + crank = coupler + rocker: the linkage folds flat at q1 = pi."""
        for active, flat in (("q1", np.pi), ("q3", np.pi)):
            folding = robot(
                four_bar(
                    0.4,
                    0.1,
                    0.3,
                    0.2,
                    active=active,
                    reference="q1: 2.9, q2: -0.5, q3: 2.5",
                    assembly="",
                )
            )
            with pytest.raises(SingularityError):
                folding.close([flat])

    def test_a_bar_that_reaches_nowhere_is_refused_when_loaded(self) -> None:
        with pytest.raises(DescriptionError, match=r"loops\.bar: does not close") as caught:
            robot(four_bar(1.3, 0.1, 0.3, 0.1))
        assert caught.value.line is not None

    @pytest.mark.parametrize(("ground", "reference"), [(1.3, 1.0), (0.9, -0.4)])
    def test_the_refusal_tells_how_far_it_stays_open(self, ground: float, reference: float) -> None:
        """Coupler and rocker together are shorter than the way from crank pin to rocker pivot.

        By the difference.
        """
        way = float(np.hypot(ground - 0.1 * np.cos(reference), 0.1 * np.sin(reference)))
        with pytest.raises(DescriptionError, match=r"loops\.bar: does not close") as caught:
            robot(four_bar(ground, 0.1, 0.3, 0.2, reference=f"q1: {reference}"))
        assert (
            f"open by {way - 0.5:.3g} m at best, at q1 = {reference:g} rad; mend the geometry"
            in str(caught.value)
        )

    def test_millimetres_are_mentioned(self) -> None:
        with pytest.raises(
            DescriptionError,
            match=r"open by 300 m at best.*lengths are in metres: 300 m .* 0\.1 m;",
        ):
            robot(four_bar(0.3, 0.1, 300, 0.2))


class TestMirrorBranches:
    @pytest.mark.parametrize("u", [0.3, 1.0, 2.0, -2.5, 3.0])
    def test_modes_are_mirror_images(self, crank_rocker: Robot, u: float) -> None:
        """Mirrored in the line of the ground.

        Crank and mode change sides, all angles change sign.
        """
        other = crank_rocker.close([-u], branch={"bar": "clockwise"})
        off = np.remainder(other.s + crank_rocker.close([u]).s + np.pi, 2.0 * np.pi) - np.pi
        assert np.abs(off).max() < 1e-14  # of few operations, but for whole turns
        assert np.abs(other.R - crank_rocker.close([u]).R).max() < 1e-13

    def test_both_modes_are_listed(self, crank_rocker: Robot) -> None:
        modes = crank_rocker.assembly_modes([0.7])
        assert sorted(mode.branch["bar"] for mode in modes) == ["clockwise", "counterclockwise"]

    def test_a_state_keeps_its_side(self, crank_rocker: Robot) -> None:
        """Coming from the mirrored mode its motion stays there, all the way round."""
        state = crank_rocker.close([0.7], branch={"bar": "clockwise"})
        path = crank_rocker.close_path(0.7 + np.linspace(0.0, 2 * np.pi, 30)[:, None], near=state)
        assert path.branch["bar"] == "clockwise"
        assert np.all(np.sin(path.s[:, 2]) < 0.0)  # the rocker never crosses the ground
        assert np.all(np.sin(crank_rocker.close(path.u).s[:, 2]) > 0.0)


class TestRoundAndRound:
    def test_crank_turns_ten_times(self, crank_rocker: Robot) -> None:
        """The coupler's angle from the crank goes round with it; whole turns of it are no jump."""
        state = crank_rocker.close([0.7])
        for u in 0.7 + np.arange(1, 201) * np.pi / 10:
            state = crank_rocker.close([u], near=state)
            assert state.s[2] == pytest.approx(
                crank_rocker.close([np.remainder(u, 2 * np.pi)]).s[2], abs=1e-12
            )
        far = crank_rocker.close([0.7 + 20 * np.pi], near=crank_rocker.close([0.7]))
        assert far.s[2] == pytest.approx(state.s[2], abs=1e-12)

    def test_parallelogram_turns_ten_times_through_its_change_points(
        self, parallelogram: Robot
    ) -> None:
        """q2 = -q1, q3 = q1, everywhere, with unit rates and nothing near singular."""
        u = np.linspace(1.0, 1.0 + 20 * np.pi, 200)
        path = parallelogram.close_path(u[:, None], np.ones((200, 1)))
        assert path.s == pytest.approx(np.column_stack([u, -u, u]), abs=1e-12)
        assert path.ds == pytest.approx(np.tile([1.0, -1.0, 1.0], (200, 1)), abs=1e-15)
        assert np.min(path.singularity) == 1.0
        for flat in (0.0, np.pi, -np.pi):
            assert parallelogram.close([flat], near=parallelogram.close([1.0])).s == pytest.approx(
                [flat, -flat, flat]
            )

    @pytest.mark.parametrize("given", ["q2", "q3"])
    def test_parallelogram_is_regular_from_any_joint(
        self, parallelogram: Robot, given: str
    ) -> None:
        for value in np.linspace(-4.0, 4.0, 17):
            state = parallelogram.close_given({given: value})
            u = -value if given == "q2" else value
            assert state.s == pytest.approx([u, -u, u], abs=1e-13)


class TestChangePoints:
    def test_change_point_itself_is_singular(self, general: Robot) -> None:
        for u in (0.0, np.pi):
            with pytest.raises(SingularityError) as caught:
                general.close([u])
            assert caught.value.loop == "bar"
            assert caught.value.distance < 1e-5

    @pytest.mark.sweep(sample="test_path_over_a_change_point_names_the_row")
    def test_no_step_crosses_a_change_point(self, general: Robot) -> None:
        """Two hundred steps over q1 = 0 or pi, long and short, from all distances.

        Every one is refused.

        Just beyond, the coordinates are nearly where they were foretold; only their rates have
        jumped.
        """
        rng = np.random.default_rng(4)
        for _ in range(200):
            edge = rng.choice([0.0, np.pi])
            before, beyond = 10.0 ** rng.uniform(-4.0, 0.3, size=2)
            inward = 1.0 if edge == 0.0 else -1.0
            start = general.close([edge + inward * before])
            with pytest.raises(SingularityError, match=r"change point|singular"):
                general.close([edge - inward * beyond], near=start)

    def test_steps_on_one_side_are_taken(self, general: Robot) -> None:
        rng = np.random.default_rng(5)
        for start, end in rng.uniform(0.01, np.pi - 0.01, size=(100, 2)):
            state = general.close([end], near=general.close([start]))
            assert state.s == pytest.approx(
                [end, -end, end], abs=1e-9
            )  # the parallelogram, near its change points

    def test_path_over_a_change_point_names_the_row(self, general: Robot) -> None:
        u = np.linspace(1.0, -1.0, 12)[:, None]  # steps of 0.18: the seventh lies beyond zero
        with pytest.raises(SingularityError) as caught:
            general.close_path(u)
        assert caught.value.index == 6

    def test_beyond_it_the_mode_of_the_same_name_is_the_other_linkage(self, general: Robot) -> None:
        """Asked without a way there.

        The named side of the diagonal, which here is the anti-parallelogram.
        """
        name = general.close([1.0]).branch["bar"]
        anti = general.close([-1.0])
        assert anti.branch["bar"] == name
        assert abs(anti.s[2] - anti.s[0]) > 0.1
        crossed = next(m for m in general.assembly_modes([-1.0]) if m.branch["bar"] != name)
        assert crossed.state.s == pytest.approx([-1.0, 1.0, -1.0], abs=1e-12)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            {"active": "q1, q2"},
            "2 joints are named, .* 1 degree of freedom; name 1: bar would be fixed more than once",
        ),
        ({"active": "q1, q2, q3"}, "3 joints are named, .* 1 degree of freedom; name 1"),
        ({"assembly": ""}, "closes in more than one way: counterclockwise \\("),
        ({"assembly": "open"}, "is 'open'; this loop has counterclockwise and clockwise"),
        ({"assembly": "parallelogram"}, r"opposite bars are 0\.1 m and 0\.2 m long"),
    ],
)
def test_wrong_files_are_refused_with_the_reason(change: dict[str, str], words: str) -> None:
    with pytest.raises(DescriptionError, match=words) as caught:
        robot(four_bar(0.3, 0.1, 0.3, 0.2, **change))
    assert caught.value.line is not None


def test_surplus_active_joints_are_refused_even_where_they_agree(crank_rocker: Robot) -> None:
    """With a reference that closes the surplus equations hold there, and nowhere else."""
    closed = ", ".join(
        f"{n}: {float(v)!r}"
        for n, v in zip(crank_rocker.coordinates, crank_rocker.close([1.0]).s, strict=True)
    )
    for assembly in ("", "counterclockwise"):
        for active, count in (("q1, q2", 2), ("q1, q2, q3", 3)):
            with pytest.raises(DescriptionError, match=f"{count} joints are named, .* name 1"):
                robot(four_bar(0.3, 0.1, 0.3, 0.2, assembly, active, closed))


@pytest.mark.parametrize(("turn", "hinted"), [("1.57", True), ("1.4", False)])
def test_a_rounded_angle_is_suspected_where_ends_do_not_meet(turn: str, hinted: bool) -> None:
    """All joints lean alike.

    The loop is planar, and its ends are beside each other by what the angle is off.
    """
    text = f"""\
format: 1
name: leaning
links: {{base: {{}}, a: {{}}, b: {{}}, c: {{}}}}
joints:
  q1: {{type: revolute, parent: base, child: a, origin: {{rpy: [{turn}, 0, 0]}}, axis: z}}
  q2: {{type: revolute, parent: base, child: b, origin: {{xyz: [0.3, 0, 0.1], rpy: [{turn}, 0, 0]}}, axis: z}}
  q3: {{type: revolute, parent: a, child: c, origin: {{xyz: [0.1, 0, 0]}}, axis: z}}
loops: {{bars: {{type: A, base: base, arm: b, k1: a, k2: c, pin: {{c: [0.3, 0, 0], b: [0.2, 0, 0]}}}}}}
active: [q1]
end_effector: {{link: b}}
"""  # noqa: E501
    with pytest.raises(DescriptionError, match=r"apart along the loop's axis") as caught:
        Robot(parse_description(text))
    assert ("1.57 in place of pi/2" in str(caught.value)) == hinted


def test_the_joint_that_stands_out_is_named() -> None:
    text = """\
format: 1
name: odd
links: {base: {}, a: {}, b: {}, c: {}}
joints:
  q1: {type: revolute, parent: base, child: a, axis: z}
  q2: {type: revolute, parent: base, child: b, origin: {xyz: [0.3, 0, 0], rpy: [pi/2, 0, 0]}, axis: z}
  q3: {type: revolute, parent: b, child: c, origin: {xyz: [0.1, 0, 0]}, axis: z}
loops: {bars: {type: A, base: base, arm: a, k1: b, k2: c, pin: {c: [0.3, 0, 0], a: [0.2, 0, 0]}}}
active: [q1]
end_effector: {link: a}
"""  # noqa: E501
    with pytest.raises(
        DescriptionError, match=r"joint 'q1' does not move in the plane of 'q2' and 'q3', with axes"
    ) as caught:
        Robot(parse_description(text))
    assert "off by 1.57 rad" in str(caught.value)  # z is across -y


PLATE = """\
format: 1
name: two_loops_one_plate
links:
  {base: {}, arm: {mass: 2}, slide: {mass: 3}, plate: {mass: 1}, lever: {mass: 2}, bar: {mass: 2}}
joints:
  q: {type: revolute, parent: base, child: arm, origin: {xyz: [-0.33, 0.19, 0]}, axis: z}
  s: {type: prismatic, parent: base, child: slide, axis: x, limits: [-2, 2]}
  p: {type: revolute, parent: slide, child: plate, axis: z}
  m: {type: revolute, parent: base, child: lever, origin: {xyz: [0.6, 0.13, 0]}, axis: z}
  n: {type: revolute, parent: lever, child: bar, origin: {xyz: [0.52, 0, 0]}, axis: z}
closures:
  first: {kind: planar, between: {plate: [0.47, 0, 0], arm: [0.24, 0, 0]}}
  second: {kind: planar, between: {plate: [-0.02, -0.27, 0], bar: [0.35, 0, 0]}}
active: [s]
end_effector: {link: plate}
reference: {s: 0.08, p: -3.0502, q: -1.8151, m: -2.7341, n: -1.8428}
"""


def test_a_range_is_one_in_which_all_loops_close() -> None:
    """A plate on a slide, which two loops hold: by hand two circles each, all along the slide."""
    machine = robot(PLATE)
    places = np.linspace(-0.6, 0.8, 1401)
    status = np.asarray(machine.close(places[:, None], check=False).status)
    closed = places[status == 0]
    lower, upper = machine.closing_range[0]
    assert closed.min() - 1e-3 < lower < closed.min()
    assert closed.max() < upper < closed.max() + 1e-3
    for place in (-1.0, -0.21, 0.36, 1.0):
        with pytest.raises(ClosureError) as caught:
            machine.close([place])
        assert caught.value.allowed == pytest.approx((lower, upper), abs=1e-12)
        assert "p =" not in str(caught.value)  # it follows the slide and cannot be held
