"""Simulated motion: energy, loops, events, recording."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import ClosedState, InputError, Robot, load
from hybrid_dynamics_core.simulation import Settings, Simulation, load_simulation, simulate
from tests.mechanisms import describe, mechanism
from tests.robots import random_states, robot

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


def held_by_springs(machine: Robot, stiffness: list[float]) -> Settings:
    """Springs on the active joints, tensioned so that the reference is at rest."""
    n, size = len(machine.active), len(machine.coordinates)
    weight = machine.minimal_form(machine.close(machine.reference))[2]
    springs, rest = np.zeros(size), np.zeros(size)
    springs[:n] = stiffness
    rest[:n] = machine.reference + weight / np.array(stiffness)
    return Settings(loads=machine.loads.with_effects(stiffness=springs, rest=rest))


@pytest.mark.slow
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


@pytest.mark.parametrize("name", SWINGING)
def test_energy_changes_by_what_is_put_in(name: str) -> None:
    """With efforts, wrenches, friction and springs, as far as the motion goes in half a second."""
    machine = robot(name)
    start = random_states(name, regular=0.1)[0]
    size = len(machine.coordinates)
    loads = machine.loads.with_wrench([5.0, -3.0, 2.0, 0.1, 0.2, 0.3]).with_effects(
        viscous=np.full(size, 0.05),
        coulomb=np.full(size, 0.03),
        smoothing=np.full(size, 0.1),
        stiffness=np.ones(size),
    )
    settings = Settings(loads=loads, rate=200.0)

    def tau(t: float, state: ClosedState) -> np.ndarray:
        return machine.minimal_form(state, loads)[2] + np.cos(5.0 * t + np.arange(state.n))

    motion = simulate(machine, start.u, 0.1 * start.du, tau, (0.0, 0.5), settings)
    assert motion.t[-1] > 0.05
    assert abs(motion.work[-1]) > 0.0
    assert motion.relative_energy_error < 1e-7
    assert motion.residual < 1e-10


def test_motion_runs_backward_from_its_end(forging: Robot) -> None:
    ahead = simulate(forging, [0, 0.3, 0.1, 0], [0.5, 0.1, 0.1, 1.0], t_span=(0.0, 0.4))
    back = simulate(forging, ahead.u[-1], -ahead.du[-1], t_span=(0.0, float(ahead.t[-1])))
    assert back.u[-1] == pytest.approx(ahead.u[0], abs=1e-7)
    assert back.du[-1] == pytest.approx(-ahead.du[0], abs=1e-6)


@pytest.mark.parametrize("method", ["RK45", "Radau", "BDF", "LSODA"])
def test_methods_agree(method: str, forging: Robot) -> None:
    tight = {"rtol": 1e-8, "atol": 1e-10} if method != "BDF" else {"rtol": 1e-9, "atol": 1e-11}
    start = ([0, 0.3, 0.1, 0], [0.5, 0.1, 0.1, 1.0])
    best = simulate(forging, *start, t_span=(0.0, 0.3))
    other = simulate(forging, *start, t_span=(0.0, 0.3), settings=Settings(method=method, **tight))
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

    def test_or_is_told_and_passed(self) -> None:
        excavator = load("excavator")
        settings = Settings(stop_at_limits=False)
        motion = simulate(excavator, excavator.reference, t_span=(0.0, 0.9), settings=settings)
        assert [event.name for event in motion.events][:1] == ["stick_cylinder"]
        assert motion.t[-1] > motion.events[0].time

    def test_toggle_stops(self, forging: Robot) -> None:
        """The paper gives no strokes: the arm falls until a cylinder lines up with its crank."""
        motion = simulate(forging, [0, 0.3, 0.1, 0])
        assert motion.events[-1].kind == "singular"
        assert motion.events[-1].name in ("theta_1", "theta_2")
        assert float(motion.state.singularity[-1]) == pytest.approx(0.01, abs=1e-4)
        assert motion.relative_energy_error < 1e-6

    def test_limit_passed_and_left_again_within_a_step_is_met(self) -> None:
        """A mass on a spring whose limit is 1e-5 short of its swing.

        Beyond it for 0.009 s, far less than a step.
        """
        rows = [("q", "prismatic", "base", "mass", (0, 0, 0), "x")]
        description = replace(describe("spring_mass", rows, [], ["q"], {}), gravity=np.zeros(3))
        swing = 0.1
        joint = replace(description.joints["q"], limits=(-1.0, swing * (1.0 - 1e-5)))
        machine = Robot(replace(description, joints={"q": joint}))
        stiffness = float(machine.minimal_form(machine.close([0.0]))[0][0, 0])  # 1 rad/s
        settings = Settings(loads=machine.loads.with_effects(stiffness=[stiffness]), rtol=1e-7)
        motion = simulate(machine, [0.0], [swing], t_span=(0.0, 20.0), settings=settings)
        assert motion.steps > 2
        assert motion.t[-1] / motion.steps > 0.1
        assert [event.name for event in motion.events] == ["q"]
        assert motion.t[-1] == pytest.approx(np.arcsin(1.0 - 1e-5), abs=1e-4)

    def test_limit_at_which_it_starts_is_not_passed(self) -> None:
        excavator = load("excavator")
        start = [0.0, 0.7, 0.32, 0.6]  # stick_cylinder at the end of its stroke
        pushed = simulate(excavator, start, t_span=(0.0, 0.2))  # by the weight of the arm
        assert (pushed.t[-1], [event.name for event in pushed.events]) == (0.0, ["stick_cylinder"])
        weight = excavator.minimal_form(excavator.close(start))[2]
        drawn = simulate(excavator, start, tau=np.add(weight, [0, 0, 500.0, 0]), t_span=(0.0, 0.2))
        assert drawn.completed
        assert drawn.u[-1, 2] > 0.32

    def test_stroke_of_a_cylinder_counts(self) -> None:
        from hybrid_dynamics_core import HydraulicCylinder
        from tests.mechanisms import changed

        machine = mechanism("slider_crank")
        reference = float(machine.close(machine.reference).s[3])
        short = HydraulicCylinder("s", 0.05, 0.03, stroke=(reference - 0.05, reference + 0.05))
        machine = changed(machine, actuators={"s": short})
        motion = simulate(machine, machine.reference, [0.0, 2.0])
        assert motion.events[-1].name == "s"
        assert abs(motion.state.s[-1, 3] - reference) == pytest.approx(0.05, abs=1e-9)


class TestEfforts:
    def test_constant_efforts_lift(self, forging: Robot) -> None:
        weight = forging.minimal_form(forging.close([0, 0.3, 0.1, 0]))[2]
        motion = simulate(
            forging, [0, 0.3, 0.1, 0], tau=np.add(weight, [0, 500.0, 0, 0]), t_span=(0.0, 0.1)
        )
        assert motion.du[-1, 1] > 0.0
        assert (motion.tau == motion.tau[0]).all()

    def test_held_efforts_change_once_a_period(self, forging: Robot) -> None:
        asked: list[float] = []

        def tau(t: float, state: ClosedState) -> np.ndarray:
            asked.append(t)
            return forging.minimal_form(state)[2] + 10.0 * t

        motion = simulate(
            forging, [0, 0.3, 0.1, 0], None, tau, (0.0, 0.1), Settings(hold=0.01, rate=1000.0)
        )
        assert asked == pytest.approx(np.arange(10) * 0.01)
        assert len(np.unique(motion.tau[:, 0])) == 10
        assert motion.relative_energy_error < 1e-7

    @pytest.mark.parametrize("tau", [[1.0, 2.0], lambda _t, _s: [1.0], lambda _t, _s: [np.nan] * 4])
    def test_wrong_efforts_are_refused(self, forging: Robot, tau: object) -> None:
        with pytest.raises(InputError, match="tau"):
            simulate(forging, [0, 0.3, 0.1, 0], None, tau)  # type: ignore[arg-type]


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
            simulate(forging, [0, 0.3, 0.1, 0], t_span=(1.0, 1.0))
        with pytest.raises(InputError, match="not from a batch"):
            simulate(forging, [[0, 0.3, 0.1, 0]])
        excavator = load("excavator")
        with pytest.raises(
            InputError, match=r"stick_cylinder = 0\.3 m starts below its limit 0\.32 m"
        ):
            simulate(excavator, [0, 0.7, 0.3, 0.6])
        with pytest.raises(InputError, match=r"starts 0\.0"):
            simulate(forging, [0, 0.69999, 0.1, 0])


@pytest.fixture(scope="module")
def motion() -> Simulation:
    """A fall of the forging robot, until a cylinder lines up with its crank."""
    return simulate(load("forging_chu2020"), [0, 0.3, 0.1, 0], [0.1, 0, 0, 0.5])


class TestRecord:
    def test_samples_are_at_the_rate_and_the_end(self, motion: Simulation) -> None:
        assert np.diff(motion.t)[:-1] == pytest.approx(0.01)
        assert motion.t[-1] == motion.events[-1].time
        assert motion.u.shape == motion.tau.shape == motion.ddu.shape == (len(motion.t), 4)

    def test_accelerations_are_the_rates_of_the_rates(self, motion: Simulation) -> None:
        slope = np.gradient(motion.du[:20], motion.t[:20], axis=0, edge_order=2)
        assert slope[1:-1] == pytest.approx(motion.ddu[1:19], abs=0.05)

    def test_saved_and_read_again(self, motion: Simulation, tmp_path: Path) -> None:
        path = tmp_path / "fall.npz"
        motion.save(path)
        again = load_simulation(path)
        assert [p.name for p in tmp_path.iterdir()] == ["fall.npz"]
        for name in ("t", "u", "du", "ddu", "tau", "work"):
            assert np.array_equal(getattr(again, name), getattr(motion, name))
        assert np.array_equal(again.state.s, motion.state.s)
        assert again.events == motion.events
        for name in (
            "message",
            "robot",
            "names",
            "coordinates",
            "completed",
            "steps",
            "evaluations",
        ):
            assert getattr(again, name) == getattr(motion, name)
        assert dict(again.state.branch) == dict(motion.state.branch)
        assert np.array_equal(again.energy.total, motion.energy.total)

    def test_what_the_former_format_saved_is_read(self, motion: Simulation, tmp_path: Path) -> None:
        motion.save(tmp_path / "fall.npz")
        with np.load(tmp_path / "fall.npz") as file:
            arrays = dict(file)
        former = {"time": "t", "acceleration": "ddu", "effort": "tau"}
        head = json.dumps(json.loads(str(arrays.pop("head"))) | {"format": 2})
        old = {former.get(name, name): values for name, values in arrays.items()}
        np.savez(tmp_path / "old.npz", head=np.array(head), **old)
        again = load_simulation(tmp_path / "old.npz")
        for name in ("t", "u", "du", "ddu", "tau", "work"):
            assert np.array_equal(getattr(again, name), getattr(motion, name))

    def test_saved_as_a_table(self, motion: Simulation, tmp_path: Path) -> None:
        motion.save(tmp_path / "fall.csv")
        assert [p.name for p in tmp_path.iterdir()] == ["fall.csv"]
        rows = np.genfromtxt(tmp_path / "fall.csv", delimiter=",", names=True, deletechars="")
        assert np.array_equal(rows["time"], motion.t)
        assert np.array_equal(rows["q12.effort"], motion.tau[:, 1])
        assert np.array_equal(
            rows["q3.velocity"], motion.state.ds[:, motion.coordinates.index("q3")]
        )
        assert np.array_equal(rows["q22.acceleration"], motion.ddu[:, 2])
        assert np.array_equal(rows["energy.kinetic"], motion.energy.kinetic)
        assert len(rows.dtype.names or ()) == 1 + 12 + 12 + 4 + 4 + 3 + 1
        with pytest.raises(InputError, match=r"ends in '.xls'; expected .npz or .csv"):
            motion.save(tmp_path / "fall.xls")

    def test_other_files_are_refused(self, tmp_path: Path) -> None:
        np.savez(tmp_path / "other.npz", x=np.zeros(3))
        (tmp_path / "text.npz").write_text("no")
        for name in ("other.npz", "text.npz", "missing.npz"):
            with pytest.raises(InputError, match="not a saved simulation"):
                load_simulation(tmp_path / name)

    def test_picture(self, motion: Simulation, tmp_path: Path) -> None:
        """In the look of all pictures.

        A title, what is shown, every joint named, axes for each kind of unit.
        """
        pytest.importorskip("matplotlib")
        from hybrid_dynamics_core.drawing import draw_simulation

        machine = load(motion.robot)
        figure = draw_simulation(machine, motion, tmp_path / "fall.svg")
        assert [ax.get_ylabel() for ax in figure.axes] == [
            "u [rad]",
            "u [m]",
            "u' [rad/s]",
            "u' [m/s]",
            "tau [N m]",
            "tau [N]",
            "energy [J]",
        ]
        own = {name for name in motion.names if machine.joint_types[name] == "revolute"}
        assert set(figure.axes[0].get_legend_handles_labels()[1]) == own
        assert set(figure.axes[1].get_legend_handles_labels()[1]) == set(motion.names) - own
        text = (tmp_path / "fall.svg").read_text(encoding="utf-8")
        assert all(words in text for words in (*motion.names, motion.message, "simulated motion"))
        draw_simulation(machine, motion, tmp_path / "fall.pdf")
        assert (tmp_path / "fall.pdf").read_bytes().startswith(b"%PDF")
        with pytest.raises(InputError, match=r"not as '\.xls'"):
            draw_simulation(machine, motion, tmp_path / "fall.xls")
        with pytest.raises(InputError, match="the active joints of five_bar are"):
            draw_simulation(load("five_bar"), motion)

    def test_a_curve_that_others_would_hide_has_axes_of_its_own(
        self, motion: Simulation, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """Of two lengths one is a hundredth of the other, and the picture is higher for it.

        Zeros are seen anywhere.
        """
        pytest.importorskip("matplotlib")
        from hybrid_dynamics_core.drawing import draw_simulation

        machine = load(motion.robot)
        figures = []
        for values in ([1.0, 0.5, 0.4, 1.0], [0.0, 0.5, 0.005, 0.0]):
            told = np.tile(values, (len(motion.t), 1))
            monkeypatch.setattr(Simulation, "u", property(lambda _, told=told: told))
            figures.append(draw_simulation(machine, motion))
        alike, apart = figures
        assert len(apart.axes) == len(alike.axes) + 1
        assert apart.get_figheight() > alike.get_figheight() + 1.0
        small = next(ax for ax in apart.axes if ax.get_legend_handles_labels()[1] == ["q22"])
        assert small.get_ylabel() == "u [m]"

    def test_rounding_is_a_straight_line_and_no_exponent_stands_on_a_legend(
        self, motion: Simulation
    ) -> None:
        """A torque of rounding is zero beside the weight of the robot.

        Millions of N have their numbers in full.
        """
        pytest.importorskip("matplotlib")
        from hybrid_dynamics_core.drawing import draw_simulation

        machine = load(motion.robot)
        tau = np.tile([0.0, 2.5e6, 1.5e6, 0.0], (len(motion.t), 1))
        tau[:, 0] = 1e-16 * np.random.default_rng(1).standard_normal(len(motion.t))
        figure = draw_simulation(machine, replace(motion, tau=tau))
        figure.draw_without_rendering()
        turning, pushing = (ax for ax in figure.axes if ax.get_ylabel().startswith("tau"))
        low, high = turning.get_ylim()
        assert low < -0.01 < 0.01 < high  # 1e-9 of the weight at the robot's length is far less
        assert all(ax.yaxis.get_offset_text().get_text() == "" for ax in figure.axes)
        assert "2,000,000" in [text.get_text() for text in pushing.get_yticklabels()]


class TestProgress:
    def test_nothing_where_no_one_watches(
        self, forging: Robot, capsys: pytest.CaptureFixture[str]
    ) -> None:
        simulate(forging, [0, 0.3, 0.1, 0], t_span=(0.0, 0.05))
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
