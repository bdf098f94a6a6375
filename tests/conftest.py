"""Shared by all tests: what is left out and why, the cache of kernels, samples of whole sets."""

from __future__ import annotations

import gc
import importlib.util
import os
from collections import defaultdict
from collections.abc import Collection, Iterable
from pathlib import Path

# One thread a process: several processes share the processors, and matrices are small.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from hypothesis import HealthCheck, Phase, settings

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.kernels import cache, native
from hybrid_dynamics_core.kernels.run import VARIABLE
from tests.sampling import MORE_EXAMPLES

# Kernels stay for the next run, apart from those of the user's own programs.
os.environ.setdefault(cache.VARIABLE, str(cache.user_folder() / "hybrid_dynamics_tests"))

ROOT = Path(__file__).resolve().parent

# what tests take from beyond the libraries of Ubuntu 24.04, and of a ROS installation
NEEDS = {
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


def is_missing(library: str) -> bool:
    """Whether a library cannot be imported."""
    return importlib.util.find_spec(library) is None


def missing_libraries() -> dict[str, list[str]]:
    """The libraries that each place of NEEDS lacks; places that lack none are left out."""
    missing = {place: list(filter(is_missing, names)) for place, names in NEEDS.items()}
    return {place: names for place, names in missing.items() if names}


MISSING = missing_libraries()
collect_ignore = list(MISSING)

settings.register_profile(
    "project",
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
    derandomize=True,
    # explaining traces every line: failures ran out of time
    phases=[phase for phase in Phase if phase is not Phase.explain],
)
settings.load_profile("project")

# folders and files whose robots are met once
UNCOMPILED = (
    "agreement",
    "bags",
    "capability/test_capability.py",
    "cli",
    "core/test_closed_form_ik.py",
    "core/test_platform_frames.py",
    "description",
    "docs",
    "drawing",
    "estimation",
    "examples",
    "export",
    "generated",
    "hard_cases",
    "identification",
    "laws/test_ball_cuts.py",
    "laws/test_idle.py",
    "laws/test_multi_dof.py",
    "laws/test_optional_inputs.py",
    "laws/test_regrouped.py",
    "ros/test_ball_joints.py",
    "ros/test_other_joints.py",
    "ros/test_trajectory_laws.py",
    "view",
)
# files of these folders that compare bits with those of the node
BITS = (
    "bags/test_bits.py",
    "bags/test_chunks.py",
    "bags/test_motions.py",
    "bags/test_odometry.py",
    "bags/test_outputs.py",
    "bags/test_pass_through.py",
    "bags/test_settings.py",
    "bags/test_stream.py",
    "bags/test_unfinished.py",
)
# long streams through one robot, and long searches: with all random examples a compiler pays
STREAMS = (
    "bags/test_payload_stream.py",
    "bags/test_tool_force.py",
    "core/test_closed_form_ik.py",
)
# folders and files that ask for numbers alone: code compiled in a fifth of the time gives them too
QUICKLY_COMPILED = (
    "control",
    "core",
    "dynamics",
    "kernels/test_calls.py",
    "laws",
    "published",
    "simulation",
)
# likewise with all robots; those of the sample are compiled as for users
QUICKLY_COMPILED_WHOLE = ("frameworks",)
# folders and files that take long: they begin first, so that no core waits for the last of them
LONG = (
    "bags/test_tool_force.py",
    "core/test_closed_form_ik.py",
    "core/test_platform_frames.py",
    "demo/test_demo.py",
    "export/test_c_programs.py",
    "export/test_c_random.py",
    "frameworks",
    "generated",
    "laws/test_regrouped.py",
    "ros/test_node_load.py",
    "ros/test_node_process.py",
    "ros/test_page_blocks.py",
    "view/test_browser.py",
)
NODE = ("demo", "ros")  # folders that need ROS and the interfaces
WORKER = os.environ.get("PYTEST_XDIST_WORKER", "gw0")  # of this process
COMPILED = ("excavator", "five_bar", "forging_chu2020")  # of the robots of tests/laws


def pytest_report_header() -> list[str]:
    """Say what is left out, and why."""
    header = [f"kernels are kept in {cache.folder()}"]
    for place, names in MISSING.items():
        header.append(f"left out: tests/{place}, which needs {' and '.join(names)}")
    return header


def pytest_configure(config: pytest.Config) -> None:
    """Let every other worker collect in reverse order.

    Each worker rewrites the asserts of the first half of its files, while another one rewrites the
    other half. Both find what the other one left.
    """
    if int(WORKER.removeprefix("gw")) % 2:
        config.args = backwards(config.args, config.getoption("ignore") or ())


def backwards(places: list[str], ignored: Collection[str]) -> list[str]:
    """The same tests in reverse order, those of the folder `tests` by its folders.

    Folders that are named are read even where they are ignored, so those are left out.
    """
    if places == [ROOT.name]:
        folders = {f"{ROOT.name}/{file.parent.name}" for file in ROOT.glob("*/test_*.py")}
        places = sorted(folders.difference(ignored))
    return places[::-1]


@pytest.hookimpl(tryfirst=True)  # before any is deselected
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests of the node, hold that no law is without a sample, and begin with long files.

    Raises:
        pytest.UsageError: all cases of a test are marked `sweep`, and none stands for them.
    """
    for item in items:
        if item.path.relative_to(ROOT).parts[0] in NODE:
            item.add_marker(pytest.mark.ros)
    unsampled = [name for name, cases in by_function(items).items() if not has_sample(cases)]
    if unsampled:
        raise pytest.UsageError(f"no case is in the sample of {', '.join(unsampled)}")
    items.sort(key=lambda item: (is_short(item), item.path))


def pytest_collection_finish() -> None:
    """Leave all that is there now out of searches for garbage, which take up to 5 % else."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)  # and search seldom: most of what tests make has no circles


def is_short(item: pytest.Item) -> bool:
    """Whether a test is in none of the files that begin first."""
    file = item.path.relative_to(ROOT)
    return not {file.parts[0], file.as_posix()} & set(LONG)


def by_function(items: Iterable[pytest.Item]) -> dict[str, list[pytest.Item]]:
    """The cases of each test."""
    cases: dict[str, list[pytest.Item]] = defaultdict(list)
    for item in items:
        cases[item.nodeid.partition("[")[0]].append(item)
    return cases


def has_sample(cases: list[pytest.Item]) -> bool:
    """Whether a case runs in `make test`, or another test stands for it: `sweep(sample="...")`."""
    marks = [case.get_closest_marker("sweep") for case in cases]
    return any(mark is None or "sample" in mark.kwargs for mark in marks)


@pytest.fixture
def python_kernels(monkeypatch: pytest.MonkeyPatch) -> None:
    """Generated Python: compiling would take longer than a few messages."""
    monkeypatch.setenv(VARIABLE, "python")


@pytest.fixture(autouse=True)
def backend(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Generated Python where it answers before a compiler would be done.

    Both backends agree, as tests/kernels shows.
    """
    case = getattr(request.node, "callspec", None)
    name = None if case is None else case.params.get("name")
    is_rare = "laws" in places_of(request) and name is not None and name not in COMPILED
    if is_uncompiled(request) or is_rare:
        monkeypatch.setenv(VARIABLE, "python")
    quickly = QUICKLY_COMPILED
    if MORE_EXAMPLES is not None:
        quickly += QUICKLY_COMPILED_WHOLE
    if places_of(request) & set(quickly):
        monkeypatch.setattr(native, "LEVEL", 0)


@pytest.fixture(scope="module")
def forging(request: pytest.FixtureRequest) -> Robot:
    """The forging robot of Chu et al. (2020), one for all tests of a backend."""
    from tests.robots import backend, robot_of  # after this file has set the environment

    return robot_of("forging_chu2020", "python" if is_uncompiled(request) else backend())


def places_of(request: pytest.FixtureRequest) -> set[str]:
    """The folder and the file of a test."""
    file = request.path.relative_to(ROOT)
    return {file.parts[0], file.as_posix()}


def is_uncompiled(request: pytest.FixtureRequest) -> bool:
    """Whether a test computes with generated Python."""
    places = places_of(request)
    compiled = BITS if MORE_EXAMPLES is None else BITS + STREAMS
    return places.isdisjoint(compiled) and not places.isdisjoint(UNCOMPILED)
