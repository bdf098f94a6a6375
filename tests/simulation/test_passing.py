"""Simulated motions through change points and dead centres.

The references are closed forms, and Lagrange's equation in the crank's angle, which is smooth where
the slide turns back. They use nothing of the library.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from benchmarks.problems.four_bars import four_bars
from benchmarks.problems.references import four_bars as four_bar_reference
from hybrid_dynamics_core import InputError, Robot
from hybrid_dynamics_core.closed_state.state import ClosedState, ClosureStatus
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.simulation import Settings, Simulation, load_simulation, simulate
from tests.hard_cases.linkages import robot
from tests.hard_cases.test_change_points import (
    Bars,
    change_point_bars,
    folds_once,
    turned_off,
)
from tests.sampling import examples

GRAVITY = 9.81
STEP = 1e-30  # of complex differentiation: no difference is taken


def through(**changes: object) -> Settings:
    return Settings(through_change_points=True, progress=False, **changes)  # type: ignore[arg-type]


def general_row(count: int) -> Robot:
    """The row of four-bars of the benchmark, whose loops are not named parallelograms."""
    text = four_bars(count).replace(", assembly: parallelogram", "")
    joints = [f"a{k}: 0.3" for k in range(count + 1)]
    joints += [f"b{k + 1}: -0.3" for k in range(count)]
    return Robot(parse_description(text.replace("{a0: 0}", f"{{{', '.join(joints)}}}")))


def tip(motion: Simulation) -> Array:
    """Rows (x, y, x', y') of the first crank's tip."""
    u, du = motion.u[:, 0], motion.du[:, 0]
    return np.column_stack([-np.sin(u), np.cos(u), -np.cos(u) * du, -np.sin(u) * du])


class TestRowOfFourBars:
    """A02 of the IFToMM library: all loops fold at once, twice a turn."""

    @pytest.mark.parametrize("count", [1, 3])
    def test_it_goes_round_as_the_reference(self, count: int) -> None:
        row = general_row(count)
        motion = simulate(row, [0.0], [-1.0], None, (0.0, 6.0), through(rate=20.0))
        assert motion.completed
        # rtol 1e-9, grown along six seconds of an unstable start
        assert tip(motion) == pytest.approx(four_bar_reference(motion.t, count), abs=1e-5)
        assert np.abs(motion.energy_error).max() < 1e-5
        passages = [event.passage for event in motion.events]
        assert len(passages) >= 5
        places = [passage.s[0] for passage in passages if passage]
        assert np.cos(places) == pytest.approx(np.zeros(len(places)), abs=1e-9)
        assert motion.state.passages == tuple(passages)

    @pytest.mark.sweep(sample="test_it_goes_round_as_the_reference")
    def test_ten_and_forty_too(self) -> None:
        for count in (10, 40):
            motion = simulate(
                general_row(count), [0.0], [-1.0], None, (0.0, 3.0), through(rate=20.0)
            )
            expected = four_bar_reference(motion.t, count)
            assert tip(motion) == pytest.approx(expected, abs=1e-4)
            assert len(motion.events[0].passage.loops) == count  # type: ignore[union-attr]

    def test_a_passage_takes_some_tens_of_steps(self) -> None:
        """Beside the same motion of loops that are regular there."""
        span = (0.0, 6.0)
        motion = simulate(general_row(1), [0.0], [-1.0], None, span, through())
        named = Robot(parse_description(four_bars(1)))
        regular = simulate(named, [0.0], [-1.0], None, span, Settings(progress=False))
        more = motion.steps - regular.steps
        assert 0 <= more <= 25 * len(motion.events)

    @pytest.mark.parametrize(
        "changes",
        [
            {"rtol": 1e-6, "atol": 1e-8},
            {"rtol": 1e-11, "atol": 1e-13},
            {"max_step": 0.003},
            {"hold": 0.01},
            {"singular": 0.002},
            {"singular": 0.03},
            {"method": "RK45"},
            {"method": "Radau"},
        ],
    )
    def test_the_branch_depends_on_no_step(self, changes: dict[str, object]) -> None:
        motion = simulate(
            general_row(2), [0.0], [-1.0], None, (0.0, 1.5), through(rate=20.0, **changes)
        )
        ways = np.array([1.0, 1.0, 1.0, -1.0, -1.0])
        assert motion.completed
        assert motion.state.s == pytest.approx(motion.u * ways, abs=1e-8)
        assert len(motion.events) == 2

    def test_back_in_time_it_returns(self) -> None:
        row = general_row(1)
        there = simulate(row, [0.0], [-1.0], None, (0.0, 2.0), through())
        last = there.state.rows(-1)
        turned = row.close(last.u, -last.du, near=last)
        back = simulate(row, turned, None, None, (0.0, 2.0), through())
        assert len(back.events) == len(there.events)
        assert back.u[-1] == pytest.approx(there.u[0], abs=1e-6)
        assert back.du[-1] == pytest.approx(-there.du[0], abs=1e-6)

    def test_without_the_word_it_ends(self) -> None:
        motion = simulate(general_row(1), [0.0], [-1.0], None, (0.0, 2.0))
        assert not motion.completed
        (event,) = motion.events
        assert (event.kind, event.passage) == ("singular", None)
        assert motion.state.singularity[-1] == pytest.approx(0.01, abs=1e-6)


