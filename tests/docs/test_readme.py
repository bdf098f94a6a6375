"""Every Python block of the README runs, in order, and the robot written there loads."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", README, re.DOTALL)


def test_the_readme_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    scope: dict[str, Any] = {}
    count = 0
    for language, text in BLOCKS:
        if language == "yaml":
            name = re.search(r"^name: (\w+)$", text, re.MULTILINE)
            assert name is not None
            (tmp_path / f"{name[1]}.yaml").write_text(text, encoding="utf-8")
        if language == "python":
            exec(compile(text, f"README block {count}", "exec"), scope)  # noqa: S102  our own text
            count += 1
    assert count >= 4
    assert scope["robot"].name == "crank_and_cylinder"
    assert scope["state"].residual < 1e-12
