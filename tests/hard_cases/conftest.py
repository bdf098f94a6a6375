"""Each robot here is met once: generated Python answers before a compiler would be done with it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from hybrid_dynamics_core.kernels.run import VARIABLE


@pytest.fixture(autouse=True, scope="package")
def uncompiled() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(VARIABLE, "python")
        yield
