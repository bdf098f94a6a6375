"""`hybrid-dynamics tolerances`."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hybrid_dynamics_core.kernels.run import VARIABLE
from hybrid_dynamics_core.tolerances import ToleranceAnalysis
from tests.cli.calling import call
from tests.tolerances.linkages import SLIDER_CRANK, robot

TABLE = "crank=0.01*mm, rod=0.02*mm uniform"


@pytest.fixture(name="file")
def robot_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setenv(VARIABLE, "python")
    place = tmp_path / "slider_crank.yaml"
    place.write_text(SLIDER_CRANK, encoding="utf-8")
    return str(place)


def test_the_command_prints_what_python_gives(file: str, tmp_path: Path) -> None:
    listed = tmp_path / "table.txt"
    listed.write_text("closures.small_end.play = 0.01*mm  # the pin\n", encoding="utf-8")
    words = ["tolerances", file, "--tolerance", TABLE, "--table", str(listed), "-u", "0.8"]
    result = call(*words, "--monte-carlo", "100", "--json")
    assert result.exit_code == 0, result.output
    data = json.loads(result.output)
    table = {"crank": 1e-5, "rod": "0.02*mm uniform", "closures.small_end.play": 1e-5}
    linear = ToleranceAnalysis(robot(SLIDER_CRANK), table).linear([0.8])
    assert data["position"]["likely"] == pytest.approx(linear.likely[0], rel=1e-9)
    assert data["position"]["worst"] == pytest.approx(linear.worst[0], rel=1e-9)
    shares = {name: one["share"] for name, one in data["variables"].items()}
    assert shares == pytest.approx(dict(linear.shares), rel=1e-9)
    assert data["tighten_first"] == max(shares, key=shares.__getitem__) == "rod"
    assert data["monte_carlo"]["robots"] == 100
    text = call(*words)
    assert "likely (95 %)" in text.output
    assert "small_end.play" in text.output


@pytest.mark.parametrize(
    ("words", "part"),
    [
        ([], "give --tolerance PATH=VALUE"),
        (["--tolerance", "crank"], "expected PATH=VALUE"),
        (["--tolerance", "crnak=0.1*mm"], "did you mean 'crank'"),
        (["--tolerance", "crank=0.1*mm,crank=0.2*mm"], "given twice"),
        (["--tolerance", "crank=-0.1*mm"], "zero or more"),
        (["--tolerance", "crank=0.1*mm", "-u", "0.8", "--poses", "3"], "leave out -u"),
        (["--tolerance", "crank=0.1*mm", "--range", "trun=0:1"], "did you mean 'turn'"),
        (["--table", "none.txt"], "none.txt: cannot be read"),
        (["--table", "."], ".: cannot be read"),
    ],
)
def test_a_wrong_call_gets_one_line(file: str, words: list[str], part: str) -> None:
    result = call("tolerances", file, *words)
    assert result.exit_code in (1, 2)
    assert part in result.output
    assert "Traceback" not in result.output


def test_a_pose_beyond_limits_is_noted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "python")
    place = tmp_path / "limited.yaml"
    text = SLIDER_CRANK.replace("turn: {", "turn: {limits: [0, 1], ", 1)
    place.write_text(text, encoding="utf-8")
    result = call("tolerances", str(place), "--tolerance", TABLE, "-u", "1.2")
    assert result.exit_code == 0
    assert "turn = 1.2 rad is beyond its limit 1 rad" in result.stderr
