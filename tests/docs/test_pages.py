"""Every Python block of the README and of the pages in docs runs, in order, and robots written there load."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
PAGES = {  # and how many blocks each has at least
    "README.md": 5,
    "docs/performance.md": 1,
    "docs/dynamics.md": 9,
    "docs/figure_10.md": 2,
    "docs/view.md": 1,
}


def run(page: str, folder: Path) -> dict[str, Any]:
    """The names that the page's blocks leave, with its robots as files in the folder."""
    scope: dict[str, Any] = {}
    blocks = re.findall(r"```(\w+)\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), re.DOTALL)
    for language, text in blocks:
        if language == "yaml":
            name = re.search(r"^name: (\w+)$", text, re.MULTILINE)
            assert name is not None
            (folder / f"{name[1]}.yaml").write_text(text, encoding="utf-8")
        if language == "python":
            exec(compile(text, f"a block of {page}", "exec"), scope)  # noqa: S102  our own text
    assert sum(language == "python" for language, _ in blocks) >= PAGES[page]
    return scope


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_the_readme_runs(tmp_path: Path) -> None:
    scope = run("README.md", tmp_path)
    assert scope["robot"].name == "crank_and_cylinder"
    assert scope["state"].residual < 1e-12


def test_figure_10_is_made(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    scope = run("docs/figure_10.md", tmp_path)
    assert scope["tau"].shape == (101, 4)
    assert (tmp_path / "figure_10.svg").stat().st_size > 10_000


def test_the_view_opens() -> None:
    pytest.importorskip("viser")
    scope = run("docs/view.md", Path())
    assert scope["viewer"].url.startswith("http://localhost:")
    assert scope["viewer"].session.motion.duration == 2.0


def test_dynamics_runs_and_does_what_it_says(tmp_path: Path) -> None:
    scope = run("docs/dynamics.md", tmp_path)
    assert scope["ddu"] == pytest.approx([0.1, 0.2, 0.0, 0.0], abs=1e-9)
    assert scope["pendulum"].loads.effects.armature == pytest.approx([2.0, 0.0])
    assert scope["fall"].events[0].message.startswith("q22 reached its lower limit 0.32")
    assert scope["fall"].relative_energy_error < 1e-8
    assert scope["fall"].residual < 1e-12
    assert (tmp_path / "fall.npz").is_file()
    assert scope["run"].completed
    assert scope["run"].u[-1] == pytest.approx(scope["path"](1.0).u, abs=2e-3)
    assert _inside(scope) > 0.85


def _inside(scope: dict[str, Any]) -> float:
    """Share of the true base parameters within the intervals of the estimate."""
    found = scope["found"]
    truth = found.base.values(found.parameters.values(scope["robot"].description))
    return float(((truth > found.interval[:, 0]) & (truth < found.interval[:, 1])).mean())


def test_performance_runs(tmp_path: Path) -> None:
    scope = run("docs/performance.md", tmp_path)
    assert scope["efforts"].shape == (100_000, 4)
    assert scope["efforts"][7] == pytest.approx(scope["tau"], rel=1e-9, abs=1e-9)
    assert scope["moon"] == pytest.approx(scope["tau"] * 1.62 / 9.81, abs=1e-6)
