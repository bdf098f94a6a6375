"""The package for colcon (hybrid_dynamics_ros, ament_python) and for pip (hybrid-dynamics-ros)."""

from glob import glob
from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup

HERE = Path(__file__).resolve().parent
PACKAGE = ElementTree.parse(HERE / "package.xml").getroot()
NAME = PACKAGE.findtext("name")  # colcon wants the name of package.xml here

EXTRAS = {
    "fast": ["llvmlite>=0.45"],  # the compiler of numba
    "cli": ["click"],
    "plot": ["matplotlib"],
    "bag": ["click", "lz4", "rosbags>=0.11"],  # rosbags brings zstd
    "dask": ["distributed"],
    "parquet": ["pyarrow"],
    "view": ["viser>=1.1"],
    "meshes": ["trimesh>=4", "pycollada>=0.7"],
    "xacro": ["xacro>=2.1"],
    "mjcf": ["mujoco-core>=4.0"],  # the module mujoco without a viewer; mujoco serves too
    "drives": ["daqp>=0.8"],  # quadratic programs of redundant drives
    "jax": ["jax>=0.6"],
    "casadi": ["casadi>=3.6"],
    "torch": ["torch>=2.2"],
    # ROS 2 Jazzy from PyPI, for machines without a ROS installation. Always the ros-jazzy-* names:
    # the others resolve to newer distributions. The extra fastrtps brings the middleware. The
    # interfaces come from this repository: pip install ./msg_defs ".[ros]"
    "ros": [
        "ros-jazzy-action-msgs==2.0.3",
        "ros-jazzy-builtin-interfaces==2.0.3",
        "ros-jazzy-diagnostic-msgs==5.3.6",
        "ros-jazzy-geometry-msgs==5.3.6",
        "ros-jazzy-nav-msgs==5.3.6",
        "ros-jazzy-rclpy==7.1.6",
        "ros-jazzy-sensor-msgs==5.3.6",
        "ros-jazzy-std-msgs==5.3.6",
        "ros-jazzy-trajectory-msgs==5.3.6",
        "ros-rclpy[fastrtps]==7.1.6",
    ],
    "test": [
        "casadi>=3.6",
        "click",
        "daqp>=0.8",
        "distributed",
        "fmpy>=0.3",  # an FMI importer of others
        "hypothesis",
        "jax>=0.6",
        "matplotlib",
        "mcap",
        "mujoco-core>=4.0",
        "pin",
        "playwright",
        "pyarrow",
        "pytest",
        "pytest-timeout",
        "pytest-xdist",
        "rosbags>=0.11",
        "setuptools>=70.1,<80",  # builds the sdist and the wheel that are tried
        "viser>=1.1",
        "xacro>=2.1",
    ],
    "docs": [
        "click",
        "furo",
        "matplotlib",
        "myst-parser",
        "sphinx>=8",
        "sphinx-copybutton",
        "sphinx-design",
        "viser>=1.1",
        "ziamath",
    ],
    "dev": ["import-linter", "mypy", "ruff", "types-PyYAML", "types-jsonschema"],
    "colcon": [
        "colcon-bash",
        "colcon-cmake",
        "colcon-core",
        "colcon-defaults",
        "colcon-output",
        "colcon-parallel-executor",
        "colcon-python-setup-py",
        "colcon-ros",
    ],
}

setup(
    name=NAME,
    version=PACKAGE.findtext("version"),
    description=PACKAGE.findtext("description"),
    long_description=(HERE / "README.md").read_text(encoding="utf-8"),
    long_description_content_type="text/markdown",
    keywords=["robotics", "ROS 2", "kinematics", "dynamics", "closed loops", "parallel robots"],
    classifiers=[
        "Development Status :: 4 - Beta",
        "Intended Audience :: Science/Research",
        "Operating System :: POSIX :: Linux",
        "Programming Language :: Python :: 3.11",
        "Programming Language :: Python :: 3.12",
        "Topic :: Scientific/Engineering",
        "Typing :: Typed",
    ],
    author=PACKAGE.findtext("maintainer"),
    author_email=PACKAGE.find("maintainer").get("email"),
    license=PACKAGE.findtext("license"),
    python_requires=">=3.11",
    packages=[
        *find_packages(
            include=["hybrid_dynamics_cli*", "hybrid_dynamics_core*", "hybrid_dynamics_ros*"]
        ),
        *(f"hybrid_dynamics_{name}" for name in find_packages(include=["benchmarks*"])),
        "hybrid_dynamics_ros.interfaces",
    ],
    package_dir={
        "hybrid_dynamics_benchmarks": "benchmarks",  # `hybrid-dynamics benchmark` runs them
        "hybrid_dynamics_ros.interfaces": (
            "msg_defs/msg"
        ),  # bags are read and written without the ROS package
    },
    package_data={
        "hybrid_dynamics_benchmarks": ["sides/*.c"],
        "hybrid_dynamics_cli": ["py.typed"],
        "hybrid_dynamics_core": [
            "py.typed",
            "robots/*.yaml",
            "templates/*.yaml",
            "description/*.json",
            "formats/fmu/sources/*",
            "formats/ros2_control/sources/*",
        ],
        "hybrid_dynamics_ros.interfaces": ["*.msg"],
        "hybrid_dynamics_ros": ["py.typed", "demo/play/*.xml", "recordings/*/*"],
    },
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/launch", sorted(glob("launch/*.launch.py"))),
        (f"share/{NAME}/config", sorted(glob("config/*.yaml"))),
        (f"share/{NAME}/rviz", sorted(glob("rviz/*.rviz"))),
        (f"share/{NAME}/security", sorted(glob("security/*.xml"))),
    ],
    zip_safe=False,  # robot files are read as files
    install_requires=["numpy>=1.26", "scipy>=1.11", "PyYAML", "jsonschema"],
    extras_require=EXTRAS,
    entry_points={
        "console_scripts": [
            "hybrid-dynamics = hybrid_dynamics_cli.__main__:main",
            "hybrid_dynamics_node = hybrid_dynamics_ros.node.entry:main",
        ]
    },
)
