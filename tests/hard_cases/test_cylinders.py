"""Cylinders at the toggle, dead centres, and pins that pass through their foot."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import ClosureError, DescriptionError, Robot, SingularityError
from tests.hard_cases.linkages import HEAD, cylinder, robot

DISTANCE, RADIUS = 0.5, 0.2


@pytest.fixture(scope="module")
def lift() -> Robot:
    return robot(cylinder(DISTANCE, RADIUS))


class TestToggle:
    def test_range_is_between_the_toggle_points(self, lift: Robot) -> None:
        assert lift.closing_range[0] == pytest.approx(
            [DISTANCE - RADIUS, DISTANCE + RADIUS], abs=1e-12
        )

    @pytest.mark.parametrize("edge", [DISTANCE - RADIUS, DISTANCE + RADIUS])
    def test_toggle_is_singular_and_beyond_is_out_of_reach(self, lift: Robot, edge: float) -> None:
        outward = np.sign(edge - DISTANCE)
        with pytest.raises(SingularityError) as singular:
            lift.close([edge])
        assert singular.value.distance < 1e-5
        with pytest.raises(ClosureError) as beyond:
            lift.close([edge + 1e-6 * outward])
        assert (beyond.value.loop, beyond.value.coordinate) == ("lift", "stroke")
        assert beyond.value.allowed == pytest.approx(
            (DISTANCE - RADIUS, DISTANCE + RADIUS), abs=1e-12
        )

    @pytest.mark.parametrize("left", [1e-2, 1e-4, 1e-6])
    def test_distance_goes_with_the_root_of_the_stroke_left(self, lift: Robot, left: float) -> None:
        """Closed directly and followed from mid-stroke alike.

        The lever stands off the line by the law of cosines.
        """
        stroke = DISTANCE + RADIUS - left
        angle = np.arccos((stroke**2 - DISTANCE**2 - RADIUS**2) / (2 * DISTANCE * RADIUS))
        for state in (lift.close([stroke]), lift.close([stroke], near=lift.close([DISTANCE]))):
            lever = state.s[lift.coordinates.index("lever")]
            assert abs(lever) == pytest.approx(angle, rel=1e-6)
            assert float(state.singularity) == pytest.approx(np.sqrt(left), rel=0.7)
        speed = lift.close([stroke], [1.0]).ds[lift.coordinates.index("lever")]
        assert abs(speed) == pytest.approx(stroke / (DISTANCE * RADIUS * np.sin(angle)), rel=1e-6)

    def test_stroke_beyond_the_toggle_and_back_keeps_its_branch(self, lift: Robot) -> None:
        """A path that leaves the range is refused at its first row outside.

        Rows before it are on the branch.
        """
        u = DISTANCE + RADIUS * np.sin(np.linspace(0.0, np.pi, 21)) * 1.001
        with pytest.raises(ClosureError) as caught:
            lift.close_path(u[:, None])
        assert caught.value.index == 10
        there_and_back = DISTANCE + RADIUS * np.sin(np.linspace(0.0, np.pi, 21)) * 0.999
        path = lift.close_path(there_and_back[:, None])
        assert path.s[-1] == pytest.approx(path.s[0], abs=1e-12)

    def test_batch_tells_row_by_row(self, lift: Robot) -> None:
        u = np.array([0.5, 0.7, 0.71, 0.6, 0.3])[:, None]
        state = lift.close(u, check=False)
        assert [int(s) for s in state.status[[0, 2, 3]]] == [0, 1, 0]
        assert np.all(
            state.status[[1, 4]] != 0
        )  # at the toggle itself, rounding decides whether it is still reached
        assert np.isnan(state.s[1:3]).all()
        assert state.s[3] == pytest.approx(lift.close([0.6]).s, abs=1e-13)

    def test_driven_by_the_lever_the_toggle_is_regular(self) -> None:
        """The stroke is then extreme.

        Its rate is zero, its acceleration is -R (D + R) / D w^2 and so on.
        """
        crank = robot(cylinder(DISTANCE, RADIUS, active="lever", assembly="extended"))
        stroke = crank.coordinates.index("stroke")
        top = crank.close([0.0], [2.0])
        assert top.s[stroke] == pytest.approx(DISTANCE + RADIUS, abs=1e-15)
        assert top.ds[stroke] == pytest.approx(0.0, abs=1e-15)
        expected = -DISTANCE * RADIUS / (DISTANCE + RADIUS) * 2.0**2
        assert crank.accelerations(top, [0.0])[stroke] == pytest.approx(expected, rel=1e-12)
        assert float(top.singularity) > 0.5
        turns = crank.close_path(np.linspace(0.0, 6 * np.pi, 60)[:, None])
        assert np.ptp(turns.s[:, stroke]) == pytest.approx(2 * RADIUS, rel=1e-2)


class TestPinThroughTheFoot:
    """Lever as long as the foot is far.

    At half a turn the pin stands on the foot and the cylinder has no direction.
    """

    def test_it_is_singular(self) -> None:
        crank = robot(cylinder(RADIUS, RADIUS, active="lever", assembly="extended"))
        with pytest.raises(SingularityError):
            crank.close([np.pi])
        assert crank.close([np.pi - 1e-3]).s[crank.coordinates.index("stroke")] == pytest.approx(
            2e-4, rel=1e-3
        )

    def test_no_step_passes_it(self) -> None:
        """Beyond it the cylinder would have to turn about at once."""
        crank = robot(cylinder(RADIUS, RADIUS, active="lever", assembly="extended"))
        for start, end in ((2.5, 4.0), (3.1, 3.2), (2.0, 6.0), (3.0, 3.5), (3.9, 2.2)):
            with pytest.raises(SingularityError, match="toggle or change point"):
                crank.close([end], near=crank.close([start]))

    def test_lever_without_length_is_refused(self) -> None:
        with pytest.raises(DescriptionError, match=r"loops\.lift: does not close"):
            robot(cylinder(DISTANCE, 0.0))


SLIDER = (
    HEAD
    + "links: {base: {}, crank: {mass: 1}, rod: {mass: 1}, slider: {mass: 1}}\njoints:\n  turn:"
    " {type: revolute, parent: base, child: crank, axis: z}\n  swing: {type: revolute, parent:"
    " crank, child: rod, origin: {xyz: [0.1, 0, 0]}, axis: z}\n  slide: {type: prismatic, parent:"
    " base, child: slider, axis: x}\nloops:\n  engine: {type: A, base: base, arm: slider, k1:"
    " crank, k2: rod, pin: {rod: [0.3, 0, 0], slider: [0, 0, 0]}}\nactive:"
    " [ACTIVE]\nend_effector: {link: slider}\nreference: {turn: 1, swing: -1.28, slide: 0.34}\n"
)


class TestSliderCrank:
    def test_dead_centres_are_singular_driven_by_the_slider_only(self) -> None:
        by_slider, by_crank = (robot(SLIDER.replace("ACTIVE", name)) for name in ("slide", "turn"))
        assert by_slider.closing_range[0] == pytest.approx([0.2, 0.4], abs=1e-12)
        for dead, u in ((0.4, 0.0), (0.2, np.pi)):
            with pytest.raises(SingularityError):
                by_slider.close([dead])
            state = by_crank.close([u], [1.0])
            slide = by_crank.coordinates.index("slide")
            assert state.s[slide] == pytest.approx(dead, abs=1e-15)
            assert state.ds[slide] == pytest.approx(0.0, abs=1e-15)

    def test_crank_turns_through_dead_centres(self) -> None:
        engine = robot(SLIDER.replace("ACTIVE", "turn"))
        u = np.linspace(0.0, 8 * np.pi, 120)
        path = engine.close_path(u[:, None])
        slide = path.s[:, engine.coordinates.index("slide")]
        assert slide == pytest.approx(
            0.1 * np.cos(u) + np.sqrt(0.3**2 - (0.1 * np.sin(u)) ** 2), abs=1e-13
        )
