"""Viewers of robots, without a browser: each listens at a free port."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_core.view import open_viewer
from hybrid_dynamics_core.view.motion import Motion

if TYPE_CHECKING:
    from hybrid_dynamics_core.view.viewer import Viewer

Opened = Callable[..., "Viewer"]
PATIENCE = 60.0  # [s] a browser tells of its camera when it comes to it


def wait_for_camera(page: Any, client: Any, condition: Callable[[np.ndarray], bool]) -> np.ndarray:
    """Wait until a browser tells of a camera that meets a condition.

    Returns:
        The position of the camera [m].
    """
    end = time.monotonic() + PATIENCE
    while not condition(np.array(client.camera.position)):
        assert time.monotonic() < end, f"the camera stays at {client.camera.position}"
        page.wait_for_timeout(50)
    return np.array(client.camera.position)


@pytest.fixture(scope="session")
def forging() -> Robot:
    """One of its own: robots of this folder are not compiled."""
    return load("forging_chu2020")


@pytest.fixture
def needs_viser() -> None:
    """Skips where the extra is missing."""
    pytest.importorskip("viser", reason="viser, the extra `view`, is not installed")


@pytest.fixture
def opened(needs_viser: None) -> Iterator[Opened]:  # noqa: ARG001 - it comes first
    """Opens viewers, and closes them after the test."""
    viewers: list[Viewer] = []

    def open_one(robot: Robot, motion: Motion | None = None) -> Viewer:
        viewers.append(open_viewer(robot, motion, port=0))
        return viewers[-1]

    yield open_one
    for viewer in viewers:
        viewer.close()
