"""Which tests are those of a module's own layer, and what they need."""

from __future__ import annotations

from collections.abc import Collection

# Places of tests by the start of a module's path, the longest that fits.
CORE = "hybrid_dynamics_core"
VERBS = "hybrid_dynamics_cli/verbs"
LOOPS = ("tests/hard_cases", "tests/generated", "tests/core", "tests/laws")
FORMULAS = ("tests/dynamics", "tests/laws", "tests/agreement")
FRAMEWORKS = ("tests/frameworks",)
RETIMING = ("tests/limits", "tests/ros/test_trajectory_laws.py")
VALUES = ("tests/parameters", "tests/description")
TESTS = {
    CORE: ("tests/core", "tests/laws", "tests/hard_cases"),
    f"{CORE}/calibration": ("tests/calibration",),
    f"{CORE}/capability": ("tests/capability",),
    f"{CORE}/certified": ("tests/certified",),
    f"{CORE}/closed_state": LOOPS,
    f"{CORE}/closure": LOOPS,
    f"{CORE}/closure/printed": (
        "tests/description/test_printed_numbers.py",
        "tests/description/test_printed_spherical.py",
    ),
    f"{CORE}/control": ("tests/control",),
    f"{CORE}/description": ("tests/description", "tests/core"),
    f"{CORE}/description/parameters": VALUES,
    f"{CORE}/design": ("tests/design",),
    f"{CORE}/drawing": ("tests/drawing",),
    f"{CORE}/dynamics": FORMULAS,
    f"{CORE}/estimation": ("tests/estimation",),
    f"{CORE}/export": ("tests/export",),
    f"{CORE}/filtering": ("tests/filtering",),
    f"{CORE}/formats": ("tests/export", "tests/description"),
    f"{CORE}/ground/progress": ("tests/simulation/test_simulate.py",),
    f"{CORE}/identification": ("tests/identification",),
    f"{CORE}/kernels": ("tests/kernels",),
    f"{CORE}/kernels/differentiate": ("tests/core/test_differentiate.py",),
    f"{CORE}/kernels/frameworks": FRAMEWORKS,
    f"{CORE}/kinematics": ("tests/core", "tests/generated/test_reach_laws.py"),
    f"{CORE}/limits": ("tests/limits",),
    f"{CORE}/programs": FORMULAS,
    f"{CORE}/retiming": RETIMING,
    f"{CORE}/robot/compiled": ("tests/kernels/test_calls.py",),
    f"{CORE}/robot/frameworks": FRAMEWORKS,
    f"{CORE}/robot/parameters": VALUES,
    f"{CORE}/scene": ("tests/drawing", "tests/view"),
    f"{CORE}/simulation": ("tests/simulation", "tests/laws"),
    f"{CORE}/sizing": ("tests/sizing",),
    f"{CORE}/stiffness": ("tests/stiffness",),
    f"{CORE}/sweeps": ("tests/sweeps",),
    f"{CORE}/tolerances": ("tests/tolerances",),
    f"{CORE}/view": ("tests/view",),
    "hybrid_dynamics_ros": ("tests/ros", "tests/bags/test_stream.py"),
    "hybrid_dynamics_ros/bags": ("tests/bags",),
    "hybrid_dynamics_ros/demo": ("tests/demo",),
    "hybrid_dynamics_cli": ("tests/cli",),
    "hybrid_dynamics_cli/bags": ("tests/bags",),
    f"{VERBS}/bag": ("tests/bags",),
    f"{VERBS}/calibrate": ("tests/calibration", "tests/cli"),
    f"{VERBS}/capability": ("tests/capability", "tests/cli"),
    f"{VERBS}/design": ("tests/design", "tests/sizing", "tests/cli"),
    f"{VERBS}/elastic": ("tests/stiffness", "tests/cli"),
    f"{VERBS}/measured": ("tests/estimation", "tests/filtering", "tests/cli"),
    f"{VERBS}/retime": ("tests/limits", "tests/cli"),
    f"{VERBS}/studies": ("tests/sweeps", "tests/tolerances", "tests/cli"),
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