class TestChangePointFourBars:
    @examples(12)
    @given(change_point_bars().filter(folds_once), st.sampled_from([-1.0, 1.0]))
    def test_motion_stays_on_its_branch_with_its_energy(self, bars: Bars, side: float) -> None:
        """With a flywheel on the crank it goes past the fold."""
        start = bars.flat - 0.8
        machine = bars.robot(start, side)
        wheel = machine.loads.with_effects(armature=[0.5, 0.0, 0.0])
        motion = simulate(
            machine, [start], [4.0], None, (0.0, 0.5), through(rate=40.0, loads=wheel)
        )
        assert motion.completed
        assert motion.events[0].passage is not None
        expected = bars.angles(motion.u[:, 0], side)
        assert np.abs(turned_off(motion.state.s, expected)).max() < 1e-8
        assert motion.relative_energy_error < 1e-7


@dataclass(frozen=True)
class SliderCrank:
    """A slider-crank with a flywheel; the slide is offset, has a spring, and is active."""

    crank: float = 0.1
    rod: float = 0.25
    offset: float = 0.0
    stiffness: float = 0.0
    wheel: float = 0.02

    def rod_angle(self, angle: Array) -> tuple[Array, Array]:
        """Sine and cosine of the rod's angle, complex angles too."""
        sine = (self.offset - self.crank * np.sin(angle)) / self.rod
        if self.rod == self.crank:  # the root of a square, which goes through zero
            return sine, np.cos(angle)
        return sine, np.sqrt(1.0 - sine**2)

    def place(self, angle: Array) -> Array:
        """Place of the slider."""
        return self.crank * np.cos(angle) + self.rod * self.rod_angle(angle)[1]

    def energies(self, angle: Array) -> tuple[Array, Array]:
        """Inertia as the crank feels it [kg m^2], and potential energy [J]."""
        place = self.place(angle)
        sine, cosine = self.rod_angle(angle)
        turning = -self.crank * np.cos(angle) / (self.rod * cosine)
        slide = -self.crank * np.sin(angle) - self.rod * sine * turning
        across = 0.5 * (-self.crank * np.sin(angle) + slide)
        along = 0.5 * self.crank * np.cos(angle)
        inertia = self.wheel + 1.0 * (0.5 * self.crank) ** 2
        inertia += 0.3 * (across**2 + along**2 + self.rod**2 / 12.0 * turning**2) + 0.5 * slide**2
        height = 0.5 * self.crank * np.sin(angle)
        height += 0.3 * 0.5 * (self.crank * np.sin(angle) + self.offset)
        return inertia, GRAVITY * height + 0.5 * self.stiffness * (place - 0.2) ** 2

    def reference(self, t: Array, start: float, rate: float, force: float = 0.0) -> Array:
        """Rows (angle, rate) by Lagrange's equation in the crank's angle."""

        def slope(_: float, y: Array) -> list[float]:
            inertia, potential = self.energies(y[0] + 1j * STEP)
            place = self.place(y[0] + 1j * STEP)
            push = 0.5 * inertia.imag * y[1] ** 2 + potential.imag - force * place.imag
            return [y[1], -push / STEP / inertia.real]

        y0, span = (start, rate), (t[0], t[-1])
        answer = solve_ivp(slope, span, y0, "DOP853", t_eval=t, rtol=1e-13, atol=1e-13)
        return np.asarray(answer.y.T)

    def robot(self, start: float) -> Robot:
        place = self.place(np.array(start))
        swing = float(np.arcsin(self.rod_angle(np.array(start))[0])) - start
        spring = f"spring: {{stiffness: {self.stiffness!r}, rest: 0.2}}"
        thin = 0.3 * self.rod**2 / 12.0
        return Robot(
            parse_description(f"""
format: 1
name: slider_crank
gravity: [0, {-GRAVITY!r}, 0]
links:
  base: {{}}
  crank: {{mass: 1, com: [{0.5 * self.crank!r}, 0, 0],
    inertia: {{xx: {self.wheel!r}, yy: {self.wheel!r}, zz: {self.wheel!r}}}}}
  rod: {{mass: 0.3, com: [{0.5 * self.rod!r}, 0, 0],
    inertia: {{xx: 0, yy: {thin!r}, zz: {thin!r}}}}}
  slider: {{mass: 0.5}}
joints:
  slide: {{type: prismatic, parent: base, child: slider, axis: x,
    origin: {{xyz: [0, {self.offset!r}, 0]}}, {spring}}}
  turn: {{type: revolute, parent: base, child: crank, axis: z}}
  swing: {{type: revolute, parent: crank, child: rod, axis: z,
    origin: {{xyz: [{self.crank!r}, 0, 0]}}}}
closures:
  pin: {{kind: planar, between: {{rod: [{self.rod!r}, 0, 0], slider: [0, 0, 0]}}}}
active: [slide]
end_effector: {{link: slider}}
reference: {{turn: {start!r}, swing: {swing!r}, slide: {float(place)!r}}}
""")
        )


