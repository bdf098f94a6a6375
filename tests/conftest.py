"""Shared by all tests: the forging robot, loaded once."""

from __future__ import annotations

import importlib.util
import os
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, settings

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.kernels.run import VARIABLE

# Kernels are cached for this run of all workers, not among the user's.
if "PYTEST_XDIST_WORKER" not in os.environ:
    _cache = tempfile.TemporaryDirectory()
    os.environ["HYBRID_DYNAMICS_CACHE"] = _cache.name

ROOT = Path(__file__).resolve().parent

NEEDS = {  # what tests take from beyond the libraries of Ubuntu 24.04, and of a ROS installation
    "agreement": ("mujoco", "pinocchio"),
    "bags": ("click", "mcap", "rosbags"),
    "cli": ("click",),
    "demo": ("rclpy", "rosbags"),
    "description/test_gepetto.py": ("pinocchio",),
    "description/test_urdf.py": ("pinocchio",),
    "drawing": ("matplotlib",),
    "export/test_loops.py": ("pinocchio",),
    "export/test_urdf.py": ("pinocchio",),
    "ros": ("rclpy",),
    "ros/test_conversions.py": ("rclpy", "rosbags"),
    "ros/test_outputs.py": ("rclpy", "rosbags"),
    "ros/test_page_blocks.py": ("rclpy", "rosbags"),
}
MISSING: dict[str, list[str]] = {}
for _place, _names in NEEDS.items():
    if not all(map(importlib.util.find_spec, _names)):
        MISSING[_place] = [name for name in _names if importlib.util.find_spec(name) is None]
collect_ignore = list(MISSING)


def pytest_report_header() -> list[str]:
    """Say what is left out, and why."""
    lines = []
    for place, names in MISSING.items():
        lines.append(f"left out: tests/{place}, which needs {' and '.join(names)}")
    return lines


settings.register_profile(
    "project",
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
    derandomize=True,
    phases=[phase for phase in Phase if phase is not Phase.explain],  # it traces every line: slow
)
settings.load_profile("project")


# Folders whose robots are used once.
UNCOMPILED = (
    "agreement",
    "description",
    "docs",
    "drawing",
    "examples",
    "export",
    "generated",
    "hard_cases",
    "identification",
    "view",
)
COMPILED = ("excavator", "five_bar", "forging_chu2020")  # of the robots of tests/laws
PROCESSES = ("demo", "packaging", "ros")  # folders whose tests start processes: one after the other


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Groups for pytest-xdist: a file stays on one worker.

    So do all tests that start processes.
    """
    for item in items:
        group = item.nodeid.partition("::")[0]
        if item.path.relative_to(ROOT).parts[0] in PROCESSES:
            group = "processes"
        item.add_marker(pytest.mark.xdist_group(group))


@pytest.fixture
def python_kernels(monkeypatch: pytest.MonkeyPatch) -> None:
    """Generated Python: compiling would take longer than a few messages."""
    monkeypatch.setenv("HYBRID_DYNAMICS_KERNELS", "python")


@pytest.fixture(autouse=True)
def backend(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Generated Python where it answers before a compiler would be done.

    Both agree, as tests/kernels shows.
    """
    callspec = getattr(request.node, "callspec", None)
    name = None
    if callspec is not None:
        name = callspec.params.get("name")
    folder = request.path.relative_to(ROOT).parts[0]
    is_rare_robot = name is not None and name not in COMPILED
    if folder in UNCOMPILED or (folder == "laws" and is_rare_robot):
        monkeypatch.setenv(VARIABLE, "python")


@pytest.fixture(scope="module")
def forging(request: pytest.FixtureRequest) -> Robot:
    """The forging robot of Chu et al. (2020), one for all tests of a backend."""
    from tests.robots import backend, robot_of  # after this file has set the environment

    if request.path.relative_to(ROOT).parts[0] in UNCOMPILED:
        return robot_of("forging_chu2020", "python")
    return robot_of("forging_chu2020", backend())
