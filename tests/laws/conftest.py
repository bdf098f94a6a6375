"""Laws hold for both ways of working: compiled for some robots, generated Python for the others.

That both ways give the same numbers on every robot is the matter of tests/kernels; compiling everything takes minutes.
"""

from __future__ import annotations

import pytest

from hybrid_dynamics_core.kernels.run import VARIABLE

COMPILED = ("excavator", "five_bar", "forging_chu2020")


@pytest.fixture(autouse=True)
def backend(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    called = getattr(request.node, "callspec", None)
    if called is not None and called.params.get("name") not in COMPILED:
        monkeypatch.setenv(VARIABLE, "python")