def started(machine: Robot, rate: float) -> ClosedState:
    """The reference, with a rate of the crank [rad/s]."""
    state = machine.close(machine.reference)
    return machine.close(state.u, [rate / state.R[1, 0]])


class TestSliderCrank:
    """Driven in the slide: u turns back where crank and rod are in line."""

    def assert_as_reference(
        self, sizes: SliderCrank, rate: float, force: float, tolerance: float
    ) -> Simulation:
        machine = sizes.robot(0.7)
        motion = simulate(
            machine,
            started(machine, rate),
            None,
            [force],
            (0.0, 1.2),
            through(rtol=1e-10, atol=1e-12),
        )
        assert motion.completed, motion.message
        expected = sizes.reference(motion.t, 0.7, rate, force)
        assert motion.state.s[:, 1] == pytest.approx(expected[:, 0], abs=tolerance)
        assert motion.state.ds[:, 1] == pytest.approx(expected[:, 1], abs=10 * tolerance)
        place = sizes.place(expected[:, 0])
        assert motion.u[:, 0] == pytest.approx(place, abs=tolerance)
        return motion

    @pytest.mark.parametrize(
        "sizes",
        [
            SliderCrank(),
            SliderCrank(offset=0.03),
            SliderCrank(offset=0.03, stiffness=200.0),
            SliderCrank(rod=0.1),
        ],
    )
    def test_it_turns_as_lagrange_says(self, sizes: SliderCrank) -> None:
        """With rods of equal lengths the loop also folds, with the slide in the middle."""
        motion = self.assert_as_reference(sizes, 9.0, 2.0, 1e-7)
        kinds = {event.passage.kind for event in motion.events if event.passage}
        assert kinds == ({"toggle", "change point"} if sizes.rod == sizes.crank else {"toggle"})
        assert np.abs(motion.energy_error).max() < 1e-7

    @examples(12)
    @given(
        st.floats(0.05, 0.2),
        st.floats(1.2, 4.0),
        st.floats(-0.5, 0.5),
        st.floats(0.0, 300.0),
        st.sampled_from([-12.0, 12.0]),
    )
    def test_random_ones_too(
        self, crank: float, ratio: float, share: float, stiffness: float, rate: float
    ) -> None:
        rod = crank * ratio
        sizes = SliderCrank(crank, rod, share * (rod - crank), stiffness)
        self.assert_as_reference(sizes, rate, 0.0, 1e-6)

    def test_events_tell_the_place_and_the_modes(self) -> None:
        sizes = SliderCrank()
        machine = sizes.robot(0.7)
        motion = simulate(machine, started(machine, 9.0), None, None, (0.0, 1.0), through())
        for event in motion.events:
            passage = event.passage
            assert passage is not None
            assert event.kind == "passage"
            assert event.name == "pin"
            assert event.message == passage.message
            assert passage.s[1] % np.pi == pytest.approx(0.0, abs=1e-6) or passage.s[
                1
            ] % np.pi == pytest.approx(np.pi, abs=1e-6)
            assert passage.rates[0] == pytest.approx(0.0, abs=1e-6)
            assert passage.rates[1] > 1.0
            assert passage.other_rates == ()
            assert passage.before != passage.after
        assert motion.events[1].passage.before == motion.events[0].passage.after  # type: ignore[union-attr]

    def test_a_sample_at_the_dead_centre_has_its_motion_and_no_r(self) -> None:
        machine = SliderCrank().robot(0.7)
        start = started(machine, 9.0)
        first = simulate(machine, start, None, None, (0.0, 0.5), through()).events[0].time
        motion = simulate(machine, start, None, None, (0.0, 2 * first), through(rate=1.0 / first))
        place = motion.state.rows(1)
        assert place.status is ClosureStatus.SINGULAR
        assert np.isnan(place.R).all()
        assert place.ds[0] == pytest.approx(0.0, abs=1e-5)
        assert place.ds[1] > 1.0
        assert np.isfinite(motion.ddu).all()
        assert motion.ddu[1, 0] > 1.0  # the slide turns back: finite, by the other coordinates
        assert np.isnan(machine.inverse_dynamics(motion.state, motion.ddu)[1]).all()

    def test_efforts_are_asked_on_the_way(self) -> None:
        """A damper as a function of the slide's rate is the same as friction of the joint."""
        machine = SliderCrank(offset=0.02).robot(0.7)
        start = started(machine, 12.0)

        def damper(_time: float, state: ClosedState) -> Array:
            return -2.0 * state.du

        span = (0.0, 0.8)
        asked = simulate(machine, start, None, damper, span, through())
        damped = machine.loads.with_effects(viscous=[2.0, 0.0, 0.0])
        rubbed = simulate(machine, start, None, None, span, through(loads=damped))
        assert len(asked.events) > 1
        assert asked.state.s == pytest.approx(rubbed.state.s, abs=1e-7)
        assert asked.work == pytest.approx(rubbed.work, abs=1e-7)
        assert asked.tau[:, 0] == pytest.approx(-2.0 * asked.du[:, 0], abs=1e-9)

    def test_it_starts_beside_a_dead_centre(self) -> None:
        machine = SliderCrank().robot(0.7)
        beside = machine.close_given({"turn": 1e-3}, {"turn": -9.0})
        with pytest.raises(InputError, match="singular configuration"):
            simulate(machine, beside, None, None, (0.0, 0.3))
        motion = simulate(machine, beside, None, None, (0.0, 0.3), through())
        assert motion.completed
        assert len(motion.events) == 1

    def test_without_a_flywheel_that_carries_it_through_it_turns_back(self) -> None:
        """Let go near the dead centre below, it swings about the lowest place."""
        machine = SliderCrank(wheel=0.001).robot(-0.7)
        motion = simulate(
            machine, machine.close(machine.reference), None, None, (0.0, 2.0), through()
        )
        assert motion.completed
        assert motion.relative_energy_error < 1e-7

    def test_the_record_is_saved_with_its_passages(self, tmp_path: Path) -> None:
        machine = SliderCrank().robot(0.7)
        motion = simulate(machine, started(machine, 9.0), None, None, (0.0, 0.4), through())
        motion.save(tmp_path / "motion.npz")
        again = load_simulation(tmp_path / "motion.npz")
        assert again.events == motion.events
        assert again.state.s == pytest.approx(motion.state.s)

    def test_without_the_word_it_ends(self) -> None:
        machine = SliderCrank().robot(0.7)
        motion = simulate(machine, started(machine, 9.0), None, None, (0.0, 1.0))
        assert not motion.completed
        assert motion.events[-1].kind == "singular"


