"""Reports without rendered pictures, but where a test looks at those."""

from __future__ import annotations

from importlib.util import find_spec

import pytest

RENDERED = "hybrid_dynamics_ros.bags.analysis.plotting.rendered"


@pytest.fixture
def painted() -> None:
    """For tests that look at the pictures."""


@pytest.fixture(autouse=True)
def unpainted(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are drawn and not rendered, which takes longer than all else of a report."""
    if "painted" not in request.fixturenames and find_spec("matplotlib") is not None:
        monkeypatch.setattr(RENDERED, lambda _figure: "<svg></svg>")
