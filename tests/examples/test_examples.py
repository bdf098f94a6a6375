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

FOLDER = Path(__file__).parents[2] / "examples"
PRINTS = {  # the script, and what its output has to say
    "excavator_digging": "boom: cap side up to",
    "palletizer_level_wrist": "the hand turns by",
    "ankle_torque_mapping": "the motors need",
    "forging_computed_torque": "computed torque, billet known",
    "staicu_path": "leg F: travels",
    "identify_from_bag": "base parameters are within their 95 % intervals",
    "mpc_batch": "plan, full model",
}


def run(script: str, name: str = "example") -> dict[str, Any]:
    return runpy.run_path(str(FOLDER / f"{script}.py"), run_name=name)


def test_every_example_is_told_here() -> None:
    assert {path.stem for path in FOLDER.glob("*.py")} == set(PRINTS)


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The figures that are written."""
    pytest.importorskip("matplotlib")
    from hybrid_dynamics_core.drawing import page

    figures: list[Any] = []
    save = page.save
    monkeypatch.setattr(
        page, "save", lambda figure, path: (figures.append(figure), save(figure, path))
    )
    return figures


def check_look(figure: Any) -> None:
    """A title in the project's look, axes with titles, names and units, colours of the project, keys beside curves."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.colors import to_hex

    from hybrid_dynamics_core.scene import style

    ours = {
        getattr(style, name)
        for name in dir(style)
        if name.isupper() and isinstance(getattr(style, name), str)
    }
    FigureCanvasAgg(figure).draw()  # in pixels of the screen, not of the file
    title, about = figure.texts[:2]
    assert (title.get_fontsize(), title.get_weight()) == (12, "bold")
    assert about.get_text()
    for axes in figure.axes:
        assert axes.get_title(loc="left")
        below = axes.get_xlabel() if axes.get_subplotspec().is_last_row() else "t [s]"
        for name in (below, axes.get_ylabel()):
            assert re.search(r"\[[^]]+\]|^number of|, in half intervals$", name), name
        assert not axes.spines["top"].get_visible()
        assert {to_hex(line.get_color()) for line in axes.lines} <= ours
        keys = [key for key in (axes.get_legend(), *figure.legends) if key is not None]
        assert keys
        for key in keys:
            assert not key.get_window_extent().overlaps(axes.patch.get_window_extent())
        for text in (
            axes.title,
            axes._left_title,
            axes.xaxis.label,
            axes.yaxis.label,
            title,
            about,
        ):
            box = text.get_window_extent()
            assert -1.0 <= box.x0 <= box.x1 <= figure.bbox.x1 + 1.0  # nothing runs out of the page
            assert -1.0 <= box.y0 <= box.y1 <= figure.bbox.y1 + 1.0


