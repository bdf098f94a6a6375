"""Every example runs, and what it shows is true."""

from __future__ import annotations

import re
import runpy
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hybrid_dynamics_core import load
from tests.sampling import swept

FOLDER = Path(__file__).parents[2] / "examples"
PRINTS = {  # the script, and what its output has to say
    "excavator_digging": "boom: cap side up to",
    "palletizer_level_wrist": "the hand turns by",
    "ankle_torque_mapping": "the motors need",
    "forging_computed_torque": "computed torque, billet known",
    "staicu_path": "leg F: travels",
    "identify_from_bag": "base parameters are within their 95 % intervals",
    "boom_cylinder_design": "the force is off its mean by",
    "delta_workspace": "least distance: 0.582 before",
    "four_bars": "dyads through five poses: 4",
    "forging_redesign": "largest force of q22: 5578 N before",
    "excavator_stiffness": "the bucket drops by",
    "mpc_batch": "plan, full model",
    "excavator_mpc": "off the goal at the end",
    "weighing_bucket": "with an empty run:",
    "calibrating_excavator": "reduced chi-squared",
    "forging_design_map": "40000 designs",
    "palletizer_tolerances": "likely error (95 %): up to",
    "tilting_excavator": "teeth of the bucket:",
    "as_fast_as_the_pump_allows": "limited by",
    "flywheel_through_dead_centres": "dead centres and",
}
SAMPLE = ("excavator_digging", "palletizer_level_wrist")  # of which each run draws the figures


def run(script: str, name: str = "example") -> dict[str, Any]:
    return runpy.run_path(str(FOLDER / f"{script}.py"), run_name=name)


def test_every_example_is_named_here() -> None:
    assert {path.stem for path in FOLDER.glob("*.py")} == set(PRINTS)


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The figures that are written."""
    pytest.importorskip("matplotlib")
    from hybrid_dynamics_core.drawing import page

    figures: list[Any] = []
    save = page.save

    def note(figure: Any, path: Path) -> None:
        figures.append(figure)
        save(figure, path)

    monkeypatch.setattr(page, "save", note)
    return figures


def check_style(figure: Any) -> None:
    """A figure in the project's style: titles, names with units, colours, keys beside curves."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    FigureCanvasAgg(figure).draw()  # in pixels of the screen, not of the file
    title, about = figure.texts[:2]
    assert (title.get_fontsize(), title.get_weight()) == (12, "bold")
    assert about.get_text()
    colours = project_colours()
    for axes in figure.axes:
        check_axes(axes, colours)
        keys = [key for key in (axes.get_legend(), *figure.legends) if key is not None]
        assert keys
        for key in keys:
            assert not key.get_window_extent().overlaps(axes.patch.get_window_extent())
        names = (axes.title, axes._left_title, axes.xaxis.label, axes.yaxis.label)
        for text in (*names, title, about):
            check_inside(text.get_window_extent(), figure.bbox)


def project_colours() -> set[str]:
    from hybrid_dynamics_core.scene import style

    values = [getattr(style, name) for name in dir(style) if name.isupper()]
    return {value for value in values if isinstance(value, str)}


def check_axes(axes: Any, colours: set[str]) -> None:
    """A title, names with units, and lines in the project's colours."""
    from matplotlib.colors import to_hex

    assert axes.get_title(loc="left")
    names = [axes.get_ylabel()]
    if axes.get_subplotspec().is_last_row():
        names.append(axes.get_xlabel())
    for name in names:
        assert re.search(r"\[[^]]+\]|^number of|^run$|, in half intervals$", name), name
    assert not axes.spines["top"].get_visible()
    assert {to_hex(line.get_color()) for line in axes.lines} <= colours


def check_inside(box: Any, page: Any) -> None:
    """Nothing runs out of the page."""
    assert -1.0 <= box.x0 <= box.x1 <= page.x1 + 1.0
    assert -1.0 <= box.y0 <= box.y1 <= page.y1 + 1.0


