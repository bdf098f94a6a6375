"""sdist and wheel hold everything, and what is installed from them runs far from the repository."""

from __future__ import annotations

import os
import shutil
import site
import subprocess
import sys
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

import hybrid_dynamics_core

pytest.importorskip("setuptools", "70.1")

ROOT = Path(__file__).resolve().parents[2]
OUTSIDE = ("build", "demo_output", "install", "log", "*.egg-info", "__pycache__", ".*")
BUILD = """
import sys
import setuptools.build_meta as backend

folder, *kinds = sys.argv[1:]
print(*[getattr(backend, f"build_{kind}")(folder) for kind in kinds])
"""


def copied(folder: Path, target: Path) -> Path:
    """The sources of a package, without what builds leave."""
    shutil.copytree(folder, target, ignore=shutil.ignore_patterns(*OUTSIDE))
    return target


def built(source: Path, target: Path, kind: str) -> str:
    """Name of the sdist or wheel, built with the setuptools that is installed."""
    target.mkdir(exist_ok=True)
    command = [sys.executable, "-c", BUILD, str(target), kind]
    done = subprocess.run(command, cwd=source, check=True, capture_output=True, text=True)
    return done.stdout.splitlines()[-1]


def unpacked(sdist: Path, target: Path) -> Path:
    """The one folder of an sdist."""
    with tarfile.open(sdist) as archive:
        # Python 3.11.2 and older have no filters
        archive.extraction_filter = getattr(tarfile, "data_filter", None)
        archive.extractall(target)  # noqa: S202  of our own build
    (folder,) = target.iterdir()
    return folder


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel that is made from the sdist."""
    folder = tmp_path_factory.mktemp("distributions")
    sdist = built(copied(ROOT, folder / "source"), folder / "dist", "sdist")
    source = unpacked(folder / "dist" / sdist, folder / "unpacked")
    return folder / "dist" / built(source, folder / "dist", "wheel")


@pytest.fixture(scope="module")
def machine(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An environment with the wheel and, beneath it, the libraries that tests have.

    Nothing of the repository is in it.
    """
    folder = tmp_path_factory.mktemp("machine")
    venv.create(folder, with_pip=False)
    pip = [sys.executable, "-m", "pip", "--python", str(folder / "bin" / "python")]
    install = [*pip, "install", "--quiet", "--no-deps", "--no-index", str(wheel)]
    subprocess.run(install, check=True, capture_output=True, env=plain())
    (packages,) = folder.glob("lib/python*/site-packages")
    folders = dict.fromkeys(site.getsitepackages())
    statements = ["import site", *(f"site.addsitedir({path!r})" for path in folders)]
    (packages / "beneath.pth").write_text("; ".join(statements) + "\n", encoding="utf-8")
    return folder


def plain() -> dict[str, str]:
    """The environment without what leads to the repository.

    pip would take a package that it finds there for installed.
    """
    settings = dict(os.environ)
    settings.pop("PYTHONPATH", None)
    settings.pop("VIRTUAL_ENV", None)
    return settings


def run(machine: Path, *command: str) -> str:
    """What a program of the environment writes, run elsewhere."""
    settings = plain()
    settings["PYTHONPATH"] = next(str(path) for path in machine.glob("lib/python*/site-packages"))
    settings["HYBRID_DYNAMICS_CACHE"] = str(machine / "cache")
    program = str(machine / "bin" / command[0])
    done = subprocess.run(
        [program, *command[1:]],
        cwd=machine,
        env=settings,
        check=True,
        capture_output=True,
        text=True,
    )
    return done.stdout


def files_below(folder: Path) -> set[Path]:
    """Files below a folder, relative to it, without what Python and builds leave."""
    files = set()
    for path in folder.rglob("*"):
        is_product = "__pycache__" not in path.parts and "egg-info" not in str(path)
        if path.is_file() and is_product:
            files.add(path.relative_to(folder))
    return files


@pytest.mark.sweep(sample="test_the_sdist_of_the_interfaces_holds_what_its_build_reads")
def test_the_wheel_holds_every_file_of_its_packages(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    for package in ("hybrid_dynamics_cli", "hybrid_dynamics_core", "hybrid_dynamics_ros"):
        files = files_below(ROOT / package)
        assert {f"{package}/{file}" for file in files} <= names
    messages = ROOT.glob("msg_defs/msg/*.msg")
    assert {f"hybrid_dynamics_ros/interfaces/{path.name}" for path in messages} <= names
    shared = {name.partition("/data/share/hybrid_dynamics_ros/")[2] for name in names}
    for pattern in ("launch/*.launch.py", "config/*", "rviz/*", "security/*"):
        files = [path for path in ROOT.glob(pattern) if path.is_file()]
        assert {str(path.relative_to(ROOT)) for path in files} <= shared
    assert any(name.endswith("resource_index/packages/hybrid_dynamics_ros") for name in names)
    assert any(name.endswith("licenses/LICENSE") for name in names)


@pytest.mark.sweep(sample="test_the_sdist_of_the_interfaces_holds_what_its_build_reads")
def test_what_is_installed_checks_a_shipped_robot(machine: Path) -> None:
    pytest.importorskip("click")
    output = run(machine, "hybrid-dynamics", "check", "forging_chu2020")
    assert "forging_chu2020" in output


@pytest.mark.sweep(sample="test_the_sdist_of_the_interfaces_holds_what_its_build_reads")
def test_what_is_installed_loads_closes_and_computes(machine: Path) -> None:
    code = """
import numpy as np
import hybrid_dynamics_core
from hybrid_dynamics_core import load, shipped_robots
print(hybrid_dynamics_core.__file__, len(shipped_robots()))
robot = load("forging_chu2020")
u, du = np.array([0.0, 0.10, 0.15, 0.0]), np.zeros(4)
one = robot.kernels.inverse_dynamics(u, du, du)
other = robot.inverse_dynamics(robot.close(u, du), du)
print(float(np.abs(one - other).max() / np.abs(other).max()))
"""
    where, error = run(machine, "python", "-c", code).splitlines()
    place, count = where.rsplit(" ", 1)
    assert Path(place).is_relative_to(machine)
    assert int(count) == len(hybrid_dynamics_core.shipped_robots())
    assert float(error) < 1e-12  # two orders of the same sums


def test_the_sdist_of_the_interfaces_holds_what_its_build_reads(tmp_path: Path) -> None:
    source = copied(ROOT / "msg_defs", tmp_path / "source")
    sdist = built(source, tmp_path / "dist", "sdist")
    copy = unpacked(tmp_path / "dist" / sdist, tmp_path / "unpacked")
    needed = files_below(source) - {Path("MANIFEST.in")}
    assert needed <= files_below(copy)
