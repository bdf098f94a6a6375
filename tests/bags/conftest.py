"""Shared by the tests of recordings."""

from __future__ import annotations

import pytest


@pytest.fixture
def python_kernels(monkeypatch: pytest.MonkeyPatch) -> None:
    """Generated Python: compiling would take longer than a few messages."""
    monkeypatch.setenv("HYBRID_DYNAMICS_KERNELS", "python")