@pytest.mark.parametrize(
    "script", swept([name for name in PRINTS if name != "identify_from_bag"], SAMPLE)
)
def test_examples_print_and_draw(
    script: str, drawn: list[Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    place = tmp_path / "figure.png"
    if script == "excavator_mpc":
        pytest.importorskip("casadi")
    monkeypatch.setattr(sys, "argv", [script, "--plot", str(place)])
    run(script, name="__main__")
    assert PRINTS[script] in capsys.readouterr().out
    assert place.read_bytes().startswith(b"\x89PNG")
    (figure,) = drawn
    check_style(figure)


def test_the_designed_cylinder_is_level_within_its_stroke_and_pressure() -> None:
    example = run("boom_cylinder_design")
    design, result = example["designed"](starts=1)
    assert result.feasible
    assert result.objective < 0.2 * float(example["unevenness"](design.cycle()).value)
    cycle = design.cycle(list(result.values.values()))
    strokes = cycle.coordinate("boom_cylinder").value
    assert 0.05 - 1e-6 <= strokes.min() <= strokes.max() <= 1.15 + 1e-6
    assert cycle.pressure("boom_cylinder").value.max() <= 14e6 * (1.0 + 1e-6)
    name = "loops.boom_loop.pin.boom[0]"
    pin = result.robot.description.closures[0]
    assert result.values[name] in (*pin.point_a, *pin.point_b)


def test_the_forging_robots_new_pins_take_less_force_within_their_strokes() -> None:
    example = run("forging_redesign")
    design = example["problem"](points=6)
    result = example["solve"](design)
    assert result.feasible
    cycle = design.cycle(list(result.values.values()))
    before, after = (example["largest_forces"](one) for one in (design.cycle(), cycle))
    assert max(np.divide(after, before)) == pytest.approx(result.objective, rel=1e-6)
    assert result.objective < 0.65
    assert example["strokes"](cycle).value.min() > -1e-6
    assert np.allclose(cycle.position().value, design.cycle().position().value, atol=1e-9)


def test_the_bucket_drops_by_its_parts_and_swings_slower_farther_out() -> None:
    example = run("excavator_stiffness")
    reach, drops, lowest = example["reached"](load("excavator"))
    assert (np.diff(reach) > 0.0).all()
    total = sum(drops.values())
    assert total[-1] > 1.5 * total[0]
    assert lowest[-1, 0] < lowest[0, 0]


def test_the_four_bar_through_five_poses_is_the_one_that_gave_them() -> None:
    example = run("four_bars")
    first, second = example["guided"]()[:2]
    assert np.allclose(first.fixed, 0.0, atol=1e-8)
    assert np.allclose(second.fixed, (1.0, 0.0), atol=1e-8)
    assert (first.length, second.length) == pytest.approx((0.4, 0.8))


def test_excavator_pressures_are_positive_and_below_the_supply() -> None:
    example = run("excavator_digging")
    result = example["cycle"]()
    cylinders = load("excavator").cylinders
    supply = np.array([one.supply_pressure for one in cylinders.values()])
    for side in ("cap_pressure", "rod_pressure"):
        assert (result[side] >= 0.0).all()
        assert (result[side] < supply).all()
    assert (result["to_lower"] > 0.0).all()
    assert (result["to_upper"] > 0.0).all()
    areas = np.array([[one.cap_area, one.rod_area] for one in cylinders.values()])
    push = result["cap_pressure"] * areas[:, 0] - result["rod_pressure"] * areas[:, 1]
    assert push == pytest.approx(result["force"], rel=1e-12, abs=1e-6)
    digging = (result["t"] > 3.3) & (result["t"] < 4.7)
    assert (result["tip"][digging, 2] < 0.0).all()  # the teeth are in the ground
    assert result["cap_pressure"][digging, 1].min() > 3e6  # and the stick pulls them


def test_filling_the_bucket_is_linear_in_its_load() -> None:
    """Half a bucket in one evaluation is the mean of empty and full."""
    example = run("excavator_digging")
    robot = load("excavator")
    state = robot.close([0.3, 0.5, 0.8, 0.6], [0.2, 0.1, 0.1, 0.1])
    ddu = [0.5, 0.1, -0.2, 0.3]
    earth = example["EARTH"]
    half = type(earth)(0.5 * earth.mass, com=earth.com)
    empty = robot.inverse_dynamics(state, ddu)
    partly = robot.inverse_dynamics(state, ddu, robot.loads.with_payload(half))
    full = robot.inverse_dynamics(state, ddu, robot.loads.with_payload(earth))
    assert partly == pytest.approx(0.5 * (empty + full), rel=1e-12)


def test_the_palletizer_keeps_its_wrist_level() -> None:
    result = run("palletizer_level_wrist")["carry"]()
    assert result["tilt"].max() < 1e-12
    assert np.abs(result["turn"]).max() < 1e-8  # as near as inverse kinematics solves
    assert result["error"].max() < 1e-9
    assert np.ptp(result["forearm"]) > 0.3  # it is no matter of course: the forearm turns
    assert len(result["points"]) == 61


def test_ankle_torques_do_the_same_power_on_both_sides() -> None:
    example = run("ankle_torque_mapping")
    pitches = np.radians([-30.0, -10.0, 20.0])
    result = example["push_off"](pitches)
    assert result["motor_power"] == pytest.approx(result["foot_power"], rel=1e-12)
    assert np.abs(result["foot_power"]).min() > 10.0
    h = 1e-6
    slopes = []  # d(q_L, q_R)/d pitch, by differences
    for pitch in pitches:
        ahead = load("ankle").close_given({"pitch": pitch + h, "roll": 0.0}).u
        behind = load("ankle").close_given({"pitch": pitch - h, "roll": 0.0}).u
        slopes.append((ahead - behind) / (2 * h))
    inverse = np.linalg.inv(result["jacobian"])
    assert inverse[:, :, 0] == pytest.approx(np.array(slopes), abs=1e-7)  # h^2 and rounding / h
    corners = example["available"](result["jacobian"][1])
    torques = corners @ result["jacobian"][1]  # J^T m, of the motors
    assert np.abs(torques) == pytest.approx(np.full((5, 2), example["LARGEST"]), rel=1e-12)


def test_computed_torque_dies_out_as_its_gains_say() -> None:
    example = run("forging_computed_torque")
    with_load, without_load, springs = example["follow"]().values()
    errors = example["errors"]
    t = with_load.t
    root = 20.0
    wanted = 0.01 * (1.0 + root * t) * np.exp(-root * t)  # [m]: a double root
    # Efforts are held for 4 ms: half of it at 0.15 m/s.
    assert errors(with_load)[:, 1] == pytest.approx(wanted, abs=4e-4)
    assert np.abs(errors(with_load)[-1]).max() < 1e-6
    assert np.abs(errors(without_load)[-1, 1:3]).max() > 5e-3
    assert np.abs(errors(springs)[-1, 1:3]).max() > 3e-3
    assert with_load.completed


def test_staicus_robot_tracks_its_path() -> None:
    example = run("staicu_path")
    result = example["follow"](13)
    assert np.abs(result["from_legs"] - result["wanted"]).max() < 1e-10
    for t, speeds in zip(result["t"].tolist(), result["speeds"], strict=True):
        _, rates = example["pose"](t)
        wanted = [rates.get(name, 0.0) for name in example["POSE"]]
        assert np.abs(speeds - wanted).max() < 1e-10
    assert result["legs"][0] == pytest.approx(result["legs"][-1], abs=1e-12)  # a closed path
    assert result["singularity"].min() > 0.1


def test_a_bag_tells_what_the_robot_weighs(
    drawn: list[Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    pytest.importorskip("rosbags")
    bag = tmp_path / "recording"
    figure = tmp_path / "figure.png"
    words = ["identify_from_bag", "--bag", str(bag), "--plot", str(figure)]
    monkeypatch.setattr(sys, "argv", words)
    example = run("identify_from_bag", name="__main__")
    assert PRINTS["identify_from_bag"] in capsys.readouterr().out
    assert figure.read_bytes().startswith(b"\x89PNG")
    check_style(drawn[0])
    result = example["identified"](bag)
    truth = example["truth"](result)
    low, high = result.identification.interval.T
    assert ((low <= truth) & (truth <= high)).mean() > 0.85
    assert result.residual == pytest.approx(5.0, rel=0.1)  # that of the recorded efforts
    assert result.file_residual[2] > 100.0  # the file alone explains them much worse
    from_file = example["base_parameters"](result, load("forging_chu2020"))
    outside = (from_file < low) | (high < from_file)
    assert outside.sum() >= 3  # the bag shows that the file is wrong


def test_a_step_of_mpc_gains_within_its_limits() -> None:
    example = run("mpc_batch")
    result = example["solve"]()
    assert (result["cost"] < 0.5 * result["cost_held"]).all()
    assert (np.abs(result["efforts"]) <= example["LIMITS"] * (1.0 + 1e-9)).all()
    assert result["cost"] == pytest.approx(result["cost_predicted"], rel=0.1)  # hardly nonlinear
    assert np.abs(result["efforts"] / example["LIMITS"]).max() > 0.99  # the limits do bind


@pytest.mark.parametrize("plans", swept([12, 100], sample=[12]))
def test_an_excavator_under_predictive_control_keeps_all_limits_between_samples(plans: int) -> None:
    pytest.importorskip("casadi")
    example = run("excavator_mpc")
    motion = example["run"]("real-time", plans)
    machine = example["machine"]()
    states = machine.close(motion["u"], motion["du"])  # at each millisecond
    margins = machine.limit_margins(states, tau=motion["tau"])
    kinds = {row.kind for row in margins.rows}
    assert {"position", "rate", "pressure", "pump_flow", "effort"} <= kinds
    assert not margins.beyond
    shares = example["use"](motion)
    for name in ("rates", "flow", "efforts"):
        assert shares[name].max() < 1.0
    assert max(shares["flow"].max(), shares["efforts"].max()) > 0.9  # the limits do bind
    if plans == 100:
        assert np.abs(motion["u"][-1] - example["GOAL"]).max() < 0.01  # and the goal is reached


def test_the_linearised_step_is_that_of_the_full_model() -> None:
    """From a state at rest a small change of efforts moves both alike, to second order."""
    example = run("mpc_batch")
    robot = load("forging_chu2020")
    x = example["starts"](4)
    _, Bd, _ = example["linearised"](robot, x)
    state = robot.close(x[:, :4], x[:, 4:])
    tau = robot.inverse_dynamics(state, np.zeros((4, 4)))
    push = 1e-3 * example["LIMITS"]
    more = example["rolled"](robot, x, (tau + push)[None])[1]
    less = example["rolled"](robot, x, (tau - push)[None])[1]
    linear = np.einsum("nij,j->ni", Bd, push)
    tolerance = 2e-3 * np.abs(linear).max()  # A changes over the step
    assert 0.5 * (more - less) == pytest.approx(linear, rel=0.02, abs=tolerance)