def test_robots_with_ball_joints_are_refused() -> None:
    text = """
format: 1
name: swinging
links: {base: {}, bob: {mass: 1, com: [0, 0, -1], inertia: {xx: 0.1, yy: 0.1, zz: 0.1}}}
joints: {socket: {type: ball, parent: base, child: bob}}
active: [socket]
end_effector: {link: bob}
"""
    bob = robot(text)
    with pytest.raises(InputError, match="ball"):
        simulate(bob, bob.reference, None, None, (0.0, 0.1), through())


def test_two_freedoms_pass_where_the_bars_of_a_five_bar_are_in_line() -> None:
    """The tip runs past the reach of one mode: both cranks turn, and their bars stretch."""
    text = (Path("hybrid_dynamics_core") / "robots" / "five_bar.yaml").read_text()
    changes = {
        "half: 0.06": "half: 0.1",
        ", limits: [1.45, 2.6]": "",
        ", limits: [0.54, 1.69]": "",
        "p_L: -1.393, p_R: 1.393": "p_L: -1.5, p_R: 1.5",
    }
    for old, new in changes.items():
        text = text.replace(old, new)
    machine = robot(text)
    motion = simulate(machine, machine.reference, [3.0, -3.0, 0.0], None, (0.0, 0.5), through())
    assert motion.events[0].passage is not None
    assert motion.relative_energy_error < 1e-7
