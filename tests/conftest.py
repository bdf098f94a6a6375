"""Shared by all tests: the forging robot, loaded once."""

from __future__ import annotations

import os
import tempfile

import pytest
from hypothesis import HealthCheck, settings

from hybrid_dynamics_core import Robot, load

_kept = tempfile.TemporaryDirectory()  # kernels are kept for this run, not with the user's own
os.environ["HYBRID_DYNAMICS_CACHE"] = _kept.name

settings.register_profile("project", deadline=None, suppress_health_check=[HealthCheck.too_slow], derandomize=True)
settings.load_profile("project")


@pytest.fixture(scope="session")
def forging() -> Robot:
    """The forging robot of Chu et al. (2020)."""
    return load("forging_chu2020")