@pytest.mark.parametrize("script", [name for name in PRINTS if name != "identify_from_bag"])
def test_examples_print_and_draw(
    script: str, drawn: list[Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    place = tmp_path / "figure.png"
    monkeypatch.setattr(sys, "argv", [script, "--plot", str(place)])
    run(script, name="__main__")
    assert PRINTS[script] in capsys.readouterr().out
    assert place.read_bytes().startswith(b"\x89PNG")
    (figure,) = drawn
    check_look(figure)


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
    state, ddu = robot.close([0.3, 0.5, 0.8, 0.6], [0.2, 0.1, 0.1, 0.1]), [0.5, 0.1, -0.2, 0.3]
    earth = example["EARTH"]
    half = type(earth)(0.5 * earth.mass, com=earth.com)
    empty, partly, full = (
        robot.inverse_dynamics(state, ddu, loads)
        for loads in (robot.loads, robot.loads.with_payload(half), robot.loads.with_payload(earth))
    )
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
    near = [
        load("ankle").close_given({"pitch": p + s * h, "roll": 0.0}).u
        for p in pitches
        for s in (-1, 1)
    ]
    cranks = np.diff(np.array(near).reshape(3, 2, 2), axis=1)[:, 0] / (
        2 * h
    )  # d(q_L, q_R)/d pitch, by differences
    assert np.linalg.inv(result["jacobian"])[:, :, 0] == pytest.approx(
        cranks, abs=1e-7
    )  # h^2 and rounding / h
    corners = example["available"](result["jacobian"][1])
    back = corners @ result["jacobian"][1]  # J^T m: motor torques
    assert np.abs(back) == pytest.approx(np.full((5, 2), example["LARGEST"]), rel=1e-12)


def test_computed_torque_dies_out_as_its_gains_say() -> None:
    example = run("forging_computed_torque")
    known, unknown, springs = example["follow"]().values()
    errors = example["errors"]
    t, root = known.t, 20.0
    wanted = 0.01 * (1.0 + root * t) * np.exp(-root * t)  # [m]: a double root
    assert errors(known)[:, 1] == pytest.approx(
        wanted, abs=4e-4
    )  # efforts are held for 4 ms: half of it at 0.15 m/s
    assert np.abs(errors(known)[-1]).max() < 1e-6
    assert np.abs(errors(unknown)[-1, 1:3]).max() > 5e-3
    assert np.abs(errors(springs)[-1, 1:3]).max() > 3e-3
    assert known.completed


def test_staicus_robot_tracks_its_path() -> None:
    example = run("staicu_path")
    result = example["follow"](13)
    assert np.abs(result["from_legs"] - result["wanted"]).max() < 1e-10
    rates = np.array(
        [
            [example["pose"](float(t))[1].get(name, 0.0) for name in example["POSE"]]
            for t in result["t"]
        ]
    )
    assert np.abs(result["speeds"] - rates).max() < 1e-10
    assert result["legs"][0] == pytest.approx(result["legs"][-1], abs=1e-12)  # a closed path
    assert result["singularity"].min() > 0.1


def test_a_bag_tells_what_the_robot_weighs(
    drawn: list[Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    pytest.importorskip("rosbags")
    bag, figure = tmp_path / "recording", tmp_path / "figure.png"
    monkeypatch.setattr(
        sys, "argv", ["identify_from_bag", "--bag", str(bag), "--plot", str(figure)]
    )
    example = run("identify_from_bag", name="__main__")
    assert PRINTS["identify_from_bag"] in capsys.readouterr().out
    assert figure.read_bytes().startswith(b"\x89PNG")
    check_look(drawn[0])
    found = example["identified"](bag)
    truth, interval = example["truth"](found), found.result.interval
    assert ((truth >= interval[:, 0]) & (truth <= interval[:, 1])).mean() > 0.85
    assert found.noise == pytest.approx(
        5.0, rel=0.1
    )  # nothing but the noise of the efforts is left
    assert found.before[2] > 100.0  # the file alone leaves much more
    described = found.result.base
    told = described.values(described.parameters.values(load("forging_chu2020").description))
    outside = (told < interval[:, 0]) | (told > interval[:, 1])
    assert outside.sum() >= 3  # that the file is wrong can be seen


def test_a_step_of_mpc_gains_within_its_limits() -> None:
    example = run("mpc_batch")
    result = example["solve"]()
    assert (result["cost"] < 0.5 * result["cost_held"]).all()
    assert (np.abs(result["efforts"]) <= example["LIMITS"] * (1.0 + 1e-9)).all()
    assert result["cost"] == pytest.approx(
        result["cost_predicted"], rel=0.1
    )  # so far the motion is linear
    assert np.abs(result["efforts"] / example["LIMITS"]).max() > 0.99  # the limits do bind


def test_the_linearised_step_is_that_of_the_full_model() -> None:
    """From a state that holds, a small change of the efforts moves both by the same, to second order."""
    example = run("mpc_batch")
    robot, x = load("forging_chu2020"), example["starts"](4)
    _, Bd, _ = example["linearised"](robot, x)
    state = robot.close(x[:, :4], x[:, 4:])
    tau = robot.inverse_dynamics(state, np.zeros((4, 4)))
    push = 1e-3 * example["LIMITS"]
    ends = [example["rolled"](robot, x, (tau + s * push)[None])[1] for s in (-1.0, 1.0)]
    slope = 0.5 * (ends[1] - ends[0])
    linear = np.einsum("nij,j->ni", Bd, push)
    assert slope == pytest.approx(
        linear, rel=0.02, abs=2e-3 * np.abs(linear).max()
    )  # A changes over the step
