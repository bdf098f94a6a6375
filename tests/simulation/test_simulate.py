"""Simulated motion: energy, loops, events."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hybrid_dynamics_core import ClosedState, InputError, Robot, load
from hybrid_dynamics_core.simulation import Settings, simulate
from tests.mechanisms import describe, mechanism
from tests.robots import random_states, robot
from tests.sampling import swept

SWINGING = (
    "forging_chu2020",
    "palletizer",
    "ankle",
    "gough",
    "serial",
    "three_rrr",
    "rssr",
    "parallelogram",
)
START = [0, 0.3, 0.1, 0]  # of the forging robot: its arm is up


def held_by_springs(machine: Robot, stiffness: list[float]) -> Settings:
    """Springs on the active joints, tensioned so that the reference is at rest."""
    n, size = len(machine.active), len(machine.coordinates)
    weight = machine.minimal_form(machine.close(machine.reference))[2]
    springs, lengths = np.zeros(size), np.zeros(size)
    springs[:n] = stiffness
    lengths[:n] = machine.reference + weight / np.array(stiffness)
    loads = machine.loads.with_effects(stiffness=springs, rest=lengths)
    return Settings(loads=loads)


@pytest.mark.sweep(sample="test_energy_changes_by_what_is_put_in")
def test_excavator_swings_for_a_minute() -> None:
    """On the springs of its oil columns: energy to 1e-6 of what swings, loops to 1e-10."""
    excavator = load("excavator")
    settings = held_by_springs(excavator, [2e5, 1.5e6, 6e5, 5e5])
    motion = simulate(
        excavator,
        excavator.reference,
        [0.3, 0.15, -0.15, 0.1],
        t_span=(0.0, 60.0),
        settings=settings,
    )
    assert motion.completed
    assert np.ptp(motion.u, axis=0).min() > 0.02  # every joint swings
    assert motion.relative_energy_error < 1e-6
    assert motion.residual < 1e-10


@pytest.mark.parametrize("name", swept(SWINGING))
def test_energy_changes_by_what_is_put_in(name: str) -> None:
    """With efforts, wrenches, friction and springs, as far as the motion goes in half a second."""
    machine = robot(name)
    start = random_states(name, regular=0.1)[0]
    size = len(machine.coordinates)
    wrench = [5.0, -3.0, 2.0, 0.1, 0.2, 0.3]
    loads = machine.loads.with_wrench(wrench).with_effects(
        viscous=np.full(size, 0.05),
        coulomb=np.full(size, 0.03),
        smoothing=np.full(size, 0.1),
        stiffness=np.ones(size),
    )
    settings = Settings(loads=loads, rate=200.0)

    def tau(t: float, state: ClosedState) -> np.ndarray:
        weight = machine.minimal_form(state, loads)[2]
        return weight + np.cos(5.0 * t + np.arange(state.n))

    motion = simulate(machine, start.u, 0.1 * start.du, tau, (0.0, 0.5), settings)
    assert motion.t[-1] > 0.05
    assert abs(motion.work[-1]) > 0.0
    assert motion.relative_energy_error < 1e-7
    assert motion.residual < 1e-10


def test_motion_runs_backward_from_its_end(forging: Robot) -> None:
    rates = [0.5, 0.1, 0.1, 1.0]
    ahead = simulate(forging, START, rates, t_span=(0.0, 0.4))
    end = float(ahead.t[-1])
    back = simulate(forging, ahead.u[-1], -ahead.du[-1], t_span=(0.0, end))
    assert back.u[-1] == pytest.approx(ahead.u[0], abs=1e-7)
    assert back.du[-1] == pytest.approx(-ahead.du[0], abs=1e-6)


@pytest.mark.parametrize("method", ["RK45", "Radau", "BDF", "LSODA"])
def test_methods_agree(method: str, forging: Robot) -> None:
    rtol = 1e-9 if method == "BDF" else 1e-8
    settings = Settings(method=method, rtol=rtol, atol=0.01 * rtol)
    rates = [0.5, 0.1, 0.1, 1.0]
    span = (0.0, 0.3)
    best = simulate(forging, START, rates, t_span=span)
    other = simulate(forging, START, rates, t_span=span, settings=settings)
    assert other.u == pytest.approx(best.u, abs=1e-6)


class TestEvents:
    def test_end_of_a_stroke_stops(self) -> None:
        excavator = load("excavator")
        motion = simulate(excavator, excavator.reference)
        (event,) = motion.events
        assert (event.kind, event.name) == ("limit", "stick_cylinder")
        assert not motion.completed
        assert "stick_cylinder reached its lower limit 0.32" in motion.message
        assert motion.t[-1] == event.time
        assert motion.u[-1, 2] == pytest.approx(0.32, abs=1e-9)
        assert (motion.u[:, 2] >= 0.32).all()

    def test_or_is_reported_and_passed(self) -> None:
        excavator = load("excavator")
        settings = Settings(stop_at_limits=False)
        span = (0.0, 0.9)
        motion = simulate(excavator, excavator.reference, t_span=span, settings=settings)
        assert motion.events[0].name == "stick_cylinder"
        assert motion.t[-1] > motion.events[0].time

    def test_toggle_stops(self, forging: Robot) -> None:
        """The paper gives no strokes: the arm falls until a cylinder lines up with its crank."""
        motion = simulate(forging, START)
        assert motion.events[-1].kind == "singular"
        assert motion.events[-1].name in ("theta_1", "theta_2")
        assert float(motion.state.singularity[-1]) == pytest.approx(0.01, abs=1e-4)
        assert motion.relative_energy_error < 1e-6

    def test_limit_passed_twice_within_a_step_is_met(self) -> None:
        """A mass on a spring swings 1e-5 beyond its limit: for 0.009 s, far less than a step."""
        rows = [("q", "prismatic", "base", "mass", (0, 0, 0), "x")]
        description = describe("spring_mass", rows, [], ["q"], {})
        description = replace(description, gravity=np.zeros(3))
        swing = 0.1
        limit = swing * (1.0 - 1e-5)
        joint = replace(description.joints["q"], limits=(-1.0, limit))
        machine = Robot(replace(description, joints={"q": joint}))
        mass = machine.minimal_form(machine.close([0.0]))[0]
        loads = machine.loads.with_effects(stiffness=[float(mass[0, 0])])  # 1 rad/s
        settings = Settings(loads=loads, rtol=1e-7)
        motion = simulate(machine, [0.0], [swing], t_span=(0.0, 20.0), settings=settings)
        assert motion.steps > 2
        assert motion.t[-1] / motion.steps > 0.1
        assert [event.name for event in motion.events] == ["q"]
        assert motion.t[-1] == pytest.approx(np.arcsin(1.0 - 1e-5), abs=1e-4)

    def test_limit_at_which_it_starts_is_not_passed(self) -> None:
        excavator = load("excavator")
        start = [0.0, 0.7, 0.32, 0.6]  # stick_cylinder at the end of its stroke
        pushed = simulate(excavator, start, t_span=(0.0, 0.2))  # by the weight of the arm
        (event,) = pushed.events
        assert pushed.t[-1] == 0.0
        assert event.name == "stick_cylinder"
        weight = excavator.minimal_form(excavator.close(start))[2]
        tau = np.add(weight, [0, 0, 500.0, 0])
        drawn = simulate(excavator, start, tau=tau, t_span=(0.0, 0.2))
        assert drawn.completed
        assert drawn.u[-1, 2] > 0.32

    def test_stroke_of_a_cylinder_counts(self) -> None:
        from hybrid_dynamics_core import HydraulicCylinder
        from tests.mechanisms import changed

        machine = mechanism("slider_crank")
        reference = float(machine.close(machine.reference).s[3])
        stroke = (reference - 0.05, reference + 0.05)
        short = HydraulicCylinder("s", 0.05, 0.03, stroke=stroke)
        machine = changed(machine, actuators={"s": short})
        motion = simulate(machine, machine.reference, [0.0, 2.0])
        assert motion.events[-1].name == "s"
        way = abs(motion.state.s[-1, 3] - reference)
        assert way == pytest.approx(0.05, abs=1e-9)


class TestEfforts:
    def test_constant_efforts_lift(self, forging: Robot) -> None:
        weight = forging.minimal_form(forging.close(START))[2]
        tau = np.add(weight, [0, 500.0, 0, 0])
        motion = simulate(forging, START, tau=tau, t_span=(0.0, 0.1))
        assert motion.du[-1, 1] > 0.0
        assert (motion.tau == motion.tau[0]).all()

    def test_held_efforts_change_once_a_period(self, forging: Robot) -> None:
        asked: list[float] = []

        def tau(t: float, state: ClosedState) -> np.ndarray:
            asked.append(t)
            return forging.minimal_form(state)[2] + 10.0 * t

        settings = Settings(hold=0.01, rate=1000.0)
        motion = simulate(forging, START, None, tau, (0.0, 0.1), settings)
        assert asked == pytest.approx(np.arange(10) * 0.01)
        assert len(np.unique(motion.tau[:, 0])) == 10
        assert motion.relative_energy_error < 1e-7

    @pytest.mark.parametrize(
        "tau",
        [[1.0, 2.0], lambda _t, _s: [1.0], lambda _t, _s: [np.nan] * 4],
    )
    def test_wrong_efforts_are_refused(self, forging: Robot, tau: object) -> None:
        with pytest.raises(InputError, match="tau"):
            simulate(forging, START, None, tau)  # type: ignore[arg-type]


class TestArguments:
    @pytest.mark.parametrize(
        ("settings", "words"),
        [
            ({"method": "Euler"}, "no method 'Euler'"),
            ({"rtol": 0.0}, "rtol is 0"),
            ({"hold": -1.0}, "hold is -1"),
        ],
    )
    def test_bad_settings(self, settings: dict, words: str) -> None:
        with pytest.raises(InputError, match=words):
            Settings(**settings)

    def test_bad_span_start_and_batch(self, forging: Robot) -> None:
        with pytest.raises(InputError, match="the second after the first"):
            simulate(forging, START, t_span=(1.0, 1.0))
        with pytest.raises(InputError, match="not from a batch"):
            simulate(forging, [[0, 0.3, 0.1, 0]])
        excavator = load("excavator")
        with pytest.raises(
            InputError, match=r"stick_cylinder = 0\.3 m starts below its limit 0\.32 m"
        ):
            simulate(excavator, [0, 0.7, 0.3, 0.6])
        with pytest.raises(InputError, match=r"starts 0\.0"):
            simulate(forging, [0, 0.69999, 0.1, 0])


class TestProgress:
    def test_nothing_where_no_one_watches(
        self, forging: Robot, capsys: pytest.CaptureFixture[str]
    ) -> None:
        simulate(forging, START, t_span=(0.0, 0.05))
        assert capsys.readouterr().err == ""

    def test_a_long_run_is_shown(
        self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        from hybrid_dynamics_core.ground import progress

        now = iter([0.0, 0.5, 2.0, 2.05, 3.0])
        monkeypatch.setattr(progress.time, "monotonic", lambda: next(now))
        with progress.Progress("running", 10.0, shown=True) as line:
            for done in (1.0, 5.0, 6.0, 10.0):
                line.update(done)
        shown = capsys.readouterr().err
        assert shown.count("\r") == 2
        assert " 50 %" in shown
        assert "100 %" in shown
        assert shown.endswith("\n")
