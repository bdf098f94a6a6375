"""Rooms stay small: a module that grows beyond the limit has more than one job."""

from __future__ import annotations

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ["hybrid_dynamics_core", "hybrid_dynamics_ros", "hybrid_dynamics_cli"]
LONGEST = 400  # lines, as docs/architecture.md says


@pytest.mark.parametrize("package", PACKAGES)
def test_no_module_is_too_long(package: str) -> None:
    modules = sorted((ROOT / package).rglob("*.py"))
    lengths = {
        str(path.relative_to(ROOT)): len(path.read_text(encoding="utf-8").splitlines())
        for path in modules
    }
    assert lengths, f"no modules in {package}"
    assert {name: lines for name, lines in lengths.items() if lines > LONGEST} == {}
