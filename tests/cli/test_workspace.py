"""The workspace as the command prints and draws it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, load
from tests.cli.calling import call, call_line, data_of, shipped_text


def test_workspace_is_reported_and_drawn(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    maps = [tmp_path / "plane.svg", tmp_path / "joints.png"]
    words = ["workspace", "five_bar", "--samples", "2000", "--range", "q_T=0:30*deg", "--draw"]
    answer = data_of(*words, str(maps[0]))
    workspace = load("five_bar").workspace(2000, ranges={"q_T": (0.0, np.pi / 6)})
    assert list(answer["extents"].values()) == workspace.extents.tolist()
    assert answer["shares"] == {"OK": 1.0, "OPEN": 0.0, "SINGULAR": 0.0, "BEYOND": 0.0}
    assert answer["smallest_singularity"]["loop"] == "tip"
    far = answer["extremes"]["y"][1]
    assert far["position"][1] == answer["extents"]["y"][1]
    assert far["limit"] == pytest.approx(0.0, abs=1e-3)  # with both cranks at their limits
    assert far["joint"] in ("q_L", "q_R", "q_T")
    text = call_line(f"workspace five_bar --samples 500 --over q_L,q_R --draw {maps[1]}").output
    assert "reachable                 100.0 %" in text
    assert "Of the map over q_L and q_R; all other active joints are held." in text
    assert all(place.stat().st_size > 10_000 for place in maps)


def test_a_map_is_named_as_it_is_drawn(tmp_path: Path) -> None:
    """The other joints stay where the map has them, in every sample."""
    pytest.importorskip("matplotlib")
    arguments = ("workspace", "five_bar", "--samples", "500", "--over", "q_L,q_R", "-u", "q_T=0.2")
    answer = data_of(*arguments, "--plot", str(tmp_path / "map.png"))
    assert answer["held"] == {"q_T": 0.2}
    assert answer["ranges"]["q_T"] == [0.2, 0.2]
    samples = [answer["smallest_singularity"]]
    for ends in answer["extremes"].values():
        samples += ends
    assert len(samples) > 1
    assert {sample["u"]["q_T"] for sample in samples} == {0.2}
    workspace = load("five_bar").workspace(500, held={"q_T": 0.2})
    assert list(answer["extents"].values()) == workspace.extents.tolist()
    mixed = call(*arguments, "--range", "q_T=0:0.3", "--draw", str(tmp_path / "second.png"))
    assert "--held" not in mixed.output
    assert "q_T has a range too" in mixed.output


def test_nothing_to_reach_ends_with_1(tmp_path: Path) -> None:
    text = shipped_text("five_bar")
    # The reference alone is within the limits of p_L, and it is no sample.
    joint = "xyz: [crank, 0, 0]}, axis: z"
    limited = text.replace(f"{joint}}}", f"{joint}, limits: [-1.3931, -1.3925]}}", 1)
    place = tmp_path / "held.yaml"
    place.write_text(limited, encoding="utf-8")
    result = call("workspace", str(place), "--samples", "20", "--json")
    assert result.exit_code == 1
    answer = json.loads(result.stdout)
    assert answer["shares"]["BEYOND"] == 1.0
    assert answer["extremes"] == {}
    assert answer["extents"]["x"] == [None, None]
    text = call("workspace", str(place), "--samples", "20").output
    assert "beyond a limit or stroke  100.0 %" in text


def test_a_joint_may_be_held() -> None:
    answer = data_of("workspace", "five_bar", "--samples", "500", "--hold", "q_T=0.2")
    assert answer["ranges"]["q_T"] == [0.2, 0.2]
    workspace = load("five_bar").workspace(500, held={"q_T": 0.2})
    assert list(answer["extents"].values()) == workspace.extents.tolist()


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (["--hold", "q_X=0.2"], "--hold: 'q_X' is not an active joint"),
        (["--hold", "q_T=0.2", "--range", "q_T=0:0.3"], "--hold: q_T has a range too"),
        (["--hold", "q_T"], "expected NAME=VALUE"),
        (["--hold", "q_T=x"], "expected NAME=VALUE"),
        (["--over", "q_L,q_T", "--hold", "q_T=0.1"], "--hold: q_T is one of the two joints"),
    ],
)
def test_what_cannot_be_held_is_told(words: list[str], problem: str, tmp_path: Path) -> None:
    place = str(tmp_path / "map.svg")
    result = call("workspace", "five_bar", "--samples", "20", "--draw", place, *words)
    assert result.exit_code != 0
    assert problem in result.output


def test_a_map_over_two_joints_takes_those_held(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    words = ["workspace", "five_bar", "--samples", "200", "--over", "q_L,q_R", "--hold", "q_T=0.2"]
    answer = data_of(*words, "--draw", str(tmp_path / "map.png"))
    assert answer["held"] == {"q_T": 0.2}


@pytest.mark.parametrize(
    ("verb", "words"),
    [
        ("workspace", ["--samples", "20", "--draw"]),
        ("check", ["--draw"]),
        ("branches", ["--draw"]),
        ("simulate", ["--seconds", "0.01", "--plot"]),
    ],
)
def test_the_answer_stands_before_anything_is_drawn(
    verb: str, words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A picture that cannot be made takes nothing away."""
    pytest.importorskip("matplotlib")

    def fail(*_: object) -> None:
        raise InputError("no picture today")

    monkeypatch.setattr("hybrid_dynamics_core.drawing.write", fail)
    result = call(verb, "five_bar", *words, str(tmp_path / "picture.svg"))
    assert len(result.output.splitlines()) > 5
    assert "written" not in result.output
    assert "no picture today" in result.output
