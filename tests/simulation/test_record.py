"""What a simulation recorded: samples, files, pictures."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, load
from hybrid_dynamics_core.simulation import Simulation, load_simulation, simulate

from .test_simulate import START

ARRAYS = ("t", "u", "du", "ddu", "tau", "work")


@pytest.fixture(scope="module")
def motion() -> Simulation:
    """A fall of the forging robot, until a cylinder lines up with its crank."""
    return simulate(load("forging_chu2020"), START, [0.1, 0, 0, 0.5])


def legend_of(axes) -> list[str]:
    """The texts of the legend of axes."""
    _, labels = axes.get_legend_handles_labels()
    return labels


class TestRecord:
    def test_samples_are_at_the_rate_and_the_end(self, motion: Simulation) -> None:
        assert np.diff(motion.t)[:-1] == pytest.approx(0.01)
        assert motion.t[-1] == motion.events[-1].time
        shape = (len(motion.t), 4)
        assert motion.u.shape == motion.tau.shape == motion.ddu.shape == shape

    def test_accelerations_are_the_rates_of_the_rates(self, motion: Simulation) -> None:
        slope = np.gradient(motion.du[:20], motion.t[:20], axis=0, edge_order=2)
        assert slope[1:-1] == pytest.approx(motion.ddu[1:19], abs=0.05)

    def test_samples_on_one_assembly_mode_have_one_set_of_signs(self, motion: Simulation) -> None:
        assert motion.state.signs.shape == motion.state.rows(0).signs.shape

    def test_saved_and_loaded(self, motion: Simulation, tmp_path: Path) -> None:
        path = tmp_path / "fall.npz"
        motion.save(path)
        loaded = load_simulation(path)
        assert [p.name for p in tmp_path.iterdir()] == ["fall.npz"]
        for name in ARRAYS:
            assert np.array_equal(getattr(loaded, name), getattr(motion, name))
        assert np.array_equal(loaded.state.s, motion.state.s)
        assert loaded.events == motion.events
        for name in (
            "message",
            "robot",
            "names",
            "coordinates",
            "completed",
            "steps",
            "evaluations",
        ):
            assert getattr(loaded, name) == getattr(motion, name)
        assert dict(loaded.state.branch) == dict(motion.state.branch)
        assert np.array_equal(loaded.energy.total, motion.energy.total)

    def test_what_the_former_format_saved_is_read(self, motion: Simulation, tmp_path: Path) -> None:
        motion.save(tmp_path / "fall.npz")
        with np.load(tmp_path / "fall.npz") as file:
            arrays = dict(file)
        former = {"time": "t", "acceleration": "ddu", "effort": "tau"}
        head = json.loads(str(arrays.pop("head")))
        text = json.dumps(head | {"format": 2})
        old = {former.get(name, name): values for name, values in arrays.items()}
        np.savez(tmp_path / "old.npz", head=np.array(text), **old)
        loaded = load_simulation(tmp_path / "old.npz")
        for name in ARRAYS:
            assert np.array_equal(getattr(loaded, name), getattr(motion, name))

    def test_saved_as_a_table(self, motion: Simulation, tmp_path: Path) -> None:
        motion.save(tmp_path / "fall.csv")
        assert [p.name for p in tmp_path.iterdir()] == ["fall.csv"]
        rows = np.genfromtxt(
            tmp_path / "fall.csv",
            delimiter=",",
            names=True,
            deletechars="",
        )
        assert np.array_equal(rows["time"], motion.t)
        assert np.array_equal(rows["q12.effort"], motion.tau[:, 1])
        q3 = motion.coordinates.index("q3")
        assert np.array_equal(rows["q3.velocity"], motion.state.ds[:, q3])
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
        """As all pictures: a title, what is shown, joints named, axes for each kind of unit."""
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
        revolute = {name for name in motion.names if machine.joint_types[name] == "revolute"}
        assert set(legend_of(figure.axes[0])) == revolute
        assert set(legend_of(figure.axes[1])) == set(motion.names) - revolute
        text = (tmp_path / "fall.svg").read_text(encoding="utf-8")
        for words in (*motion.names, motion.message, "simulated motion"):
            assert words in text
        draw_simulation(machine, motion, tmp_path / "fall.pdf")
        assert (tmp_path / "fall.pdf").read_bytes().startswith(b"%PDF")
        with pytest.raises(InputError, match=r"not as '\.xls'"):
            draw_simulation(machine, motion, tmp_path / "fall.xls")
        with pytest.raises(InputError, match="the active joints of five_bar are"):
            draw_simulation(load("five_bar"), motion)

    def test_a_curve_that_others_would_hide_has_further_axes(
        self, motion: Simulation, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """Of two lengths one is a hundredth of the other: it has further axes. Zeros need none."""
        pytest.importorskip("matplotlib")
        from hybrid_dynamics_core.drawing import draw_simulation

        machine = load(motion.robot)
        figures = []
        for values in ([1.0, 0.5, 0.4, 1.0], [0.0, 0.5, 0.005, 0.0]):
            shown = np.tile(values, (len(motion.t), 1))
            monkeypatch.setattr(Simulation, "u", property(lambda _, shown=shown: shown))
            figures.append(draw_simulation(machine, motion))
        alike, apart = figures
        assert len(apart.axes) == len(alike.axes) + 1
        assert apart.get_figheight() > alike.get_figheight() + 1.0
        small = next(ax for ax in apart.axes if legend_of(ax) == ["q22"])
        assert small.get_ylabel() == "u [m]"

    def test_rounding_is_a_straight_line_and_no_exponent_stands_on_a_legend(
        self, motion: Simulation
    ) -> None:
        """A torque of rounding is zero beside the weight; millions of N are in full."""
        pytest.importorskip("matplotlib")
        from hybrid_dynamics_core.drawing import draw_simulation

        machine = load(motion.robot)
        count = len(motion.t)
        tau = np.tile([0.0, 2.5e6, 1.5e6, 0.0], (count, 1))
        tau[:, 0] = 1e-16 * np.random.default_rng(1).standard_normal(count)
        figure = draw_simulation(machine, replace(motion, tau=tau))
        figure.draw_without_rendering()
        turning, pushing = (ax for ax in figure.axes if ax.get_ylabel().startswith("tau"))
        low, high = turning.get_ylim()
        assert low < -0.01 < 0.01 < high  # 1e-9 of the weight at the robot's length is far less
        for ax in figure.axes:
            assert ax.yaxis.get_offset_text().get_text() == ""
        assert "2,000,000" in [text.get_text() for text in pushing.get_yticklabels()]
