"""What package.xml names exists for Ubuntu 24.04 and ROS 2 Jazzy, and what is imported is named."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).resolve().parents[2]
# Keys of rosdep's python.yaml and packages of jazzy/distribution.yaml in ros/rosdistro, looked up
# there one by one.
SYSTEM = {
    "python3-click": "click",
    "python3-hypothesis": "hypothesis",
    "python3-jsonschema": "jsonschema",
    "python3-matplotlib": "matplotlib",
    "python3-numpy": "numpy",
    "python3-pytest": "pytest",
    "python3-pytest-timeout": "pytest_timeout",
    "python3-scipy": "scipy",
    "python3-yaml": "yaml",
}
JAZZY = {
    "action_msgs",
    "ament_cmake",
    "ament_index_python",
    "builtin_interfaces",
    "diagnostic_msgs",
    "geometry_msgs",
    "launch",
    "launch_ros",
    "lifecycle_msgs",
    "nav_msgs",
    "rcl_interfaces",
    "rclpy",
    "rosidl_default_generators",
    "rosidl_default_runtime",
    "sensor_msgs",
    "std_msgs",
    "tf2_msgs",
    "trajectory_msgs",
}
OUR_PACKAGES = {
    "hybrid_dynamics_benchmarks",
    "hybrid_dynamics_cli",
    "hybrid_dynamics_core",
    "hybrid_dynamics_ros",
}
OPTIONAL = {  # extras: imported where they are used, with a message that says what to install
    "backports",
    "casadi",
    "compression",
    "daqp",
    "distributed",
    "jax",
    "llvmlite",
    "lz4",
    "matplotlib",
    "mujoco",
    "pyarrow",
    "rosbags",
    "torch",
    "trimesh",
    "viser",
    "xacro",
    "zstandard",
}


def manifest(folder: str) -> ElementTree.Element:
    return ElementTree.parse(ROOT / folder / "package.xml").getroot()


def keys(folder: str, *kinds: str) -> set[str]:
    """What the manifest of a package names, in its tags of these kinds; in all if none is given."""
    names = set()
    for element in manifest(folder):
        is_wanted = not kinds or element.tag in kinds
        if element.tag.endswith("depend") and is_wanted:
            names.add(element.text or "")
    return names


@pytest.mark.parametrize("folder", [".", "msg_defs"])
def test_every_key_exists(folder: str) -> None:
    assert keys(folder) <= set(SYSTEM) | JAZZY | {"hybrid_dynamics_msgs"}


@pytest.mark.parametrize("folder", [".", "msg_defs"])
def test_what_bloom_asks_of_a_manifest_is_there(folder: str) -> None:
    """Format 3, one line of description, somebody to write to, a licence."""
    root = manifest(folder)
    assert root.get("format") == "3"
    assert "\n" not in (root.findtext("description") or "\n")
    assert "@" in (root.find("maintainer").get("email") or "")
    assert root.findtext("license") == "Apache-2.0"
    assert (ROOT / folder / "CHANGELOG.rst").is_file()


def imported(folder: Path) -> Iterator[str]:
    """Names of what the modules below a folder import from elsewhere."""
    for path in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and not node.level:
                names = [node.module or ""]
            yield from (name.partition(".")[0] for name in names)


@pytest.mark.parametrize(
    "folder", ["hybrid_dynamics_cli", "hybrid_dynamics_core", "hybrid_dynamics_ros", "launch"]
)
def test_what_is_imported_is_named(folder: str) -> None:
    named = {SYSTEM.get(key, key) for key in keys(".", "depend", "exec_depend")}
    others = set(imported(ROOT / folder)) - set(sys.stdlib_module_names) - OUR_PACKAGES - OPTIONAL
    assert others <= named
