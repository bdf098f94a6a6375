"""Build the interfaces with pip, where ROS 2 comes from PyPI.

A ROS installation uses colcon, not this file. The CMakeLists.txt is the one that colcon uses. Its
install tree goes into the wheel as data files: Python modules, libraries, share, ament index. It
lands under ``sys.prefix`` like the trees of the ROS wheels.
"""

import subprocess
import sys
import tempfile
from pathlib import Path
from xml.etree import ElementTree

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

HERE = Path(__file__).resolve().parent
PACKAGE = ElementTree.parse(HERE / "package.xml").getroot()
NAME = PACKAGE.findtext("name")


class BuildInterfaces(build_ext):
    """Configure, build and stage with CMake, then declare what was staged as data files."""

    def run(self) -> None:
        # A new folder each time: an old CMake cache names the Python and the ninja of a pip
        # environment that is gone. It outlives this command, since the wheel is packed later. The
        # interpreter removes it.
        self.folder = tempfile.TemporaryDirectory(prefix=f"{NAME}-")
        build = Path(self.folder.name, "build")
        stage = Path(self.folder.name, "stage")
        settings = {
            "CMAKE_BUILD_TYPE": "Release",
            "CMAKE_INSTALL_PREFIX": stage,
            f"CMAKE_PROJECT_{NAME}_INCLUDE": HERE / "cmake" / "pip_build.cmake",
            "Python3_EXECUTABLE": sys.executable,
            "BUILD_TESTING": "OFF",
        }
        defines = [f"-D{key}={value}" for key, value in settings.items()]
        subprocess.run(["cmake", "-S", HERE, "-B", build, "-G", "Ninja", *defines], check=True)
        subprocess.run(["cmake", "--build", build, "--target", "install"], check=True)
        self.distribution.data_files = data_files(stage)

    def get_outputs(self) -> list[str]:
        return []

    def get_output_mapping(self) -> dict[str, str]:
        return {}


def data_files(stage: Path) -> list[tuple[str, list[str]]]:
    """Every file below ``stage``, as (folder relative to the prefix, files)."""
    files_of: dict[str, list[str]] = {}
    for file in sorted(path for path in stage.rglob("*") if path.is_file()):
        files_of.setdefault(str(file.parent.relative_to(stage)), []).append(str(file))
    return list(files_of.items())


setup(
    name="hybrid-dynamics-msgs",
    version=PACKAGE.findtext("version"),
    description=PACKAGE.findtext("description"),
    long_description=PACKAGE.findtext("description"),
    long_description_content_type="text/markdown",
    license=PACKAGE.findtext("license"),
    python_requires=">=3.11",
    install_requires=[
        "ros-jazzy-action-msgs==2.0.3",
        "ros-jazzy-geometry-msgs==5.3.6",
        "ros-jazzy-sensor-msgs==5.3.6",
        "ros-jazzy-std-msgs==5.3.6",
        "ros-jazzy-trajectory-msgs==5.3.6",
    ],
    packages=[],
    py_modules=[],
    data_files=[],  # BuildInterfaces fills it; with None the wheel would have no data
    ext_modules=[Extension("interfaces", [])],  # not compiled, gets the wheel its platform tag
    cmdclass={"build_ext": BuildInterfaces},
)
