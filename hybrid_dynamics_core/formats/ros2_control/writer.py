"""A robot as a package of plugins of ros2_control."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.resources import files

from ...errors import InputError
from ...ground.suggestions import no_such_name
from ...robot.robot import Robot
from ...robot.taken import AnyRobot, robot_of
from ..c.calls import lack_of_masses
from ..c.names import identifier
from ..c.writer import source_of
from .example_files import controllers_text, urdf_text
from .model_file import model_text
from .package_files import (
    Package,
    cmake_text,
    controller_plugins_text,
    package_text,
    readme_text,
    transmission_plugins_text,
)
from .sides import Sides, sides_of
from .vectors_file import vectors_text

TRANSMISSION, FEED_FORWARD = "transmission", "feed_forward"
PLUGINS = (TRANSMISSION, FEED_FORWARD)
_TEST_CONTROLLER = """
TEST(Plugins, ControllerLoads)
{
  pluginlib::ClassLoader<controller_interface::ChainableControllerInterface> loader(
    "controller_interface", "controller_interface::ChainableControllerInterface");
  EXPECT_NE(loader.createUniqueInstance("@PACKAGE@/FeedForwardController"), nullptr);
}
"""
_INCLUDE_CONTROLLER = '#include "controller_interface/chainable_controller_interface.hpp"\n'


def to_ros2_control(
    robot: AnyRobot,
    plugins: Sequence[str] | None = None,
    *,
    joints: Sequence[str] | None = None,
) -> dict[str, str]:
    """The model of a robot as an ament_cmake package of plugins.

    Args:
        robot: the robot, or its description.
        plugins: "transmission", which is always there, and "feed_forward", the controller; if
            None, both, the controller only if there are masses.
        joints: names of the joint side; if None, the joints on the way to the end effector that
            move independently, and drives where there are too few.

    Returns:
        The text of each file by its name in the package, such as "src/transmission.cpp".

    Raises:
        InputError: there is no such plugin or joint, no link has a mass for "feed_forward", a
            coordinate has no drive, or the joints do not determine the motion.
    """
    machine = robot_of(robot)
    dynamics = _has_dynamics(machine, plugins)
    sides = sides_of(machine, joints)
    drives_prefix = identifier(machine.name)
    joints_prefix = drives_prefix if sides.same else f"{drives_prefix}_joints"
    name = f"{drives_prefix.lower()}_ros2_control"
    programs = ["close", "generalised_forces"]
    if dynamics:
        programs.append("inverse_dynamics")
    code = source_of(machine, programs)
    if not sides.same:
        code |= source_of(sides.joints, programs, prefix=joints_prefix)
    sources = tuple(file for file in code if file.endswith(".c"))
    package = Package(name, drives_prefix, sources, dynamics)
    texts = _placed(code)
    model = model_text(sides, name, drives_prefix, joints_prefix, dynamics)
    texts["include/PACKAGE/model.hpp"] = model
    texts |= _plugin_sources(package)
    texts["test/test_core.cpp"] = vectors_text(sides, name, dynamics)
    texts |= _package_files(package, sides)
    return {path.replace("PACKAGE", name): text for path, text in texts.items()}


def _has_dynamics(robot: Robot, plugins: Sequence[str] | None) -> bool:
    """Whether the controller is written.

    Raises:
        InputError: a plugin is unknown, none is named, or the controller has no results.
    """
    lack = lack_of_masses(robot)
    if plugins is None:
        return not lack
    for name in plugins:
        if name not in PLUGINS:
            raise InputError(no_such_name("plugin", name, PLUGINS))
    if not plugins:
        raise InputError(f"no plugin is named; expected some of {', '.join(PLUGINS)}")
    if FEED_FORWARD in plugins and lack:
        raise InputError(f"{robot.name}: {lack}, so the plugin '{FEED_FORWARD}' has no efforts")
    return FEED_FORWARD in plugins


def _placed(code: dict[str, str]) -> dict[str, str]:
    """C files in their folders."""
    texts = {}
    for file, text in code.items():
        folder = "src" if file.endswith(".c") else "include"
        texts[f"{folder}/{file}"] = text
    return texts


def _plugin_sources(package: Package) -> dict[str, str]:
    """The C++ of the plugins."""
    places = {
        "core.hpp": "include/PACKAGE/core.hpp",
        "transmission.hpp": "include/PACKAGE/transmission.hpp",
        "transmission.cpp": "src/transmission.cpp",
        "test_plugins.cpp": "test/test_plugins.cpp",
    }
    if package.dynamics:
        places["feed_forward_controller.hpp"] = "include/PACKAGE/feed_forward_controller.hpp"
        places["feed_forward_controller.cpp"] = "src/feed_forward_controller.cpp"
    ours = files(__package__) / "sources"
    texts = {}
    for name, place in places.items():
        text = (ours / name).read_text(encoding="utf-8")
        test = _TEST_CONTROLLER if package.dynamics else ""
        include = _INCLUDE_CONTROLLER if package.dynamics else ""
        text = text.replace("@TEST_CONTROLLER@\n", test)
        text = text.replace("@INCLUDE_CONTROLLER@\n", include)
        texts[place] = text.replace("@PACKAGE@", package.name)
    return texts


def _package_files(package: Package, sides: Sides) -> dict[str, str]:
    """Build files, descriptions of plugins, and the example."""
    texts = {
        "CMakeLists.txt": cmake_text(package),
        "package.xml": package_text(package),
        "transmission_plugins.xml": transmission_plugins_text(package),
        "README.md": readme_text(package, sides),
        f"urdf/{package.model}.urdf": urdf_text(sides, package.name),
        "config/controllers.yaml": controllers_text(sides, package.name, package.dynamics),
    }
    if package.dynamics:
        texts["controller_plugins.xml"] = controller_plugins_text(package)
    return texts
