"""The benchmark runs and its sides agree. Nothing here looks at a time."""

from __future__ import annotations

import json
import shutil

import pytest

from benchmarks import agree, goals, run
from benchmarks.measure import Timing
from benchmarks.report import measured
from benchmarks.side import Side
from tests.sampling import swept

SIDES = ("c_extension", "c_export", "pinocchio", "mujoco", "drake", "casadi", "plain_numpy")


@pytest.mark.sweep(sample="test_every_side_that_is_installed_agrees")
def test_a_quick_report_holds_every_part(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "STAGES", (1, 2))
    found = measured(quick=True, modules=("ours", "plain_numpy", "missing"))
    text = found.text
    assert json.loads(json.dumps(found.data)) == found.data  # `hybrid-dynamics benchmark --json`
    assert found.data["seconds"]["id"]["hybrid_dynamics"] > 0.0
    for words in (
        "inverse dynamics, batch | **hybrid_dynamics",
        "plain NumPy",
        "| 2 | 6 |",
        "warm:",
        "without missing:",
    ):
        assert words in text.replace("hybrid_dynamics, no compiler", "hybrid_dynamics"), text


@pytest.mark.parametrize(
    "module",
    swept((*SIDES, "jax"), SIDES),
)
def test_every_side_that_is_installed_agrees(module: str) -> None:
    notes: list[str] = []
    robot = run.forging()
    sides = run.find_sides(robot, ("ours", module), notes.append)
    if notes:
        assert module != "c_extension" or not shutil.which("cc")
        pytest.skip(notes[0])
    agree.check(
        robot, sides, [work for work in run.WORKS if any(work in side.calls for side in sides[2:])]
    )


def test_a_side_with_other_numbers_is_found_out() -> None:
    robot = run.forging()
    ours = run.find_sides(robot, ("ours",), print)[0]
    wrong = Side("wrong", {"id": lambda *given: ours.calls["id"](*given) + 1e-5})
    with pytest.raises(agree.DisagreementError, match="wrong differs from hybrid_dynamics"):
        agree.check(robot, [ours, wrong], ["id"])


def test_goals_are_ratios() -> None:
    times = {
        "id": {
            goals.OURS: Timing(1.0, 1.0),
            goals.BY_HAND: Timing(7.0, 7.0),
            goals.FLOOR: Timing(0.5, 0.5),
        }
    }
    lines = goals.table(times)
    assert "| at least 8 times faster | 7 times faster | not reached |" in lines[2]
    assert "| at most 2 times slower | 2 times slower | reached |" in lines[3]
    assert len(lines) == 4
