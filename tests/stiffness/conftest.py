"""Robots of these tests are asked a question or two: compiling would take longer."""

from __future__ import annotations

from collections.abc import Iterator

import pytest


@pytest.fixture(autouse=True, scope="package")
def _python_kernels() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HYBRID_DYNAMICS_KERNELS", "python")
        yield
