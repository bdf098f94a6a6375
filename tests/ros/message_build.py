"""Message packages for tests: built once from the files beside, for processes that tests start."""

from __future__ import annotations

import fcntl
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
MENDS = HERE.parents[1] / "msg_defs" / "cmake" / "pip_build.cmake"
# What rclpy and the middleware load.
TARGETS = (
    "{}__rosidl_generator_py",
    "{}__rosidl_typesupport_c",
    "{}__rosidl_typesupport_fastrtps_c",
    "{}__rosidl_typesupport_introspection_c",
    "{}_s__rosidl_typesupport_c",
)


def environment(package: str) -> dict[str, str]:
    """Variables with which a process of this Python finds a package: the folder of its files."""
    build = _built(package)
    first = {"PYTHONPATH": build / "rosidl_generator_py", "LD_LIBRARY_PATH": build}
    return {
        name: os.pathsep.join(filter(None, [str(path), os.environ.get(name)]))
        for name, path in first.items()
    }


def _built(package: str) -> Path:
    """The folder of the build, which is kept for other runs on this machine."""
    digest = hashlib.sha256(sys.prefix.encode())
    for path in sorted(path for path in (HERE / package).rglob("*") if path.is_file()):
        digest.update(path.read_bytes())
    name = f"{package}.{os.getuid()}.{digest.hexdigest()[:12]}"
    folder = Path(tempfile.gettempdir()) / name
    with folder.with_name(f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / "done").exists():
            shutil.rmtree(folder, ignore_errors=True)
            _build(package, folder)
            (folder / "done").touch()
    return folder


def _build(package: str, folder: Path) -> None:
    tools = Path(sys.prefix) / "bin"
    path = os.pathsep.join([str(tools), os.environ["PATH"]])
    settings = {
        "CMAKE_BUILD_TYPE": "Debug",
        "CMAKE_CXX_FLAGS_DEBUG": "-O0",
        "CMAKE_C_FLAGS_DEBUG": "-O0",
        f"CMAKE_PROJECT_{package}_INCLUDE": MENDS,
        "Python3_EXECUTABLE": sys.executable,
        "BUILD_TESTING": "OFF",
    }
    targets = [target.format(package) for target in TARGETS]
    defines = [f"-D{key}={value}" for key, value in settings.items()]
    configure = ["cmake", "-S", str(HERE / package), "-B", str(folder), "-G", "Ninja", *defines]
    build = ["cmake", "--build", str(folder), "--target", *targets]
    for command in (configure, build):
        done = subprocess.run(
            command,
            check=False,
            env={**os.environ, "PATH": path},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        assert done.returncode == 0, done.stdout[-4000:]
