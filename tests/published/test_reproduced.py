"""The page of reproduced numbers holds what its script computes."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/reproduced.md").read_text(encoding="utf-8")


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    spec = importlib.util.spec_from_file_location("reproduced", ROOT / "tools/reproduced.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "reproduced", module)
    spec.loader.exec_module(module)
    return module


def test_page_prints_what_the_script_computes(script: ModuleType) -> None:
    for row in script.squeezer():
        assert row.line() in PAGE
        assert row.ours == pytest.approx(row.theirs, rel=1e-7, abs=1e-6)


@pytest.mark.sweep(sample="test_page_prints_what_the_script_computes")
def test_whole_table_is_that_of_the_script(script: ModuleType) -> None:
    assert "\n".join(script.table()) in PAGE
