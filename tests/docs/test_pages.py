"""Every Python block of the README and of the pages in docs runs, in order, and robots written there load."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
PAGES = {"README.md": 4, "docs/dynamics.md": 9, "docs/figure_10.md": 2}  # and how many blocks each has at least


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
