"""Which tests are those of a module's own layer, and what they need."""

from __future__ import annotations

from collections.abc import Collection

# Places of tests by the start of a module's path, the longest that fits.
TESTS = {
    "hybrid_dynamics_core": ("tests/core", "tests/laws", "tests/hard_cases"),
    "hybrid_dynamics_core/closure/printed_numbers": ("tests/description/test_printed_numbers.py",),
    "hybrid_dynamics_core/control": ("tests/control",),
    "hybrid_dynamics_core/description": ("tests/description", "tests/core"),
    "hybrid_dynamics_core/drawing": ("tests/drawing",),
    "hybrid_dynamics_core/dynamics": ("tests/dynamics", "tests/laws", "tests/agreement"),
    "hybrid_dynamics_core/export": ("tests/export",),
    "hybrid_dynamics_core/formats": ("tests/export", "tests/description"),
    "hybrid_dynamics_core/ground/progress": ("tests/simulation/test_simulate.py",),
    "hybrid_dynamics_core/identification": ("tests/identification",),
    "hybrid_dynamics_core/kernels": ("tests/kernels",),
    "hybrid_dynamics_core/kernels/differentiate": ("tests/core/test_differentiate.py",),
    "hybrid_dynamics_core/kinematics": ("tests/core", "tests/generated/test_reach_laws.py"),
    "hybrid_dynamics_core/programs": ("tests/dynamics", "tests/laws", "tests/agreement"),
    "hybrid_dynamics_core/robot/compiled": ("tests/kernels/test_calls.py",),
    "hybrid_dynamics_core/scene": ("tests/drawing", "tests/view"),
    "hybrid_dynamics_core/simulation": ("tests/simulation", "tests/laws"),
    "hybrid_dynamics_core/view": ("tests/view",),
    "hybrid_dynamics_ros": ("tests/ros", "tests/bags/test_stream.py"),
    "hybrid_dynamics_ros/bags": ("tests/bags",),
    "hybrid_dynamics_ros/demo": ("tests/demo",),
    "hybrid_dynamics_cli": ("tests/cli",),
    "hybrid_dynamics_cli/bags": ("tests/bags",),
}
# Tests that want machine code. Elsewhere Python is made sooner from a formula that was changed.
COMPILED = ("tests/bags", "tests/demo", "tests/kernels", "tests/ros")
# Tests that wait for processes: without kept kernels these would not answer in time.
WAITING = ("tests/bags", "tests/demo", "tests/ros")


def places_of(module: str) -> tuple[str, ...]:
    """The places of the tests of a module's own layer."""
    starts = [start for start in TESTS if module.startswith(start)]
    return TESTS[max(starts, key=len)]


def kernels_of(places: Collection[str]) -> dict[str, str]:
    """The environment variable that says which kernels the tests of places want."""
    compiled = any(place.startswith(COMPILED) for place in places)
    return {"HYBRID_DYNAMICS_KERNELS": "" if compiled else "python"}
