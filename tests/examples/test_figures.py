"""The papers' figures: numbers of every curve against the reference values, and written files."""

from __future__ import annotations

import runpy
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.published.test_forging_chu2020 import REFERENCE as CHU
from tests.published.test_forging_chu2020 import close_to
from tests.published.test_staicu2015 import REFERENCE as STAICU
from tests.published.test_staicu2015 import TOLERANCE
from tests.sampling import swept

mpl = pytest.importorskip("matplotlib")
FOLDER = Path(__file__).parents[2] / "examples" / "figures"
TITLES = {"chu2020": "Chu et al. (2020)", "staicu2015": "Staicu (2015)"}
SCRIPTS = sorted(path.stem for path in FOLDER.glob("*_figure_*.py"))
SAMPLE = ("chu2020_figure_10", "staicu2015_figure_5")  # that are written each time
STAICU_FIGURES = {
    5: ("ABC", 0),
    6: ("DEF", 0),
    7: ("ABC", 1),
    8: ("DEF", 1),
    9: ("ABC", 2),
    10: ("DEF", 2),
}
SECONDS = np.array([row["t"] for row in CHU["trajectory"]])


@pytest.fixture(autouse=True)
def beside(monkeypatch: pytest.MonkeyPatch) -> None:
    """The scripts find what lies beside them, as when they are run."""
    monkeypatch.syspath_prepend(str(FOLDER))


def run(script: str, name: str = "script") -> dict[str, Any]:
    return runpy.run_path(str(FOLDER / f"{script}.py"), run_name=name)


def curves(script: str) -> Callable[[np.ndarray], np.ndarray]:
    return run(script)["curves"]


def test_every_figure_has_its_script() -> None:
    chu = [f"chu2020_figure_{k}" for k in (8, 9, 10)]
    staicu = [f"staicu2015_figure_{k}" for k in STAICU_FIGURES]
    assert sorted([*chu, *staicu]) == SCRIPTS


@pytest.mark.parametrize("script", ["chu2020_figure_9", "chu2020_figure_10"])
def test_captions_end_before_the_edge_of_the_page(script: str) -> None:
    from hybrid_dynamics_core.drawing.page import PLOTS

    with mpl.rc_context(PLOTS):
        figure = run(script)["draw"]()
        ends = [text.get_window_extent().x1 for text in figure.texts]
    assert len(ends) == 2
    assert max(ends) < 0.99 * figure.bbox.width


def test_chu_figure_8_end_effector() -> None:
    position = curves("chu2020_figure_8")(SECONDS)
    assert len(SECONDS) == 11
    for got, row in zip(position, CHU["trajectory"], strict=True):
        assert close_to(got, row["eef"])


def test_chu_figure_9_joints_come_back() -> None:
    """To 1e-10: the paper's round trip, forward then inverse."""
    solved = curves("chu2020_figure_9")(SECONDS)
    assert solved == pytest.approx(np.array([row["u"] for row in CHU["trajectory"]]), abs=1e-10)


def test_chu_figure_10_efforts() -> None:
    tau = curves("chu2020_figure_10")(SECONDS)
    for got, row in zip(tau, CHU["trajectory"], strict=True):
        assert close_to(got, row["tau"])


@pytest.mark.parametrize("number", STAICU_FIGURES)
def test_staicu_figures_5_to_10_legs(number: int) -> None:
    legs, order = STAICU_FIGURES[number]
    rows = STAICU["example"]
    assert len(rows) > 10
    curve = curves(f"staicu2015_figure_{number}")
    columns = curve(np.array([row["t"] for row in rows])).T
    for leg, column in zip(legs, columns, strict=True):
        expected = [row[f"lambda_{leg}"][order] for row in rows]
        assert column == pytest.approx(expected, abs=TOLERANCE)


@pytest.mark.parametrize("script", swept(SCRIPTS, SAMPLE))
def test_scripts_write_their_figure(
    script: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    place = tmp_path / "figure.svg"
    monkeypatch.setattr(sys, "argv", [script, str(place)])
    run(script, name="__main__")
    text = place.read_text(encoding="utf-8")
    paper, number = script.split("_figure_")
    assert f"{TITLES[paper]}, Figure {number}:" in text
    assert "(printed:" in text  # what was read otherwise than printed stands below
    assert str(place) in capsys.readouterr().out


def test_without_a_name_the_figure_is_named_after_its_script(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["script"])
    run("chu2020_figure_8", name="__main__")
    assert [path.name for path in tmp_path.iterdir()] == ["chu2020_figure_8.svg"]
