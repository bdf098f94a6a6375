"""Shared by all tests: the forging robot, loaded once."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, settings

from hybrid_dynamics_core import Robot, load

settings.register_profile("project", deadline=None, suppress_health_check=[HealthCheck.too_slow], derandomize=True)
settings.load_profile("project")


@pytest.fixture(scope="session")
def forging() -> Robot:
    """The forging robot of Chu et al. (2020)."""
    return load("forging_chu2020")
